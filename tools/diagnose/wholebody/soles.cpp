// A foot that stands flat shows the normal of the floor through attitude and joints, and whether
// it slips. A floor leans in the world, a wrong zero or IMU with the robot, and the poses' own
// vertical in the world too, where only an accelerometer tells it from the floor.
#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>

#include "tools/diagnose/stats/robust.h"
#include "tools/diagnose/stats/significance.h"
#include "tools/diagnose/wholebody/lean.h"
#include "tools/diagnose/wholebody/questions.h"

namespace sanso::diagnose {
namespace {

/// Rows in which this foot stands: it alone, or with others, carries the weight.
std::vector<char> standing(const Asking& asking, const WholeRecording& r, const FootForce& foot) {
  const double weight = asking.body.mass() * eigen(asking.body.model.gravity).norm();
  std::vector<char> out(r.rows(), 0);
  for (std::size_t k = 0; k < r.rows(); ++k)
    out[k] = foot.fz[k] > asking.settings.stance_share * weight ? 1 : 0;
  return out;
}

struct Soles {
  Leans leans;
  std::vector<double> slips;  // m/s, one a stance
};

void add_foot(const Asking& asking, std::size_t number, const FootForce& foot, Soles& soles) {
  const WholeRecording& r = asking.recordings[number];
  const std::optional<V3> normal = sole_normal(asking.body, foot.joint, foot.link);
  const Level level(upwards(asking.body));
  const V2 known = lean_of(asking.known.slope) + lean_of(asking.known.pose_tilt);
  BodyKinematics kinematics(asking.body);
  for (const Span& s : spans(r, standing(asking, r, foot))) {
    if (r.t[s.last - 1] - r.t[s.first] < asking.settings.rest_time) continue;
    V3 first = V3::Zero(), last = V3::Zero();
    // touchdown and lift-off roll over the edges
    const auto edge =
        static_cast<std::size_t>(asking.settings.stance_edge * static_cast<double>(s.rows()));
    for (std::size_t k = s.first + edge; k < s.last - edge; ++k) {
      kinematics.set(r.R[k], r.p[k], r.q.col(static_cast<Eigen::Index>(k)));
      last = kinematics.origin(foot.joint);
      if (k == s.first + edge) first = last;
      if (!normal) continue;
      const double t = r.t[k] - r.t.front();
      soles.leans.add(level.lean(kinematics.rotation(foot.joint) * *normal) - known,
                      level.heading(r.R[k]), foot.link, number,
                      static_cast<std::size_t>(t / asking.settings.block),
                      asking.group_of(number, t));
    }
    const double seconds = r.t[s.last - edge - 1] - r.t[s.first + edge];
    const V3 along = (last - first) - level.up.dot(last - first) * level.up;
    if (r.position && seconds > 0.0) soles.slips.push_back(along.norm() / seconds);
  }
}

WholeAnswers judge_slip(const Asking& asking, const Soles& soles) {
  WholeAnswers answers;
  if (soles.slips.empty()) {
    answers.cannot(WholeFigure::friction, "no base position: nobody knows whether a foot slips");
    return answers;
  }
  const double fast = quantile(soles.slips, 0.9);
  answers.notes.push_back(
      fmt::format("{} stances; the feet drift by {:.3g} m/s, the faster tenth "
                  "by {:.3g} m/s",
                  soles.slips.size(), median(soles.slips), fast));
  if (fast < asking.settings.slip_speed) {
    answers.cannot(WholeFigure::friction, "no foot slips: friction is bounded from below only");
  } else {
    answers.cannot(WholeFigure::friction,
                   "feet slip, and no forces along the ground were recorded to compare with");
  }
  return answers;
}

/// Whether headings differ enough to tell what leans in the world from what leans with the robot.
bool told_by_headings(const LeanFit& fit, const Asking& asking) {
  return asking.chance().deviations() * std::max(fit.world.sigma, fit.body.sigma) <
         asking.settings.leans;
}

/// A vector that leans, as a finding with its two numbers.
WholeAnswers judge_lean(const Asking& asking, const Asked& asked, const Measured& m,
                        const V2& rotation) {
  WholeAnswers out = answer_to(asked, m, asking.chance());
  if (!out.missing()) return out;
  // of a vector's deviation each of two axes has its part
  const double each = kNormal95 * m.sigma / std::sqrt(2.0);
  out.findings.back().parameters = {
      {"x", {rotation[0], rotation[0] - each, rotation[0] + each, "rad", false}},
      {"y", {rotation[1], rotation[1] - each, rotation[1] + each, "rad", false}}};
  return out;
}

/// A lean about two axes, asked of standing soles.
Asked asked_of(WholeFigure figure, std::vector<std::string> where, double tolerance,
               std::vector<std::string> equally_good) {
  Asked out = asked_for(figure);
  out.where = std::move(where), out.parameter = "x, y", out.regime = "stance";
  out.tolerance = tolerance, out.equally_good = std::move(equally_good), out.channel = kSoleBalance;
  return out;
}

/// The floor, with what the poses' vertical is known to lean by taken out.
Answered judge_floor(const Asking& asking, const LeanFit& soles) {
  Answered out;
  const std::optional<LeanFit> imu = imu_vertical(asking);
  const bool vouched = imu && told_by_headings(*imu, asking);
  V2 lean = soles.in_world;
  Measured floor = soles.world;
  if (vouched) {
    const V2 rotation = rotation_of(imu->in_world);
    const Asked asked =
        asked_of(WholeFigure::pose_tilt, {asking.body.root}, asking.settings.level, {});
    out.answers = judge_lean(asking, asked, imu->world, rotation);
    if (out.answers.missing()) out.patch.pose_tilt = rotation;
    lean -= imu->in_world;
    floor.sigma = std::hypot(floor.sigma, imu->world.sigma);
    floor.value = lean.norm();
    floor.low = std::max(0.0, floor.value - kNormal95 * floor.sigma);
    floor.high = floor.value + kNormal95 * floor.sigma;
  }
  std::vector<std::string> others;
  if (!vouched) others.push_back(name_of(WholeFigure::pose_tilt));
  const Asked asked = asked_of(WholeFigure::slope, {}, asking.settings.level, others);
  WholeAnswers of_floor = judge_lean(asking, asked, floor, rotation_of(lean));
  if (of_floor.missing()) out.patch.slope = rotation_of(lean);
  out.answers.take(std::move(of_floor));
  return out;
}

/// Zeros of joints turn soles as a floor does.
std::string wrong_zero() { return std::string(effect_of(JointFigure::zero)->id); }

/// Names of what leans with the robot.
std::vector<std::string> with_the_robot() { return {name_of(WholeFigure::imu_turn), wrong_zero()}; }

Answered judge_tilt(const Asking& asking, const Leans& leans) {
  Answered out;
  if (leans.empty()) {
    out.answers.cannot(WholeFigure::slope,
                       "no flat sole below a foot with fz:<link> (URDF <collision> box "
                       "or [[contact]] box)");
    return out;
  }
  const auto fit = LeanFit::of(leans, asking.tolerances.zero, asking.chance());
  if (!fit) {
    out.answers.cannot(WholeFigure::slope, "the feet stand flat too seldom");
    return out;
  }
  out.answers.notes.push_back(fmt::format(
      "standing soles lean by {:.4f} +- {:.4f} rad in the world and by {:.4f} +- {:.4f} rad with "
      "the robot",
      fit->in_world.norm(), fit->world.sigma, fit->in_body.norm(), fit->body.sigma));
  const double tolerance = asking.settings.sole_tilt;
  Asked apart = asked_of(WholeFigure::slope, {}, tolerance, with_the_robot());
  apart.parameter = "angle";
  if (fit->apart.value > tolerance) out.answers.take(answer_to(apart, fit->apart, asking.chance()));
  if (out.answers.missing()) {
    out.answers.notes.push_back(
        "every recording leans its own way: headings that start anew, or another place each time; "
        "poses of one world would tell the floor from the robot");
    return out;
  }
  if (told_by_headings(*fit, asking)) {
    out.take(judge_floor(asking, *fit));
    const Asked own =
        asked_of(WholeFigure::imu_turn, {asking.body.imu.link}, tolerance, {wrong_zero()});
    out.answers.take(judge_lean(asking, own, fit->body, rotation_of(fit->in_body)));
  } else {
    out.answers.notes.push_back(
        "all headings are alike: a floor that leans and an IMU, or zeros of joints, that lean the "
        "robot are the same here; turn the robot by a quarter or half");
  }
  if (out.answers.missing()) return out;
  const Asked all = asked_of(WholeFigure::slope, {}, tolerance, with_the_robot());
  const V2 rotation = rotation_of(fit->alike);
  out.answers.take(judge_lean(asking, all, fit->together, rotation));
  if (out.answers.missing()) out.patch.slope = rotation;
  return out;
}

}  // namespace

Answered ask_soles(const Asking& asking) {
  Answered out;
  Soles soles;
  bool feet = false;
  for (std::size_t r = 0; r < asking.recordings.size(); ++r) {
    if (!asking.recordings[r].attitude) continue;
    for (const FootForce& foot : asking.recordings[r].feet) {
      feet = true;
      add_foot(asking, r, foot, soles);
    }
  }
  if (!feet) {
    out.answers.cannot(WholeFigure::slope,
                       "no foot that is known to stand (fz:<link>) beside an attitude");
    return out;
  }
  out.answers.take(judge_slip(asking, soles));
  out.take(judge_tilt(asking, soles.leans));
  return out;
}

}  // namespace sanso::diagnose
