// A point that slides along the profile gives the place of the feet at every tick; the posture
// above them never changes.
#include "host/motion/make/skate.h"

#include <cmath>

#include "host/motion/dmp_fit.h"
#include "host/motion/make/balance.h"
#include "host/motion/make/body_kinematics.h"
#include "host/motion/make/leg_ik.h"
#include "shared/grounds/ground_file.h"
#include "shared/model/foot_shape.h"

namespace sanso::motion {
namespace {

using math::Vec3;

constexpr double kTick_s = 0.01, kInner_s = 0.001;
constexpr int kInnerSteps = 10, kTicksPerPlan = 6;
constexpr double kLongest_s = 20.0;

Clause at_least(const char* measure, double bound) { return {measure, bound, {}}; }
Clause at_most(const char* measure, double bound) { return {measure, {}, bound}; }

/// `arrival_m`: so far along x a run counts as arrived.
Motion entry(const char* name, const char* title, const Skate& skate, double arrival_m) {
  Motion m;
  m.name = name;
  m.title = title;
  m.source = {"own", "Apache-2.0", "computed from the profile and the law of energy"};
  m.skate = skate;
  // nothing on the robot moves it along its wheels: to be early or late must not cost a fall. Place
  // and height are weighed as what they are, rolling and pitch stay dear
  m.weights.state.segment<3>(model::kDPos) = Vec3(3.0, 100.0, 100.0);
  m.weights.state.segment<3>(model::kDTheta) = Vec3(60.0, 60.0, 20.0);
  // wheels hold both feet across: what one leg corrects the other resists, and with cheap inputs a
  // foot rattles off the ground
  m.weights.input.setConstant(20.0);
  m.stop.drop_limit_m = 0.12;
  m.success = {at_least("completed", 1),
               at_most("cost", 350),
               at_most("surface_tilt_deg", 40),
               at_least("above_surface_m", 0.17),
               at_least("place_m", arrival_m),
               at_most("cross_drift_m", 0.15),
               at_least("both_feet_loaded_share", 0.95),
               at_least("speed_share", 0.7),
               at_most("speed_share", 1.1)};
  return m;
}

Motion skate_slope() {
  Skate s;
  s.ground = "slope3";
  s.push_s = 0.3;
  s.end_x_m = 1.9;
  return entry("skate_slope", "Coasting down a slope of 3 degrees", s, 1.4);
}

Motion skate_ramp() {
  Skate s;
  s.ground = "ramp";
  s.push_m_s = 0.5;
  s.end_x_m = 2.1;
  return entry("skate_ramp", "Rolling down a ramp 0.10 m high", s, 1.31);
}

Motion skate_ramp_high() {
  Skate s;
  s.ground = "ramp_high";
  s.push_m_s = 0.5;
  s.end_x_m = 2.35;
  return entry("skate_ramp_high", "Rolling down a ramp 0.15 m high", s, 1.55);
}

using Maker = Motion (*)();
const std::vector<std::pair<const char*, Maker>> kEntries = {
    {"skate_slope", skate_slope}, {"skate_ramp", skate_ramp}, {"skate_ramp_high", skate_ramp_high}};

/// On level ground, the wheels' middle below the origin: knees bent, the centre of mass above.
model::State posture(double kappa) {
  const double ankle = -model::kSkates.height;
  model::State x = model::neutral_state();
  x.head<3>() = Vec3(0.0, 0.0, ankle + kappa * LegGeometry::kLength - LegGeometry::kHipZ);
  constexpr int kPasses = 4;
  for (int pass = 0; pass < kPasses; ++pass) {
    for (const int side : {kRight, kLeft}) {
      const Vec3 p_world_foot(-model::kSoleCentreX, side_sign(side) * LegGeometry::kHipY, ankle);
      x.segment<6>(model::kXJoint + 6 * side) =
          solve_leg(side, model::base_position(x), math::Mat3::Identity(), p_world_foot,
                    math::Mat3::Identity())
              .q;
    }
    x[model::kXPos] -= body_points(x).centre_of_mass().x();
  }
  return x;
}

/// Where the middle between the axles' contacts is, and how the line through them leans.
struct Footing {
  Vec3 p_world_middle;
  double pitch;  // about +y: downhill is positive  rad
};

Footing footing(const model::Ground& ground, double x) {
  const double slope = ground_slope(ground, x);
  const double half = model::kSkates.half_length / std::sqrt(1.0 + slope * slope);
  const double back = ground_height(ground, x - half), front = ground_height(ground, x + half);
  return {Vec3(x, 0.0, 0.5 * (back + front)), std::atan2(back - front, 2.0 * half)};
}

model::State standing_at(const model::State& posture, const model::Ground& ground, double x) {
  const Footing foot = footing(ground, x);
  const math::Quat turned = math::quat_exp({0.0, foot.pitch, 0.0});
  model::State out = posture;
  out.head<3>() =
      foot.p_world_middle + math::rotation_matrix(turned) * model::base_position(posture);
  out.segment<4>(model::kXQuat) = turned;
  return out;
}

}  // namespace

Trajectory roll(const Skate& skate, const model::Ground& ground) {
  const model::State x_posture = posture(skate.kappa);
  double x = 0.0, v = 0.0;
  for (int pass = 0; pass < 3; ++pass) x -= standing_at(x_posture, ground, x)[model::kXPos];
  Trajectory out;
  out.dt_s = kTick_s;
  for (int tick = 0;; ++tick) {
    out.x.push_back(standing_at(x_posture, ground, x));
    if (x >= skate.end_x_m && tick % kTicksPerPlan == 0) break;
    if (tick * kTick_s > kLongest_s)
      throw MotionError("skate: the reference does not arrive; raise push_m_s or lower rolling");
    for (int k = 1; k <= kInnerSteps; ++k) {
      const double t = tick * kTick_s + k * kInner_s, slope = ground_slope(ground, x);
      const double cosine = 1.0 / std::sqrt(1.0 + slope * slope);
      if (t <= skate.push_s)
        v = skate.push_m_s * t / skate.push_s;
      else
        v = std::max(0.0, v - kInner_s * kGravity * cosine * (slope + skate.rolling));
      x += kInner_s * v * cosine;
    }
  }
  differentiate_poses(out);
  return out;
}

std::vector<std::string> skate_names() {
  std::vector<std::string> names;
  for (const auto& [name, make] : kEntries) names.emplace_back(name);
  return names;
}

ImportedMotion make_skate(const std::string& name) {
  for (const auto& [entry_name, make] : kEntries) {
    if (name != entry_name) continue;
    ImportedMotion out;
    out.motion = make();
    const Skate& skate = *out.motion.skate;
    const Trajectory wanted = roll(skate, grounds::load_ground(skate.ground));
    out.motion.window = {skate.push_s, wanted.duration_s()};
    // it ends rolling: nothing is faded out before the last moment
    constexpr double kFadeStart = 0.98;
    out.motion.primitives = fit_discrete(wanted, {skate.basis_per_second, kFadeStart});
    out.motion = parse_motion(to_toml(out.motion), out.motion.name);
    out.fit = fit_error(out.motion.primitives, wanted);
    out.retargeted.trajectory = wanted;
    return out;
  }
  std::string known;
  for (const std::string& n : skate_names()) known += (known.empty() ? "" : ", ") + n;
  throw MotionError("no motion on wheels named '" + name + "'; there are: " + known);
}

}  // namespace sanso::motion
