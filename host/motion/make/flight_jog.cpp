// Swings that overlap by the flight, a trunk that is thrown and caught between them, feet that roll
// off over their front edge.
#include "host/motion/make/flight_jog.h"

#include <algorithm>
#include <cmath>

#include "host/motion/make/leg_ik.h"
#include "shared/base/time.h"
#include "shared/model/op3_table.h"
#include "shared/model/step_model.h"

namespace sanso::motion {
namespace {

using model::kGravity_m_s2;
constexpr double kShift_s = 0.6;    // weight over the first foot, and back
constexpr double kSettle_s = 0.03;  // a foot is level so long before it touches down

double smooth(double u) {
  u = std::clamp(u, 0.0, 1.0);
  return u * u * (3 - 2 * u);
}

StepPlan plan_of(const FlightJog& f) {
  StepPlan plan;
  plan.swing_height_m = f.swing_height_m;
  plan.swing_sharpness = f.swing_sharpness;
  plan.swing_dwell = f.swing_dwell;
  for (const int side : {kRight, kLeft})
    plan.start[side] = {0.0, side_sign(side) * LegGeometry::kHipY};
  std::array<Eigen::Vector2d, 2> at = plan.start;
  for (int i = 0; i < f.steps; ++i) {
    const int side = i % 2 == 0 ? kRight : kLeft;
    Swing swing;
    swing.side = side;
    swing.lift_s = f.stand_s + kShift_s + i * f.period_s;
    swing.land_s = swing.lift_s + f.period_s + f.flight_s;
    swing.from = at[side];
    const double ahead = i + 1 < f.steps ? f.step_m : 0.0;
    swing.to = {at[1 - side].x() + ahead, side_sign(side) * LegGeometry::kHipY};
    at[side] = swing.to;
    plan.swings.push_back(swing);
  }
  plan.duration_s = plan.swings.back().land_s + kShift_s + f.stand_s;
  plan.duration_s = std::ceil(plan.duration_s * 10.0) / 10.0;
  return plan;
}

/// Speed of the trunk `s` after a lift-off: thrown, caught, and pushed to where it was.
double rise_m_s(const FlightJog& f, double s) {
  const double down = f.lift_off_m_s - kGravity_m_s2 * f.flight_s;  // at touch-down
  if (s < f.flight_s) return f.lift_off_m_s - kGravity_m_s2 * s;
  const double stance = f.period_s - f.flight_s, push = stance - f.absorb_s;
  // between, so that a whole step gains no height
  const double turn =
      -((f.lift_off_m_s + down) * f.flight_s + down * f.absorb_s + f.lift_off_m_s * push) / stance;
  const double since = s - f.flight_s;
  if (since < f.absorb_s) return down + (turn - down) * since / f.absorb_s;
  return turn + (f.lift_off_m_s - turn) * (since - f.absorb_s) / push;
}

/// Height of the trunk over standing, every tick.
std::vector<double> bounce(const FlightJog& f, const StepPlan& plan, int ticks) {
  constexpr double kFine_s = 1e-3;
  constexpr double kFade = 0.98;  // a millisecond, after the last lift-off
  const double first = plan.swings[1].lift_s, last = plan.swings.back().lift_s;
  std::vector<double> height;
  double z = 0.0;
  for (int m = 0; m <= 10 * ticks; ++m) {
    if (m % 10 == 0) height.push_back(z);
    const double t = m * kFine_s;
    if (t >= last)
      z *= kFade;
    else if (t >= first)
      z += kFine_s * rise_m_s(f, std::fmod(t - first, f.period_s));
  }
  return height;
}

/// Of a foot about +y: heel up is positive. The first swing lifts level, from standing.
double pitch_at(const FlightJog& f, const StepPlan& plan, int side, double t) {
  double pitch = 0.0;
  for (const Swing& swing : plan.swings) {
    if (swing.side != side || swing.lift_s == plan.swings.front().lift_s) continue;
    if (t <= swing.lift_s - f.heel_up_s || t >= swing.land_s) continue;
    const double since = t - swing.lift_s;
    const double left = swing.land_s - swing.lift_s - f.heel_down_s - kSettle_s;
    pitch = f.heel_rad * smooth(1.0 + since / f.heel_up_s) -
            (f.heel_rad + f.toe_rad) * smooth(since / f.heel_down_s) +
            f.toe_rad * smooth((since - f.heel_down_s) / left);
  }
  return pitch;
}

/// A level foot at `p` turned about its front edge.
math::Vec3 rolled(const math::Vec3& p, double pitch) {
  const math::Vec3 edge(model::kSoleFront, 0.0, -LegGeometry::kSoleBelowAnkle);
  return p + edge - pitched(pitch) * edge;
}

}  // namespace

FlightReference flight_reference(const FlightJog& f) {
  if (f.steps < 2 || f.flight_s <= 0.0 || f.absorb_s <= 0.0 ||
      f.period_s < f.flight_s + f.absorb_s + kTick_s)
    throw ClipError(
        "a jog with flight needs two steps and more, and a stance between flights; "
        "raise period_s or lower flight_s and absorb_s");
  FlightReference out;
  out.plan = plan_of(f);
  const int ticks = static_cast<int>(std::lround(out.plan.duration_s / kTick_s));
  const std::vector<double> height = bounce(f, out.plan, ticks);
  const double standing =
      f.kappa * LegGeometry::kLength + LegGeometry::kSoleBelowAnkle - LegGeometry::kHipZ;
  BodyTarget target;
  for (int k = 0; k <= ticks; ++k) {
    const double t = k * kTick_s;
    std::array<math::Vec3, 2> feet;
    std::array<double, 2> pitch{};
    for (const int side : {kRight, kLeft}) {
      pitch[side] = pitch_at(f, out.plan, side, t);
      feet[side] = rolled(out.plan.foot_at(side, t), pitch[side]);
    }
    target.p_world_foot.push_back(feet);
    target.foot_pitch.push_back(pitch);
    target.carries.push_back({out.plan.carries(kRight, t), out.plan.carries(kLeft, t)});
    target.base_height.push_back(standing + height[k]);
    target.ground.push_back(out.plan.support_at(t, 0.0));
  }
  out.body = solve_body(target);
  return out;
}

}  // namespace sanso::motion
