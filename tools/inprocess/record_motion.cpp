// Goals go over the bus every 10 ms with the gains of the lower layer; the hand's carriage follows
// the robot, level across and along the line through both axles.
#include "tools/inprocess/record_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/motion/dmp_fit.h"
#include "host/motion/make/retarget.h"
#include "shared/base/time.h"
#include "shared/grounds/ground_file.h"
#include "shared/model/joints.h"
#include "shared/servo_bus/encode.h"
#include "shared/servo_bus/opencr.h"
#include "shared/servo_bus/units.h"
#include "shared/servo_bus/xm430.h"
#include "tools/emulator/emulated_robot.h"
#include "tools/inprocess/carriage.h"
#include "tools/plant/world.h"

namespace sanso::inprocess {
namespace {

namespace xm = servo_bus::xm430;
using motion::MotionError;

constexpr int kHoldTicks = 60;  // in the person's hands, then in the hand alone
constexpr int kPositionGain = 560;

class Bus {
 public:
  explicit Bus(emulator::EmulatedRobot& robot) : robot_(robot) {}

  void power() {
    const std::uint8_t on = 1;
    servo_bus::encode_write(wire_, servo_bus::opencr::kId, servo_bus::opencr::kServoPower,
                            {&on, 1});
    send(1100 * kMillisecond);
  }
  void write(const servo_bus::Register& r, const std::array<double, emulator::kNumServos>& q,
             std::int64_t value = -1) {
    std::vector<std::uint8_t> ids, data;
    for (int i = 0; i < emulator::kNumServos; ++i) {
      ids.push_back(static_cast<std::uint8_t>(i + 1));
      std::uint8_t bytes[4];
      servo_bus::put_le(bytes, r.size, value < 0 ? servo_bus::position_raw(q[i]) : value);
      data.insert(data.end(), bytes, bytes + r.size);
    }
    servo_bus::encode_sync_write(wire_, r.address, r.size, ids, data);
    send(kMillisecond);
  }

 private:
  void send(Nanoseconds wait) {
    robot_.bus_write(wire_.view());
    robot_.advance(robot_.now() + wait);
  }
  emulator::EmulatedRobot& robot_;
  servo_bus::PacketBuffer wire_;
};

model::State measured(const emulator::Truth& truth) {
  const auto x = truth.leg_state();
  return Eigen::Map<const model::State>(x.data());
}

std::array<double, emulator::kNumServos> goals_of(const model::Input& legs) {
  std::array<double, 12> q{};
  for (int j = 0; j < model::kNumJoints; ++j) q[static_cast<std::size_t>(j)] = legs[j];
  return emulator::with_legs(q).q;
}

class Recorder {
 public:
  Recorder(const motion::RecordRecipe& recipe, const motion::Motion& like, const std::string& world,
           const std::string& ground)
      : recipe_(recipe),
        like_(like),
        carriage_(grounds::load_ground(ground), recipe.hand),
        robot_(plant::load_world(world), 1),
        start_(like.primitives.start_state()) {}

  /// Every 10 ms, from when the hand pushes the robot off.
  motion::Trajectory run(double duration_s, double& largest_lag_rad) {
    emulator::Placement at = emulator::with_legs({});
    at.q = goals_of(model::joints(start_));
    robot_.place(at);
    Bus bus(robot_);
    robot_.hold(true);
    bus.power();
    bus.write(xm::kPositionPGain, {}, kPositionGain);
    bus.write(xm::kGoalPosition, at.q);
    bus.write(xm::kTorqueEnable, {}, 1);
    until(robot_.now() + kHoldTicks * kTickPeriod);
    robot_.hold(false);
    held_at_ = robot_.truth().p_world_base;
    for (int k = 0; k < kHoldTicks; ++k) tick(-1.0);
    motion::Oscillators oscillators(recipe_);
    motion::Trajectory out;
    const int ticks = static_cast<int>(std::lround(duration_s / kTick_s));
    for (int k = 0; k <= ticks; ++k) {
      const emulator::Truth truth = robot_.truth();
      if (truth.other_contacts > 0)
        throw MotionError(
            fmt::format("the robot fell in the hand after {:.2f} s; lower the "
                        "amplitudes or raise `hand`",
                        k * kTick_s));
      out.x.push_back(measured(truth));
      const model::Input target = model::joints(start_) + oscillators.offset();
      largest_lag_rad =
          std::max(largest_lag_rad, (target - model::joints(out.x.back())).cwiseAbs().maxCoeff());
      bus.write(xm::kGoalPosition, goals_of(target));
      tick(k * kTick_s);
      oscillators.step(kTick_s);
    }
    return out;
  }

 private:
  void until(Nanoseconds time) { robot_.advance(time); }

  /// One tick of the hand, moved every millisecond; `t`: since the push, negative before it.
  void tick(double t) {
    const Nanoseconds end = (robot_.now() / kTickPeriod + 1) * kTickPeriod;
    while (robot_.now() < end) {
      robot_.support(carriage(t));
      until(std::min(end, robot_.now() + kMillisecond));
    }
  }

