// The real-time controller on the emulated robot in virtual time, without a host: tests put
// commands and layers into the hand-over themselves. The bytes of bus, IMU and pose source are the
// real ones.
#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

#include "firmware/app/controller.h"
#include "firmware/imu/imu_reader.h"
#include "firmware/imu/pose_reader.h"
#include "tools/emulator/emulated_robot.h"

namespace sanso::firmware::testing {

class RobotPort : public board::SerialPort {
 public:
  explicit RobotPort(emulator::EmulatedRobot& robot) : robot_(robot) {}
  /// What happens to one request, or to its reply.
  enum class Spoil { nothing, lose_request, damage_request, lose_reply, damage_reply };

  Status write(board::Bytes data) override {
    if (pulled) return Status::io_error;
    torque_off_writes += switches_torque_off(data) ? 1 : 0;
    const bool struck = ++writes == spoil_at;
    if (struck && spoil == Spoil::lose_request) return Status::ok;
    std::vector<std::uint8_t> bytes(data.begin(), data.end());
    if (struck && spoil == Spoil::damage_request) bytes[bytes.size() / 2] ^= 0x10;
    robot_.bus_write(bytes);
    return Status::ok;
  }
  Result<std::size_t> read(board::Buffer buffer, Nanoseconds deadline) override {
    if (pulled) return Status::io_error;
    for (;;) {
      std::size_t n = robot_.bus_read(buffer);
      const bool struck = writes == spoil_at;
      if (struck && spoil == Spoil::damage_reply && n > 0) buffer[n / 2] ^= 0x10;
      if (struck && spoil == Spoil::lose_reply) n = 0;
      if (n > 0 || robot_.now() >= deadline) return n;
      robot_.advance(std::min(deadline, robot_.next_bus_byte()));
    }
  }
  Status ready() override { return pulled ? Status::io_error : Status::ok; }
  bool pulled = false;
  Spoil spoil = Spoil::nothing;
  int writes = 0, spoil_at = -1;  // requests so far; the one that is struck
  int torque_off_writes = 0;      // requests that take the torque of a servo

 private:
  static bool switches_torque_off(board::Bytes packet) {
    constexpr std::uint8_t kTorqueEnable = 64;
    const auto code = static_cast<servo_bus::Instruction>(packet[7]);
    if (packet.size() < 12 || packet[8] != kTorqueEnable || packet[9] != 0) return false;
    if (code == servo_bus::Instruction::write) return packet[10] == 0;
    if (code != servo_bus::Instruction::sync_write) return false;
    for (std::size_t i = 13; i + 2 < packet.size(); i += 2)
      if (packet[i] == 0) return true;
    return false;
  }
  emulator::EmulatedRobot& robot_;
};

class RobotClock : public board::Clock {
 public:
  explicit RobotClock(emulator::EmulatedRobot& robot) : robot_(robot) {}
  Nanoseconds now() override { return robot_.now(); }

 private:
  emulator::EmulatedRobot& robot_;
};

class RobotImu : public board::HidSource {
 public:
  explicit RobotImu(emulator::EmulatedRobot& robot) : robot_(robot) {}
  board::Bytes descriptor() override { return emulator::EmulatedRobot::imu_descriptor(); }
  Status set_feature(board::Bytes report) override {
    return robot_.imu_set_feature(report) ? Status::ok : Status::io_error;
  }
  Result<std::size_t> read(board::Buffer buffer, Nanoseconds) override {
    return robot_.imu_read(buffer);
  }

 private:
  emulator::EmulatedRobot& robot_;
};

class RobotPose : public board::PoseSource {
 public:
  explicit RobotPose(emulator::EmulatedRobot& robot) : robot_(robot) {}
  Result<std::size_t> read(board::Buffer buffer, Nanoseconds) override {
    return robot_.pose_read(buffer);
  }

 private:
  emulator::EmulatedRobot& robot_;
};

/// Upright symmetric stand with knees bent (base height about 0.245 m), joint order of
/// model/joints.h [rad].
inline model::Input standing_pose() {
  model::Input q = model::Input::Zero();
  q[2] = 32.32 * kRadPerDeg;
  q[3] = -64.68 * kRadPerDeg;
  q[4] = -32.37 * kRadPerDeg;
  for (int j = 0; j < 6; ++j) q[6 + j] = -q[j];
  return q;
}

/// Primitives that stay in one pose for `duration_s`.
inline policy::PrimitiveSet still_primitives(const model::Input& q, double duration_s) {
  policy::PrimitiveSet set;
  set.duration_s = duration_s;
  for (int i = 0; i < policy::kNumScalarPrimitives; ++i) {
    const double y = i < 3 ? (i == 2 ? 0.245 : 0.0) : q[i - 3];
    set.scalar[static_cast<std::size_t>(i)].start = set.scalar[static_cast<std::size_t>(i)].goal =
        y;
  }
  return set;
}

class EmulatedController {
 public:
  explicit EmulatedController(const char* world = "nominal", const Settings& settings = {},
                              bool with_pose = true)
      : robot(plant::load_world(world), 1), settings_(settings), with_pose_(with_pose) {
    start();
  }

