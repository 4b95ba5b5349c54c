// One XM430-W350 as it behaves: control table, position loop in PWM counts, sensors with their
// quantum and age, thermal model, shutdown, bus watchdog. Electricity and mechanics of the motor
// are the plant's.
//
// Undisclosed by the maker and therefore chosen: time units of the D and I terms (one loop period
// of 1 ms), thermal constants, the overload rule, boot time. Modes other than position (3) and PWM
// (16) are refused.
#pragma once

#include <array>
#include <deque>

#include "tools/emulator/bus_device.h"
#include "tools/emulator/register_file.h"
#include "tools/plant/world.h"

namespace sanso::emulator {

/// What the servo's own electronics sense in this instant.
struct ServoSense {
  double position_rad = 0;
  double velocity_rad_s = 0;
  double current_A = 0;
  double supply_V = 0;
};

struct ServoDrive {
  bool powered = false;  // false: bridge open
  double duty = 0;       // -1..1
};

class Servo final : public BusDevice {
 public:
  /// Set up for a line of `baud` bits a second, one of the rates of xm430::kBaudRates. Errors:
  /// invalid_argument.
  Servo(std::uint8_t id, const plant::ServoParameters& parameters, std::int64_t baud = 2'000'000);

  /// One period of the servo's own loop.
  ServoDrive update(Nanoseconds now, double period_s, const ServoSense& sense);

  /// Supply switched on or off by the OpenCR board; on means a boot.
  void set_power(bool on, Nanoseconds now);
  /// Raises bits of Hardware Error Status; shuts down when the Shutdown register says so.
  void raise(std::uint8_t error_bits);
  /// Another speed on the line.
  void set_line_baud(std::int64_t baud) { line_baud_ = baud; }
  /// Factory state that a set-up OP3 does not have any more.
  void set_firmware(std::uint8_t version);
  void set_factory_register(const servo_bus::Register& r, std::int64_t raw) {
    registers_.set(r, raw);
  }
  /// Shuts down by overload as soon as it has booted for the first time.
  void shut_down_once() { shut_down_once_ = true; }
  void set_temperature(double celsius) { temperature_C_ = celsius; }
  /// What is left of a temperature after so long without torque [C].
  static double cooled(double celsius, double seconds);
  void set_cable(bool connected) { connected_ = connected; }

  bool torque_on() const { return registers_.get(servo_bus::xm430::kTorqueEnable) != 0; }
  /// Of the winding.
  double temperature_C() const { return temperature_C_; }
  const RegisterFile& registers() const { return registers_; }

  std::uint8_t id() const override { return id_; }
  std::uint16_t model() const override { return servo_bus::xm430::kModel; }
  std::uint8_t firmware() const override { return firmware_; }
  bool knows_fast_read() const override {
    return firmware_ >= servo_bus::xm430::kFirmwareWithFastRead;
  }
  /// With another rate in Baud Rate than the line's, all it hears is noise.
  bool listening() const override {
    return powered_ && connected_ && !booting_ && own_baud() == line_baud_;
  }
  Nanoseconds return_delay() const override;
  int status_return_level() const override;
  bool alert() const override;
  servo_bus::StatusError read(std::uint16_t address, std::span<std::uint8_t> out) const override;
  servo_bus::StatusError write(std::uint16_t address, std::span<const std::uint8_t> data,
                               Nanoseconds now) override;
  void reboot(Nanoseconds now) override;
  void heard(Nanoseconds now) override { last_heard_ = now; }
  void hold_write(HeldWrite write) override;
  servo_bus::StatusError run_held_write(Nanoseconds now) override;

 private:
  struct Sample {
    Nanoseconds time = 0;
    std::int32_t position_raw = 0;
    double velocity_rad_s = 0;
    double current_A = 0;
  };
  std::int64_t own_baud() const;
  void boot(Nanoseconds now, Nanoseconds duration);
  void publish(Nanoseconds now, const ServoSense& sense, std::int32_t position_raw);
  void watch(double period_s, const ServoSense& sense);
  void check_bus_watchdog(Nanoseconds now);
  void take_due_goals(Nanoseconds now);
  void follow_profile(double period_s);
  int position_loop_pwm(std::int32_t position_raw);
  servo_bus::StatusError refusal_of(const servo_bus::Register& r, const RegisterFile& before) const;
  void after_write(const servo_bus::Register& r, Nanoseconds now);

  std::uint8_t id_;
  plant::ServoParameters parameters_;
  std::int64_t line_baud_;
  RegisterFile registers_;
  std::uint8_t firmware_ = servo_bus::xm430::kFirmwareWithFastRead;
  bool shut_down_once_ = false;
  bool powered_ = false, connected_ = true, booting_ = false;
  Nanoseconds boot_done_ = 0;
  Nanoseconds last_heard_ = 0;
  double temperature_C_ = 30.0;
  double overload_s_ = 0;

  // position loop
  std::int32_t position_raw_ = 2048;  // newest, before the sensor delay
  double filtered_rate_ = 0;
  std::int32_t goal_raw_ = 2048;    // in effect, after the command delay
  double trajectory_raw_ = 2048;    // output of the profile generator
  double trajectory_rate_raw_ = 0;  // counts per second
  std::int32_t last_error_raw_ = 0;
  double integral_raw_ = 0;
  struct DueGoal {
    Nanoseconds time;
    std::int32_t goal_raw;
  };
  std::deque<DueGoal> due_goals_;
  std::deque<Sample> samples_;  // sensor delay line
  std::vector<HeldWrite> held_;
};

}  // namespace sanso::emulator
