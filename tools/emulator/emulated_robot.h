// The emulated "real" robot: physics, servos, OpenCR, IMU and pose source behind the bytes that the
// real ones speak.
// Virtual time: nothing happens until advance(). The same class serves the in-process robot and
// sanso-emulator.
//
//   EmulatedRobot robot(plant::load_world("lab"), 1);
//   robot.bus_write(packet);                       // the master sends at robot.now()
//   robot.advance(robot.next_bus_byte());          // wait as poll() would
//   robot.bus_read(buffer);
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "shared/base/time.h"
#include "tools/emulator/fault_plan.h"
#include "tools/emulator/hand.h"
#include "tools/emulator/support.h"
#include "tools/plant/world.h"

namespace sanso::emulator {

using plant::kNumServos;  // index = servo id - 1
inline constexpr Nanoseconds kNever = INT64_MAX;

/// What really is, read from the physics. For tests, costs and reports; no controller may see it.
struct Truth {
  Nanoseconds time = 0;
  plant::Vec3 p_world_base{};           // m
  plant::Quat quat_world_base{};        // w x y z
  plant::Vec3 v_base_in_world{};        // m/s
  plant::Vec3 w_base_in_base{};         // rad/s
  std::array<double, kNumServos> q{};   // link angle, rad
  std::array<double, kNumServos> dq{};  // rad/s
  // motor torque at the output before friction, N m
  std::array<double, kNumServos> torque{};
  std::array<bool, kNumServos> torque_on{};          // as the servo's register says
  std::array<plant::Vec3, 2> foot_force_in_world{};  // ground on foot, right then left, N
  std::array<int, 2> foot_contacts{};                // touching sole points, right then left
  // m, of the lowest sole point from what is below it, right then left
  std::array<double, 2> foot_clearance_m{};
  // anything but feet on the ground: a fallen robot has some
  int other_contacts = 0;
  double supply_V = 0;

  /// [p_world_base | quat_world_base | 12 leg angles | v_base_in_world | w_base_in_base | 12 leg
  /// rates], legs in the order right hip_yaw, hip_roll, hip_pitch, knee, ank_pitch, ank_roll, then
  /// left.
  std::array<double, 37> leg_state() const;
};

/// Where one servo differs from those of a set-up OP3: as the factory delivers it, or worn.
struct ServoSetup {
  int id = 0;
  std::int64_t baud = 0;     // 0: the line's
  int return_delay_raw = 1;  // the factory's is 250
  int firmware = 45;
  bool shut_down = false;     // by overload, until it is rebooted
  double horn_error_rad = 0;  // the servo reads the link angle plus this
};

/// How a person puts the robot on the ground: joint angles by servo id, feet flat and touching.
struct Placement {
  std::array<double, kNumServos> q{};  // rad, index = servo id - 1
  double x_m = 0, y_m = 0, yaw_rad = 0;
};

/// The maker's standing pose.
Placement walkready();
/// The deep crouch the robot wakes up in.
Placement crouch();
/// walkready() arms and head with these leg angles (order of Truth::leg_state).
Placement with_legs(const std::array<double, 12>& leg_angles_rad);

class EmulatedRobot {
 public:
  /// Standing in walkready, servo power and torque off, held upright by a person who lets go one
  /// second after all leg servos hold torque (or at hold(false)).
  EmulatedRobot(const plant::World& world, std::uint64_t seed, std::int64_t baud = 2'000'000);
  ~EmulatedRobot();
  EmulatedRobot(EmulatedRobot&&) noexcept;
  EmulatedRobot& operator=(EmulatedRobot&&) noexcept;

  Nanoseconds now() const;
  /// Runs the world up to `time` (no effect when it is past).
  void advance(Nanoseconds time);

  // Servo bus. Bytes written at now() travel at the baud rate; replies arrive byte by byte in
  // virtual time.
  void bus_write(std::span<const std::uint8_t> bytes);
  std::size_t bus_read(std::span<std::uint8_t> out);  // what has arrived by now(); 0 = nothing
  /// When to look again: arrival of the next reply byte, or of an instruction at the devices;
  /// kNever when the line is quiet.
  Nanoseconds next_bus_byte() const;

  // IMU as a HID device: input reports (id 1 accelerometer, 2 gyro, 3 orientation), silent until
  // set_feature asks.
  std::size_t imu_read(std::span<std::uint8_t> out);  // one report, 0 = none waiting
  bool imu_set_feature(std::span<const std::uint8_t> report);
  std::size_t imu_get_feature(std::uint8_t report_id, std::span<std::uint8_t> out) const;
  static std::span<const std::uint8_t> imu_descriptor();

  /// Tracking camera: one report of shared/base/pose_report.h, 0 = none waiting.
  std::size_t pose_read(std::span<std::uint8_t> out);

  /// A person puts the robot there, at rest. Servos keep torque, gains and goals.
  void place(const Placement& placement);
  /// A person holds the robot upright (true) or lets go (false).
  void hold(bool held);
  bool held() const;
  /// A person holds the robot upright until one second after all leg servos hold torque, as at the
  /// start.
  void hold_until_standing();

  /// Force [N] and torque [N m] at the torso's origin, world axes, from `start` to `stop`.
  void push(const plant::Vec3& force_in_world, const plant::Vec3& torque_in_world,
            Nanoseconds start, Nanoseconds stop);

  /// A hand that keeps the robot from rolling away, from when nobody holds it any more until
  /// push_off(), then pushes it and lets go.
  void lend_hand(const Push& push);
  void push_off();

  /// A hand that holds the torso on its way, until changed; it acts once nobody holds the base.
  void support(const Support& support);

  /// Presses (or releases) OpenCR's buttons: bits of servo_bus::opencr::kButton*.
  void press(std::uint8_t buttons);

  /// Before the supply is switched on. Throws plant::WorldError for an id or speed that none has.
  void set_up(const ServoSetup& setup);
  /// The speed at which the master talks from now on.
  void set_line_baud(std::int64_t baud);

  /// Heat and charge, as they are now; and a robot that begins with those of an earlier one, rested
  /// for the world's rest_s.
  plant::Condition condition() const;
  void begin_rested(const plant::Condition& before);

  FaultPlan& faults();
  Truth truth() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sanso::emulator