  /// A new program takes over the robot as it is; what the old one knew is gone.
  void start() {
    handover = std::make_unique<Handover>();
    imu_.emplace(settings_.imu, robot_imu_, clock_, handover->imu);
    pose_.emplace(with_pose_ ? &robot_pose_ : nullptr, clock_, handover->pose);
    controller = std::make_unique<Controller>(settings_, port, clock_, *handover);
    next_ = std::max(next_, robot.now());
  }

  void tick() {
    robot.advance(next_);
    if (!without_hid) imu_->poll(0);
    pose_->poll(0);
    handover->host_heard.store(host_alive ? robot.now() : heard_);
    if (host_alive) heard_ = robot.now();
    controller->tick(next_);
    next_ = std::max(next_ + kTickPeriod, robot.now());
    drain();
  }
  void ticks(int n) {
    for (int i = 0; i < n; ++i) tick();
  }
  /// Ticks until the state is reached or `seconds` have passed; true when reached.
  bool run_until(wire::SupervisorState state, double seconds) {
    for (int i = 0; i < seconds * 100 && controller->state() != state; ++i) tick();
    return controller->state() == state;
  }
  /// Sends a command and ticks until it is answered; its acknowledgement.
  wire::CommandAck command(wire::CommandKind kind, std::uint32_t trial = 1,
                           std::int32_t duration = 0,
                           std::uint8_t layers = policy::LayerSwitches::kAll) {
    constexpr int kMostTicks = 100;
    handover->commands.push({++sequence_, kind, trial, layers, duration});
    tick();
    for (int i = 1; i < kMostTicks && last_ack.sequence != sequence_; ++i) tick();
    return last_ack;
  }
  void upload(const policy::PrimitiveSet& set) {
    handover->primitives.back() = set;
    handover->primitives.publish();
  }
  /// A person puts the robot into `pose` and holds it until it stands by itself: boot, self-test,
  /// arm, hold.
  /// True when holding, let go and settled.
  bool stand(const model::Input& pose = standing_pose(), double motion_s = 3.0,
             emulator::Placement where = {}) {
    std::array<double, model::kNumJoints> legs{};
    std::copy_n(pose.data(), model::kNumJoints, legs.begin());
    where.q = emulator::with_legs(legs).q;
    robot.place(where);
    robot.hold(true);
    upload(still_primitives(pose, motion_s));
    if (!run_until(wire::SupervisorState::idle, 10)) return false;
    if (command(wire::CommandKind::arm).accepted == 0) return false;
    if (!run_until(wire::SupervisorState::hold, 15)) return false;
    ticks(30);
    robot.hold(false);
    ticks(100);
    return controller->state() == wire::SupervisorState::hold;
  }
  const wire::Observation& seen() const { return controller->observation(); }
  model::State truth() const {
    const auto x = robot.truth().leg_state();
    model::State state;
    for (int i = 0; i < model::kNx; ++i) state[i] = x[static_cast<std::size_t>(i)];
    return state;
  }

  emulator::EmulatedRobot robot;
  RobotPort port{robot};
  std::unique_ptr<Handover> handover;
  bool host_alive = true;
  bool without_hid = false;  // no HID sensor is read
  wire::CommandAck last_ack;

 private:
  void drain() {
    wire::Observation observation;
    while (handover->observations.pop(observation)) {
    }
    while (handover->acks.pop(last_ack)) {
    }
    LogRecord record;
    while (handover->log.pop(record)) {
    }
  }
  RobotClock clock_{robot};
  RobotImu robot_imu_{robot};
  RobotPose robot_pose_{robot};
  Settings settings_;
  bool with_pose_;
  std::optional<ImuReader> imu_;
  std::optional<PoseReader> pose_;
  Nanoseconds next_ = 0;
  Nanoseconds heard_ = 0;
  std::uint32_t sequence_ = 0;

 public:
  std::unique_ptr<Controller> controller;
};

}  // namespace sanso::firmware::testing