  emulator::Support carriage(double t) {
    const emulator::Truth truth = robot_.truth();
    emulator::Support s = carriage_.beside(truth);
    s.p_world_carriage[1] = held_at_[1];
    const double push_s = like_.skate ? like_.skate->push_s : 0.0;
    const double push_m_s = like_.skate ? like_.skate->push_m_s : 0.0;
    if (!like_.skate || t < push_s) {  // it holds along as well, then lets roll
      const double u = std::max(0.0, t);
      const double speed = push_s > 0.0 ? push_m_s * u / push_s : 0.0;
      s.p_world_carriage[0] = held_at_[0] + 0.5 * speed * u;
      s.v_carriage_in_world[0] = speed;
      s.stiffness_N_m[0] = s.stiffness_N_m[1];
      s.damping_Ns_m[0] = s.damping_Ns_m[1];
    }
    return s;
  }

  const motion::RecordRecipe& recipe_;
  const motion::Motion& like_;
  Carriage carriage_;
  emulator::EmulatedRobot robot_;
  model::State start_;
  plant::Vec3 held_at_{};
};

/// Mean of the last cycles; the first sample's phase closes it.
motion::Trajectory mean_cycle(const motion::Trajectory& robot, int period_ticks, int cycles) {
  const int last = static_cast<int>(robot.x.size()) - 1;
  if (last < (cycles + 1) * period_ticks)
    throw MotionError(
        fmt::format("{} cycles of {:.2f} s and one to settle do not fit into {:.2f} s", cycles,
                    period_ticks * kTick_s, last * kTick_s));
  motion::Trajectory out;
  for (int k = 0; k <= period_ticks; ++k) {
    model::State sum = model::State::Zero();
    for (int c = 1; c <= cycles; ++c) {
      const int first = last - c * period_ticks;
      model::State x = robot.x[first + k];
      x[model::kXPos] -= robot.x[first][model::kXPos];
      if (x[model::kXQuat] < 0.0) x.segment<4>(model::kXQuat) *= -1.0;
      sum += x;
    }
    sum /= cycles;
    sum.segment<4>(model::kXQuat).normalize();
    out.x.push_back(sum);
  }
  motion::differentiate_poses(out);
  return out;
}

void fit(RecordedMotion& made, const motion::RecordRecipe& recipe, double duration_s) {
  policy::PrimitiveSet& set = made.motion.primitives;
  if (recipe.rhythmic) {
    const int period = static_cast<int>(std::lround(100.0 / recipe.oscillators[0].frequency_Hz));
    made.wanted = mean_cycle(made.robot, period, recipe.cycles);
    const int basis = std::max(10, static_cast<int>(recipe.basis_per_second * kTick_s * period));
    set = motion::fit_rhythmic(made.wanted, basis, duration_s);
  } else {
    made.wanted = made.robot;
    motion::differentiate_poses(made.wanted);
    constexpr double kFadeStart = 0.98;
    set = motion::fit_discrete(made.wanted, {recipe.basis_per_second, kFadeStart});
  }
  made.motion = motion::parse_motion(motion::to_toml(made.motion), made.motion.name);
  made.fit = motion::fit_error(made.motion.primitives, made.wanted);
}

void check(RecordedMotion& made) {
  made.joint_margin_rad = 1e9;
  for (const model::State& x : made.motion.reference().x) {
    for (int j = 0; j < model::kNumJoints; ++j) {
      const double q = x[model::kXJoint + j];
      made.peak_joint_speed = std::max(made.peak_joint_speed, std::abs(x[model::kXJointRate + j]));
      made.joint_margin_rad = std::min({made.joint_margin_rad, q - model::kJoints[j].lower_rad,
                                        model::kJoints[j].upper_rad - q});
    }
  }
  if (made.peak_joint_speed > motion::kMaxReferenceSpeed)
    throw MotionError(fmt::format("a joint moves at {:.2f} rad/s, the servo allows {:.2f}",
                                  made.peak_joint_speed, motion::kMaxReferenceSpeed));
  if (made.joint_margin_rad < 0.0)
    throw MotionError(
        fmt::format("a joint is {:.3f} rad beyond its limit", -made.joint_margin_rad));
}

}  // namespace

RecordedMotion record_motion(const motion::RecordRecipe& recipe, const motion::Motion& like,
                             const std::string& name, const std::string& world,
                             const std::string& ground) {
  const std::string own = like.skate ? like.skate->ground : "plane";
  const std::string profile = ground.empty() ? own : ground;
  if (like.skate && profile == "plane")
    throw MotionError("a motion on wheels needs a profile; leave --ground out for its own");
  const double duration_s = recipe.duration_s > 0.0 ? recipe.duration_s : like.duration_s();
  RecordedMotion out;
  out.motion = like;
  out.motion.name = name;
  out.motion.title = name + ", recorded from the robot";
  out.motion.source = {"own", "Apache-2.0", "coupled oscillators, the torso in a hand"};
  if (like.skate) out.motion.skate->ground = profile;
  const double push_s = like.skate ? like.skate->push_s : 0.0;
  out.motion.window = {push_s, duration_s};
  Recorder recorder(recipe, like, world + "+" + profile + (like.skate ? "+wheels" : ""), profile);
  out.robot = recorder.run(duration_s, out.largest_lag_rad);
  fit(out, recipe, duration_s);
  check(out);
  return out;
}

}  // namespace sanso::inprocess
