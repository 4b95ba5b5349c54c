// A robot stands in its trial without a planner's help, so that the same push has the same fall up
// to the moment at which the guard is sure of it.
#include "tools/campaign/falls.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <span>

#include "host/learn/session/session.h"
#include "host/motion/motion.h"
#include "shared/math/order_statistics.h"
#include "tools/inprocess/inprocess_access.h"

namespace sanso::campaign {
namespace {

constexpr std::int32_t kPushTick = 100;
constexpr double kPush_s = 0.15;
constexpr double kAfterImpact_s = 1.0, kLongest_s = 5.0;

double norm(const plant::Vec3& v) { return std::hypot(v[0], v[1], v[2]); }
double distance(const plant::Vec3& a, const plant::Vec3& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/// Looks at the physics after every tick, from the push on.
class Watch {
 public:
  Watch(inprocess::InProcessRobot& robot, Fall& fall) : robot_(robot), fall_(fall) {}
  void look() {
    const emulator::Truth truth = robot_.robot().truth();
    const bool pushed = robot_.controller().observation().trial_tick >= kPushTick;
    if (begun_ == 0 && pushed) begun_ = truth.time;
    if (begun_ != 0) compare(truth);
    last_ = truth;
  }
  bool over() const {
    if (begun_ == 0) return false;
    const double since = to_seconds(last_.time - begun_);
    return since > kLongest_s || (fall_.fell && since > fall_.after_s + kAfterImpact_s);
  }

 private:
  void compare(const emulator::Truth& truth) {
    const double since = to_seconds(truth.time - begun_);
    if (!fall_.fell && truth.other_contacts > 0) {
      fall_.fell = true;
      fall_.after_s = since;
      fall_.speed_m_s = norm(last_.v_base_in_world);
      fall_.rate_rad_s = norm(last_.w_base_in_base);
    }
    const auto on = std::count(truth.torque_on.begin(), truth.torque_on.end(), true);
    if (fall_.released_s < 0 && on == 0) fall_.released_s = since;
    if (!fall_.fell) return;  // a hand's push is no impact
    fall_.deceleration_m_s2 =
        std::max(fall_.deceleration_m_s2,
                 distance(truth.v_base_in_world, last_.v_base_in_world) / kTickSeconds);
    for (std::size_t i = 0; i < truth.dq.size(); ++i)
      fall_.joint_jerk_rad_s =
          std::max(fall_.joint_jerk_rad_s, std::abs(truth.dq[i] - last_.dq[i]));
  }

  static constexpr double kTickSeconds = 0.01;
  inprocess::InProcessRobot& robot_;
  Fall& fall_;
  emulator::Truth last_;
  Nanoseconds begun_ = 0;
};

double median_of(std::span<const Fall> falls, double Fall::*field) {
  std::vector<double> values;
  for (const Fall& f : falls)
    if (f.fell) values.push_back(f.*field);
  if (values.empty()) return std::nan("");
  return math::value_of_rank(std::span(values), values.size() / 2);
}

nlohmann::json json_of(const Fall& f, double tuck_s) {
  return {{"tuck_s", tuck_s},
          {"heading_rad", f.heading_rad},
          {"fell", f.fell},
          {"after_s", f.after_s},
          {"speed_m_s", f.speed_m_s},
          {"rate_rad_s", f.rate_rad_s},
          {"deceleration_m_s2", f.deceleration_m_s2},
          {"joint_jerk_rad_s", f.joint_jerk_rad_s},
          {"released_s", f.released_s}};
}

void print(const Fall& f, double tuck_s) {
  fmt::print("{:5.2f} {:8.0f} {:>5} {:8.2f} {:8.2f} {:8.2f} {:10.0f} {:10.2f} {:8.2f}\n", tuck_s,
             f.heading_rad * 180.0 / std::numbers::pi, f.fell ? "yes" : "no", f.after_s,
             f.speed_m_s, f.rate_rad_s, f.deceleration_m_s2, f.joint_jerk_rad_s, f.released_s);
}

void print_median(std::span<const Fall> falls, double tuck_s) {
  fmt::print(
      "median of {} falls, tuck {:.2f} s: speed {:.2f} m/s, rate {:.2f} rad/s, "
      "deceleration {:.0f} m/s^2, change of a joint's rate {:.2f} rad/s\n",
      std::count_if(falls.begin(), falls.end(), [](const Fall& f) { return f.fell; }), tuck_s,
      median_of(falls, &Fall::speed_m_s), median_of(falls, &Fall::rate_rad_s),
      median_of(falls, &Fall::deceleration_m_s2), median_of(falls, &Fall::joint_jerk_rad_s));
}

}  // namespace

Fall fall(const FallOptions& options, double heading_rad, double tuck_s) {
  Fall out;
  out.heading_rad = heading_rad;
  motion::Motion motion = motion::MotionLibrary().load("stand");
  motion.primitives = learn::from_origin(motion.primitives);
  learn::TrialSetup setup;
  setup.primitives = &motion.primitives;
  setup.reference = learn::reference_of(motion.primitives);
  setup.weights = motion.weights;
  setup.layers.middle = setup.layers.upper = false;
  setup.duration_ticks = motion.primitives.duration_ticks();
  firmware::Settings settings;
  settings.guard.tuck_s = tuck_s;
  inprocess::InProcessAccess access(options.world, settings);
  link::RobotLink& link = access.place(setup.reference.front(), options.seed);
  inprocess::InProcessRobot& robot = access.robot();
  Watch watch(robot, out);
  robot.after_tick([&] { watch.look(); });
  robot.push_at({.trial_tick = kPushTick,
                 .duration_s = kPush_s,
                 .force_in_world_N = {options.push_N * std::cos(heading_rad),
                                      options.push_N * std::sin(heading_rad), 0.0},
                 .torque_in_world_Nm = {}});
  learn::TrialSettings trial;
  trial.settle_s = 0.3;
  learn::prepare_trial(link, setup, trial);
  mpc::MpcSettings planner;
  planner.threads = 1;
  mpc::UpperLayer upper(planner, host::AugmentedModel{});
  learn::run_trial(link, upper, setup, trial);
  while (!watch.over()) {
    link.wait_observation(robot.now() + 50 * kMillisecond);
    link.send_sign_of_life();
    link.take_observations();
  }
  return out;
}

int bench_falls(const FallOptions& options) {
  nlohmann::json rows = nlohmann::json::array();
  bool kept = false;
  if (!options.json)
    fmt::print(" tuck  heading  fell  after s      m/s    rad/s      m/s^2  joint/tick  limp s\n");
  for (const double tuck_s : {0.0, firmware::Settings{}.guard.tuck_s}) {
    std::vector<Fall> falls;
    for (int i = 0; i < options.directions; ++i) {
      falls.push_back(fall(options, 2.0 * std::numbers::pi * i / options.directions, tuck_s));
      kept = kept || (falls.back().fell && falls.back().released_s < 0);
      if (options.json)
        rows.push_back(json_of(falls.back(), tuck_s));
      else
        print(falls.back(), tuck_s);
    }
    if (!options.json) print_median(falls, tuck_s);
  }
  if (options.json) fmt::print("{}\n", rows.dump(1));
  return kept ? 1 : 0;
}

}  // namespace sanso::campaign
