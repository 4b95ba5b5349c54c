// Master of the servo bus. Cyclic part: one (fast) sync read of current, velocity and position, one
// sync write of goals, and one slow read of a single servo. Single transactions serve the start-up
// (bus_setup.h). Every wait has a deadline; what arrives too late is drained before the next
// request.
#pragma once

#include <span>

#include "firmware/board/board.h"
#include "firmware/bus/readings.h"
#include "firmware/config/settings.h"
#include "shared/model/state_layout.h"
#include "shared/servo_bus/encode.h"
#include "shared/servo_bus/parser.h"
#include "shared/servo_bus/xm430.h"

namespace sanso::firmware {

/// The same registers of every servo, by slot.
struct ServoBlocks {
  static constexpr std::size_t kMaxBytes = 24;
  std::array<std::array<std::uint8_t, kMaxBytes>, kNumServos> data{};
  std::array<bool, kNumServos> got{};
};

class BusMaster {
 public:
  BusMaster(const BusSettings& settings, board::SerialPort& port, board::Clock& clock);

  // --- cyclic ---
  /// Reads the first `slots` servos (12: legs; 20: all) and updates readings; a servo that does not
  /// answer keeps its last values and grows older.
  void read_feedback(int slots, ServoReadings& readings);
  /// Reads `bytes` (at most ServoBlocks::kMaxBytes) from `address` on of all servos in one request;
  /// how many gave a good reply.
  int read_block(std::uint16_t address, std::uint16_t bytes, ServoBlocks& blocks);
  /// Sends goals to slots 0 .. goals_raw.size()-1.
  Status write_goals(std::span<const std::int32_t> goals_raw);
  /// Reads voltage, temperature, torque state and hardware error of one servo, taking turns; servos
  /// with an alert first.
  void slow_read(ServoReadings& readings);
  /// Switches the torque of all servos by one sync write (no reply).
  Status write_torque(bool on, ServoReadings& readings);

  struct Heard {
    int bytes = 0;
    int packets = 0;  // whole ones, of a master or of a servo that somebody has asked
  };
  /// What has come since the last call, for as long as nothing has been asked.
  Heard listen();
  /// Whole instructions of somebody else that were on the bus.
  std::uint32_t foreign() const { return counters_.foreign; }
  /// Writes `size` bytes of each servo's value from `address` on, all in one request (no reply).
  Status write_each(std::uint16_t address, std::uint8_t size,
                    std::span<const std::int32_t> values_raw);

  // --- single transactions ---
  struct Identity {
    std::uint16_t model = 0;
    std::uint8_t firmware = 0;
  };
  Result<Identity> ping(std::uint8_t id);
  /// Register value, sign-extended. timeout, io_error, or rejected (the device answered with an
  /// error).
  Result<std::int64_t> read_register(std::uint8_t id, std::uint16_t address, std::uint8_t size,
                                     bool is_signed = false);
  Status write_register(std::uint8_t id, std::uint16_t address, std::uint8_t size,
                        std::int64_t value);

  /// Buttons, voltage and the IMU of the OpenCR board, in one request.
  Result<BoardReading> read_board();
  /// Starts the servo anew: the only way out of a shutdown but switching the supply. It is silent
  /// for about a second afterwards.
  Status reboot(std::uint8_t id);

  /// Counts of a servo's register to counts of the joint, and back: the servos' horns are put on
  /// crookedly (settings: offset_rad). Readings and goals of this class are the joint's.
  std::int32_t joint_raw(int slot, std::int32_t servo_raw) const {
    return servo_raw - offset_raw_[static_cast<std::size_t>(slot)];
  }
  std::int32_t servo_raw(int slot, std::int32_t joint_raw) const {
    return joint_raw + offset_raw_[static_cast<std::size_t>(slot)];
  }

  /// Fast sync read from now on (all servos are known to understand it).
  void use_fast_read(bool on) { fast_ = on; }
  bool fast_read() const { return fast_; }
  /// Without torque a joint may be put elsewhere by hand, or the whole robot: readings that jump
  /// but agree with each other are believed after five of them. With torque they never are.
  void expect_torque(bool on) { torque_expected_ = on; }
  const BusCounters& counters() const { return counters_; }
  /// Asks whether a lost port is back; opening it is not the tick's work.
  Status ready() { return port_.ready(); }

 private:
  enum class Wait : std::uint8_t { more, done };

  Status send(Nanoseconds timeout, std::size_t longest_reply);
  Status write_request();
  void let_line_fall_silent();
  template <class OnPacket>
  Status collect(OnPacket&& on_packet);
  Status transact(std::uint8_t id);  // sends request_, leaves the status of `id` in packet_
  void drain();
  Heard take_what_came();
  int look_for_foreigners(std::span<const std::uint8_t> bytes);
  void count_foreigner(servo_bus::ParseEvent event);
  template <class OnBlock>
  Status read_many(int slots, std::uint16_t address, std::uint16_t bytes, OnBlock&& on_block);
  template <class OnBlock>
  void take_fast_reply(int slots, std::size_t bytes, OnBlock&& on_block);
  bool jumped(std::size_t s, double position_rad, const ServoReading& last);
  void store(int slot, std::uint8_t error, std::span<const std::uint8_t> data,
             ServoReadings& readings);
  void age_the_silent(int slots, ServoReadings& readings);
  void order_silent_last(int slots);
  void slow_read_supply(int slot, ServoReadings& readings);
  void slow_read_torque(int slot, ServoReadings& readings);

  BusSettings settings_;
  board::SerialPort& port_;
  board::Clock& clock_;
  servo_bus::PacketBuffer request_;
  servo_bus::PacketParser parser_;
  servo_bus::Packet packet_;
  servo_bus::PacketBuffer raw_;  // bytes received since the request
  Nanoseconds deadline_ = 0;
  bool fast_ = false;
  bool overdue_ = false;  // the last request was not answered in time: its reply may still come
  bool alert_turn_ = false;
  int slow_turn_ = 0;
  std::array<std::uint8_t, kNumServos> order_{};  // slots in the order of asking
  std::array<bool, kNumServos> got_{};
  std::array<std::uint16_t, kNumServos> silent_ticks_{};  // without even a reply that cannot be
  bool torque_expected_ = true;
  std::array<double, kNumServos> refused_rad_{};    // position of the last reading that jumped
  std::array<std::uint8_t, kNumServos> settled_{};  // refused readings in a row that agree
  std::array<std::int32_t, kNumServos> offset_raw_{};
  BusCounters counters_;
};

}  // namespace sanso::firmware
