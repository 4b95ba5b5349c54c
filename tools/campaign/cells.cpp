// What can go wrong, and what the controller owes the robot then. Expectations are stated here, not
// taken from the controller's tables.
#include <Eigen/Geometry>

#include "tools/campaign/scenario.h"

namespace sanso::campaign {
namespace {

using emulator::FaultKind;
using firmware::Fault;

constexpr double kForEver_s = 1e3;
constexpr double kLossShare = 0.01;

Trouble fault(FaultKind kind, int id = 0, double seconds = kForEver_s, double amount = 0,
              double probability = 1.0) {
  emulator::Fault f;
  f.kind = kind;
  f.id = id;
  f.stop = from_seconds(seconds);
  f.amount = amount;
  f.probability = probability;
  Trouble trouble;
  trouble.fault = f;
  return trouble;
}
Trouble act(Act what) {
  Trouble trouble;
  trouble.act = what;
  return trouble;
}

Expected completes() { return {{}, {Ending::completes}, 0, false, 0}; }
Expected held(Fault fault, double within_s) {
  return {{fault}, {Ending::held}, within_s, false, 0};
}
Expected lowered(Fault fault, double within_s) {
  return {{fault}, {Ending::lowered}, within_s, false, 0};
}
/// The robot cannot be kept up, or nobody knows: down and without torque if it falls.
Expected may_fall(std::vector<Fault> faults, double within_s, std::vector<Ending> endings) {
  return {std::move(faults), std::move(endings), within_s, true, 0};
}

// bounds of the reaction: the settings' times, a tick to read and one to judge; for the IMU the
// report that is under way, 10 ms
constexpr double kSilent_s = 0.12, kImuSilent_s = 0.08, kImuFrozen_s = 0.13;
constexpr double kSlowRead_s = 0.9;  // the slow reads come round once in 0.8 s

void add_bus(std::vector<Cell>& all) {
  const Expected dead = held(Fault::bus_silent, kSilent_s);
  // nothing can be said to the servos: they hold a pose that was one of a step
  const Expected dead_in_step =
      may_fall({Fault::bus_silent}, kSilent_s, {Ending::held, Ending::fell});
  // they are deaf to nothing: whoever falls must be let go
  const Expected mute_in_step =
      may_fall({Fault::bus_silent}, kSilent_s, {Ending::held, Ending::limp});
  const auto add = [&](Word word, Direction direction, const char* what, Trouble trouble,
                       const Expected& calm, const Expected& walk) {
    all.push_back({word, "bus", direction, what, std::move(trouble), calm, walk});
  };
  using D = Direction;
  add(Word::off, D::reply, "", fault(FaultKind::bus_drop), dead, mute_in_step);
  add(Word::off, D::request, "", fault(FaultKind::request_drop), dead, dead_in_step);
  add(Word::off, D::none, "unplugged", act(Act::pull_bus), held(Fault::bus_gone, 0.03),
      may_fall({Fault::bus_gone}, 0.03, {Ending::held, Ending::fell}));
  add(Word::garbage, D::reply, "a bit of each", fault(FaultKind::bus_corrupt), dead, mute_in_step);
  add(Word::garbage, D::request, "a bit of each", fault(FaultKind::request_corrupt), dead,
      dead_in_step);
  add(Word::garbage, D::reply, "cut short", fault(FaultKind::bus_truncate), dead, mute_in_step);
  add(Word::delayed, D::reply, "20 ms", fault(FaultKind::bus_delay, 0, kForEver_s, 0.02), dead,
      mute_in_step);
  add(Word::slow, D::reply, "0.1 ms more a servo", fault(FaultKind::bus_delay, 0, kForEver_s, 1e-4),
      completes(), completes());
  const struct {
    FaultKind kind;
    Direction direction;
    const char* what;
    double amount;
  } kLosses[] = {{FaultKind::bus_drop, D::reply, "lost", 0},
                 {FaultKind::bus_corrupt, D::reply, "a bit flipped", 0},
                 {FaultKind::bus_truncate, D::reply, "cut short", 0},
                 {FaultKind::bus_delay, D::reply, "6 ms late", 0.006},
                 {FaultKind::bus_duplicate, D::reply, "twice", 0},
                 {FaultKind::bus_garbage, D::reply, "bytes before it", 0},
                 {FaultKind::request_drop, D::request, "lost", 0},
                 {FaultKind::request_corrupt, D::request, "a bit flipped", 0}};
  for (const auto& loss : kLosses)
    add(Word::intermittent, loss.direction, loss.what,
        fault(loss.kind, 0, kForEver_s, loss.amount, kLossShare), completes(), completes());
  add(Word::wrong, D::none, "another master", fault(FaultKind::foreign_master),
      held(Fault::bus_foreign, 0.5),
      may_fall({Fault::bus_foreign}, 0.5, {Ending::held, Ending::limp}));
}

void add_servos(std::vector<Cell>& all) {
  using D = Direction;
  const auto add = [&](int id, Word word, Direction direction, const char* what, Trouble trouble,
                       const Expected& calm, const Expected& walk) {
    all.push_back(
        {word, "servo " + std::to_string(id), direction, what, std::move(trouble), calm, walk});
  };
  const std::vector<Ending> kStopped{Ending::held, Ending::limp};
  for (const int id : {7, 14})  // the first of the reading order, and a knee
    add(id, Word::off, D::none, "cable", fault(FaultKind::servo_silent, id),
        held(Fault::servo_silent, kSilent_s), may_fall({Fault::servo_silent}, kSilent_s, kStopped));
  add(5, Word::off, D::none, "cable of an elbow", fault(FaultKind::servo_silent, 5), completes(),
      completes());
  for (const int id : {13, 17})
    add(id, Word::off, D::none, "overload shuts it down", fault(FaultKind::servo_overload, id),
        may_fall({Fault::overload, Fault::torque_lost, Fault::fallen}, kSlowRead_s, kStopped),
        may_fall({Fault::overload, Fault::torque_lost, Fault::fallen}, kSlowRead_s, kStopped));
  const std::vector<Ending> kDown{Ending::lowered, Ending::limp};
  add(13, Word::wrong, D::none, "77 C", fault(FaultKind::servo_hot, 13, kForEver_s, 77),
      lowered(Fault::over_temperature, kSlowRead_s),
      may_fall({Fault::over_temperature}, kSlowRead_s, kDown));
  add(13, Word::off, D::none, "85 C shuts it down", fault(FaultKind::servo_hot, 13),
      may_fall({Fault::over_temperature}, kSlowRead_s, kDown),
      may_fall({Fault::over_temperature}, kSlowRead_s, kDown));
  add(14, Word::wrong, D::reply, "zeros for ever", fault(FaultKind::reply_zeros, 14),
      held(Fault::servo_silent, kSilent_s), may_fall({Fault::servo_silent}, kSilent_s, kStopped));
  for (const int id : {7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18})
    add(id, Word::wrong, D::reply, "zeros for 5 ticks", fault(FaultKind::reply_zeros, id, 0.05),
        completes(), completes());
  add(14, Word::intermittent, D::reply, "lost", fault(FaultKind::bus_drop, 14, kForEver_s, 0, 0.1),
      completes(), completes());
}

void add_supply(std::vector<Cell>& all) {
  const auto add = [&](Word word, const char* what, Trouble trouble, const Expected& calm,
                       const Expected& walk) {
    all.push_back({word, "supply", Direction::none, what, std::move(trouble), calm, walk});
  };
  const Expected dies = may_fall({Fault::bus_silent, Fault::torque_lost, Fault::fallen}, kSilent_s,
                                 {Ending::limp, Ending::held, Ending::fell});
  add(Word::off, "6 V for 30 ms", fault(FaultKind::brown_out, 0, 0.03, 6.0), dies, dies);
  add(Word::wrong, "9.5 V for 60 ms", fault(FaultKind::brown_out, 0, 0.06, 9.5), completes(),
      completes());
  add(Word::wrong, "9.5 V for 0.4 s", fault(FaultKind::brown_out, 0, 0.4, 9.5),
      lowered(Fault::under_voltage, 0.4),
      may_fall({Fault::under_voltage}, 0.4, {Ending::lowered, Ending::limp}));
  add(Word::wrong, "9 V for ever", fault(FaultKind::brown_out, 0, kForEver_s, 9.0),
      lowered(Fault::under_voltage, 0.4),
      may_fall({Fault::under_voltage}, 0.4, {Ending::lowered, Ending::limp}));
}

void add_sensors(std::vector<Cell>& all) {
  const std::vector<Ending> kDown{Ending::lowered, Ending::limp};
  const auto add = [&](const char* device, Word word, const char* what, Trouble trouble,
                       const Expected& calm, const Expected& walk) {
    all.push_back({word, device, Direction::none, what, std::move(trouble), calm, walk});
  };
  add("imu", Word::off, "", fault(FaultKind::imu_silent), lowered(Fault::imu_silent, kImuSilent_s),
      may_fall({Fault::imu_silent}, kImuSilent_s, kDown));
  add("imu", Word::stuck, "", fault(FaultKind::imu_frozen),
      lowered(Fault::imu_frozen, kImuFrozen_s), may_fall({Fault::imu_frozen}, kImuFrozen_s, kDown));
  add("imu", Word::intermittent, "silent for 30 ms", fault(FaultKind::imu_silent, 0, 0.03),
      completes(), completes());
  add("pose", Word::off, "", fault(FaultKind::pose_lost), completes(), completes());
  add("host", Word::off, "", act(Act::lose_host), completes(), completes());
  const Expected stopped = may_fall({Fault::emergency_stop}, 0.03, {Ending::limp});
  add("person", Word::off, "emergency stop", act(Act::emergency_stop), stopped, stopped);
}

/// The 23 ways to screw the sensor on by right angles that are not the one in the settings.
void add_mountings(std::vector<Cell>& all) {
  // refused before torque, or found while the feet still carry: a robot that believes a turned
  // sensor falls
  const Expected found{
      {Fault::imu_implausible}, {Ending::refused, Ending::lowered}, kForEver_s, false, 0};
  constexpr std::array kAxes{"x", "y", "z"};
  constexpr int kOrders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
  for (const auto& order : kOrders)
    for (int signs = 0; signs < 8; ++signs) {
      Eigen::Matrix3d R_base_sensor = Eigen::Matrix3d::Zero();
      std::string what = "mounted";
      for (int axis = 0; axis < 3; ++axis) {
        const bool minus = (signs >> axis & 1) != 0;
        R_base_sensor(order[axis], axis) = minus ? -1 : 1;
        what += std::string(minus ? " -" : " +") + kAxes[static_cast<std::size_t>(order[axis])];
      }
      if (R_base_sensor.determinant() < 0 || R_base_sensor.isIdentity()) continue;
      const Eigen::Quaterniond quat(R_base_sensor);
      Trouble trouble = act(Act::turn_imu);
      trouble.quat_base_sensor = {quat.w(), quat.x(), quat.y(), quat.z()};
      all.push_back({Word::wrong, "imu", Direction::none, what, trouble, found, found});
    }
}

}  // namespace

std::vector<Cell> cells() {
  std::vector<Cell> all;
  add_bus(all);
  add_servos(all);
  add_supply(all);
  add_sensors(all);
  add_mountings(all);
  return all;
}

}  // namespace sanso::campaign
