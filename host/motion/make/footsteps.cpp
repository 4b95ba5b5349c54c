// Swings are cut from the human's stances, evened out, repeated, scaled, and joined to a stance
// at both ends.
#include "host/motion/make/footsteps.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "host/motion/make/leg_ik.h"
#include "host/motion/mocap/filter.h"

namespace sanso::motion {
namespace {

// ankles; the soles are then 17 mm apart
constexpr double kLeastSpacing_m = LegGeometry::kHipSpacing;

double standing_y(int side) { return side_sign(side) * LegGeometry::kHipY; }

/// Height that the sole is above the ankle-roll origin when the foot is flat.
constexpr double kFootHeight_m = LegGeometry::kSoleBelowAnkle;

struct HumanSwing {
  int side;
  double lift_s, land_s;
  Eigen::Vector2d ahead;  // of the landing foot against the other one, which carries then   m
};

/// The stance of the other foot at time t: the last one that began before it.
const HumanStance* stance_before(const std::vector<HumanStance>& all, int side, double t) {
  const HumanStance* found = nullptr;
  for (const auto& s : all) {
    if (s.side == side && s.from_s <= t) found = &s;
  }
  return found;
}

std::vector<HumanSwing> find_swings(const HumanMotion& human) {
  const std::vector<HumanStance> all = stances(human);
  std::vector<HumanSwing> swings;
  for (int side : {kRight, kLeft}) {
    const HumanStance* last = nullptr;
    for (const auto& s : all) {
      if (s.side != side) continue;
      const HumanStance* other = stance_before(all, 1 - side, s.from_s);
      if (last && other) swings.push_back({side, last->to_s, s.from_s, s.p - other->p});
      last = &s;
    }
  }
  std::sort(swings.begin(), swings.end(),
            [](const auto& a, const auto& b) { return a.lift_s < b.lift_s; });
  return swings;
}

/// The landing place ahead of the other foot in robot metres. Widths do not scale with leg length:
/// only what differs from the human's own hip spacing does, and the feet keep the spacing of the
/// hips.
Eigen::Vector2d scaled_ahead(const HumanSwing& swing, const HumanMotion& human,
                             const Recipe& recipe, double s) {
  const double side = side_sign(swing.side);
  const double kx = recipe.heading_by_body ? 0.0 : recipe.kx;  // a sidestep goes sideways only
  const double ky = recipe.heading_by_body ? recipe.kx : 1.0;
  const double wider = s * ky * (side * swing.ahead.y() - human.hip_spacing());
  return {s * kx * swing.ahead.x(), side * (kLeastSpacing_m + std::max(wider, 0.0))};
}

double median_duration(const std::vector<HumanSwing>& swings) {
  std::vector<double> durations;
  durations.reserve(swings.size());
  for (const auto& s : swings) durations.push_back(s.land_s - s.lift_s);
  return percentile(durations, 0.5);
}

/// Repeats the sequence `loops` times, a median swing apart (looped clips were strung together
/// before).
std::vector<HumanSwing> repeated(const std::vector<HumanSwing>& once, int loops) {
  const double period = once.back().land_s - once.front().lift_s + 0.3 * median_duration(once);
  std::vector<HumanSwing> all;
  for (int c = 0; c < loops; ++c) {
    for (HumanSwing s : once) {
      s.lift_s += c * period;
      s.land_s += c * period;
      all.push_back(s);
    }
  }
  return all;
}

/// Swings of the mean length, one mean step apart.
void even_out(std::vector<HumanSwing>& swings) {
  if (swings.size() < 2) return;
  const double period =
      (swings.back().lift_s - swings.front().lift_s) / static_cast<double>(swings.size() - 1);
  double length = 0.0;
  for (const HumanSwing& s : swings)
    length += (s.land_s - s.lift_s) / static_cast<double>(swings.size());
  for (std::size_t i = 0; i < swings.size(); ++i) {
    swings[i].lift_s = swings.front().lift_s + period * static_cast<double>(i);
    swings[i].land_s = swings[i].lift_s + length;
  }
}

/// Minimum jerk from 0 to 1.
double smooth_step(double u) { return u * u * u * (10 - 15 * u + 6 * u * u); }

Eigen::Vector2d sole_centre(int side, const Eigen::Vector2d& foot, double inside_m) {
  return foot + Eigen::Vector2d(LegGeometry::kSoleCentreX,
                                side_sign(side) * (LegGeometry::kSoleCentreY - inside_m));
}

}  // namespace

Scale scale_for(const HumanMotion& human, const Recipe& recipe) {
  const double leg = human.leg_length();
  // 0.09 m: human ankle above the floor; the robot's is kSoleBelowAnkle
  const double hip_height_ratio =
      (LegGeometry::kLength + LegGeometry::kSoleBelowAnkle) / (leg + 0.09);
  return {LegGeometry::kLength / leg, recipe.kt * std::sqrt(hip_height_ratio)};
}

math::Vec3 StepPlan::foot_at(int side, double t) const {
  Eigen::Vector2d p = start[side];
  double height = kFootHeight_m;
  for (const Swing& swing : swings) {
    if (swing.side != side || t <= swing.lift_s) continue;
    if (t >= swing.land_s) {
      p = swing.to;
      continue;
    }
    const double u = (t - swing.lift_s) / (swing.land_s - swing.lift_s);
    // A leg that gives up its load first takes up the servos' sag, so the sole leaves the ground
    // later than planned. A foot that is on its way forward by then stubs.
    const double ahead = std::clamp((u - swing_dwell) / (1 - 2 * swing_dwell), 0.0, 1.0);
    p = swing.from + smooth_step(ahead) * (swing.to - swing.from);
    height += swing_height_m * std::pow(4 * u * (1 - u), swing_sharpness);
  }
  return {p.x(), p.y(), height};
}

bool StepPlan::carries(int side, double t) const {
  return std::none_of(swings.begin(), swings.end(), [&](const Swing& s) {
    return s.side == side && t > s.lift_s && t < s.land_s;
  });
}

Eigen::Vector2d StepPlan::support_at(double t, double inside_m) const {
  const auto place = [&](int side, double at) {
    return sole_centre(side, foot_at(side, at).head<2>(), inside_m);
  };
  const auto middle = [&](double at) {
    return Eigen::Vector2d(0.5 * (place(kRight, at) + place(kLeft, at)));
  };
  if (swings.empty()) return middle(t);

  // corner points of the path: middle, then each swing's support foot while it swings, then middle
  struct Corner {
    double t;
    Eigen::Vector2d p;
  };
  std::vector<Corner> corners = {{swings.front().lift_s - kTransfer_s, middle(0.0)}};
  for (std::size_t i = 0; i < swings.size(); ++i) {
    // where swings overlap (flight) each support foot has the time between the landing and the
    // lifting of its own
    const double from = i > 0 ? std::max(swings[i].lift_s, swings[i - 1].land_s) : swings[i].lift_s;
    const double to =
        i + 1 < swings.size() ? std::min(swings[i].land_s, swings[i + 1].lift_s) : swings[i].land_s;
    const Eigen::Vector2d p = place(1 - swings[i].side, 0.5 * (from + to));
    corners.push_back({from, p});
    corners.push_back({std::max(from, to), p});
  }
  corners.push_back({swings.back().land_s + kTransfer_s, middle(duration_s)});
  if (t <= corners.front().t) return corners.front().p;
  for (std::size_t i = 1; i < corners.size(); ++i) {
    if (t > corners[i].t) continue;
    const double span = corners[i].t - corners[i - 1].t;
    const double u = span > 1e-9 ? (t - corners[i - 1].t) / span : 1.0;
    return corners[i - 1].p + u * (corners[i].p - corners[i - 1].p);
  }
  return corners.back().p;
}

double StepPlan::clip_time(double t) const {
  if (swings.empty()) return 0.0;
  double robot = swings.front().lift_s, clip = swings.front().clip_lift_s;
  if (t <= robot) return clip;
  for (const Swing& swing : swings) {
    for (const auto& [r, c] :
         {std::pair{swing.lift_s, swing.clip_lift_s}, std::pair{swing.land_s, swing.clip_land_s}}) {
      if (r <= robot) continue;
      if (t <= r) return clip + (c - clip) * (t - robot) / (r - robot);
      robot = r;
      clip = c;
    }
  }
  return clip;
}

StepPlan plan_steps(const HumanMotion& human, const Recipe& recipe) {
  std::vector<HumanSwing> human_swings = find_swings(human);
  if (human_swings.empty())
    throw ClipError(human.source + ": no step found; expected at least one swing of a foot");
  if (!human.loops) human_swings = repeated(human_swings, recipe.loops);
  if (static_cast<int>(human_swings.size()) > recipe.max_steps)
    human_swings.resize(recipe.max_steps);
  if (recipe.even_rhythm) even_out(human_swings);
  // closing step: the trailing foot comes beside the other one
  const double median_swing = median_duration(human_swings);
  const HumanSwing& last = human_swings.back();
  human_swings.push_back({1 - last.side,
                          last.land_s,
                          last.land_s + median_swing,
                          {0.0, side_sign(1 - last.side) * human.hip_spacing()}});

  const Scale scale = scale_for(human, recipe);
  StepPlan plan;
  plan.swing_height_m = recipe.swing_height_m;
  plan.swing_sharpness = recipe.swing_sharpness;
  plan.swing_dwell = recipe.swing_dwell;
  for (int side : {kRight, kLeft}) plan.start[side] = {0.0, standing_y(side)};
  std::array<Eigen::Vector2d, 2> at = plan.start;
  double delay = recipe.stand_s + kTransfer_s - scale.time * human_swings.front().lift_s;
  for (const HumanSwing& h : human_swings) {
    Swing swing{h.side,
                scale.time * h.lift_s + delay,
                scale.time * h.land_s + delay,
                h.lift_s,
                h.land_s,
                at[h.side],
                at[1 - h.side] + scaled_ahead(h, human, recipe, scale.length)};
    // about its middle, so that the rhythm stays
    const double longer = (recipe.swing_stretch - 1.0) * (swing.land_s - swing.lift_s);
    swing.lift_s -= 0.5 * longer;
    swing.land_s += 0.5 * longer;
    const double too_early =
        plan.swings.empty() ? 0.0
                            : plan.swings.back().land_s + recipe.double_support_s - swing.lift_s;
    const double later = std::max(too_early, 0.0);
    swing.lift_s += later;
    swing.land_s += later;
    delay += later;
    at[h.side] = swing.to;
    plan.swings.push_back(swing);
  }
  plan.duration_s = plan.swings.back().land_s + kTransfer_s + recipe.stand_s;
  plan.duration_s = std::ceil(plan.duration_s * 10.0) / 10.0;
  return plan;
}

}  // namespace sanso::motion
