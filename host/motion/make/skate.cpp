// A point that slides along the profile gives the place of the feet at every tick; the posture
// above them never changes.
#include "host/motion/make/skate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "host/motion/dmp_fit.h"
#include "host/motion/make/balance.h"
#include "host/motion/make/body_kinematics.h"
#include "host/motion/make/leg_ik.h"
#include "shared/base/time.h"
#include "shared/grounds/ground_file.h"
#include "shared/model/foot_shape.h"
#include "shared/model/step_model.h"

namespace sanso::motion {
namespace {

using math::Vec3;

constexpr double kInner_s = 0.001;
constexpr int kInnerSteps = 10;
constexpr double kLongestRun_s = 20.0;
constexpr double kLeastDrop_m = 0.005;

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

Motion skate_jump() {
  Skate s;
  s.ground = "jump_ramp";
  s.lean_m = 0.004;  // the bend before the kicker throws it back
  s.push_m_s = 0.5;
  s.end_x_m = 2.3;
  Motion m = entry("skate_jump", "Jumping from a kicker", s, 1.85);
  std::erase_if(m.success, [](const Clause& c) {
    return c.measure == "both_feet_loaded_share" || c.measure == "speed_share";
  });
  m.success.push_back(at_least("airborne_s", 0.055));
  return m;
}

using Maker = Motion (*)();
const std::vector<std::pair<const char*, Maker>> kSkateEntries = {
    {"skate_slope", skate_slope},
    {"skate_ramp", skate_ramp},
    {"skate_ramp_high", skate_ramp_high},
    {"skate_jump", skate_jump}};

/// On level ground, the wheels' middle below the origin: knees bent, the centre of mass `lean_m`
/// ahead of it.
model::State posture(double kappa, double lean_m) {
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
    x[model::kXPos] += lean_m - body_points(x).centre_of_mass().x();
  }
  return x;
}

/// First lip at x or farther on, where the ground falls away; infinity: none.
double next_lip(const model::Ground& ground, double x) {
  for (int i = 1; i < ground.num_segments; ++i) {
    const double at = ground.segment[i].x_start;
    if (at >= x && ground_height(ground, at) < ground_height(ground, at - 1e-9) - kLeastDrop_m)
      return at;
  }
  return std::numeric_limits<double>::infinity();
}

/// Where the middle between the axles' contacts is, and how the line through them leans.
struct Footing {
  Vec3 p_world_middle;
  double pitch;  // about +y: downhill is positive  rad
};

Footing footing(const model::Ground& ground, double x) {
  const double slope = ground_slope(ground, x);
  const double half = model::kSkates.half_length / std::sqrt(1.0 + slope * slope);
  if (x + half >= next_lip(ground, x))  // the front axle hangs free, the rear one still rolls
    return {Vec3(x, 0.0, ground_height(ground, x)), -std::atan(slope)};
  const double back = ground_height(ground, x - half), front = ground_height(ground, x + half);
  return {Vec3(x, 0.0, 0.5 * (back + front)), std::atan2(back - front, 2.0 * half)};
}

math::Mat3 turned_by(double pitch) {
  return math::rotation_matrix(math::quat_exp({0.0, pitch, 0.0}));
}

/// The posture above `foot`, with its trunk at another pitch than the feet: in the air.
model::State standing_on(const model::State& posture, const Footing& foot, double trunk_pitch) {
  model::State out = posture;
  out.head<3>() = foot.p_world_middle + turned_by(foot.pitch) * model::base_position(posture);
  out.segment<4>(model::kXQuat) = math::quat_exp({0.0, trunk_pitch, 0.0});
  if (trunk_pitch == foot.pitch) return out;
  for (const int side : {kRight, kLeft}) {
    const Vec3 p_middle_foot(-model::kSoleCentreX, side_sign(side) * LegGeometry::kHipY,
                             -model::kSkates.height);
    out.segment<6>(model::kXJoint + 6 * side) =
        solve_leg(side, model::base_position(out), turned_by(trunk_pitch),
                  foot.p_world_middle + turned_by(foot.pitch) * p_middle_foot,
                  turned_by(foot.pitch))
            .q;
  }
  return out;
}

model::State standing_at(const model::State& posture, const model::Ground& ground, double x) {
  const Footing foot = footing(ground, x);
  return standing_on(posture, foot, foot.pitch);
}

/// A flight from the lip to the ground behind it. The base flies as a thrown stone; the feet come
/// level and under it, and of the pitch that the kicker gave the trunk keeps a share.
class Flight {
 public:
  Flight(const model::State& posture, const model::Ground& ground, double lip, double v)
      : posture_(posture), take_off_(std::atan(ground_slope(ground, lip - 1e-6))) {
    const Footing foot{Vec3(lip, 0.0, ground_height(ground, lip - 1e-6)), -take_off_};
    from_ = standing_on(posture, foot, foot.pitch).head<3>();
    velocity_ = v * Vec3(std::cos(take_off_), 0.0, std::sin(take_off_));
    const double level = ground_height(ground, lip + 1e-6) + posture[model::kXPos + 2];
    const double up = velocity_.z();
    duration_ = (up + std::sqrt(up * up + 2 * model::kGravity_m_s2 * (from_.z() - level))) /
                model::kGravity_m_s2;
  }
  double duration_s() const { return duration_; }
  double speed() const { return velocity_.x(); }
  /// At `t` since take-off: until the landing, and until the trunk is upright again.
  model::State at(double t, const model::Ground& ground) const {
    const double u = minimum_jerk(t / duration_);
    if (t < duration_) {
      Footing foot{{}, -take_off_ * (1.0 - u)};
      const Vec3 base = from_ + t * velocity_ - Vec3(0, 0, 0.5 * model::kGravity_m_s2 * t * t);
      foot.p_world_middle = base - turned_by(foot.pitch) * model::base_position(posture_);
      return standing_on(posture_, foot, -take_off_ * (1.0 - (1.0 - kKept) * u));
    }
    const double x = from_.x() + duration_ * velocity_.x() - posture_[model::kXPos] +
                     (t - duration_) * velocity_.x();
    const double left = 1.0 - minimum_jerk((t - duration_) / kUpright_s);
    return standing_on(posture_, footing(ground, x), -take_off_ * kKept * left);
  }
  double landing_x() const {
    return from_.x() + duration_ * velocity_.x() - posture_[model::kXPos];
  }

 private:
  static double minimum_jerk(double t) {
    const double u = std::clamp(t, 0.0, 1.0);
    return u * u * u * (10.0 + u * (-15.0 + 6.0 * u));
  }
  static constexpr double kKept = 0.5, kUpright_s = 0.3;
  model::State posture_;
  double take_off_;  // rad, upwards
  Vec3 from_, velocity_;
  double duration_;
};

}  // namespace

Trajectory roll(const Skate& skate, const model::Ground& ground) {
  const model::State x_posture = posture(skate.kappa, skate.lean_m);
  double x = 0.0, v = 0.0;
  for (int pass = 0; pass < 3; ++pass) x -= standing_at(x_posture, ground, x)[model::kXPos];
  Trajectory out;
  out.dt_s = kTick_s;
  std::optional<Flight> flight;
  double since_lip = 0.0;
  const double lip = next_lip(ground, x);
  for (int tick = 0;; ++tick) {
    out.x.push_back(flight ? flight->at(since_lip, ground) : standing_at(x_posture, ground, x));
    if (x >= skate.end_x_m && tick % kTicksPerUpper == 0) break;
    if (tick * kTick_s > kLongestRun_s)
      throw MotionError("skate: the reference does not arrive; raise push_m_s or lower rolling");
    for (int k = 1; k <= kInnerSteps; ++k) {
      const double t = tick * kTick_s + k * kInner_s, slope = ground_slope(ground, x);
      if (flight) {
        since_lip += kInner_s;
        x += kInner_s * flight->speed();
        continue;
      }
      const double cosine = 1.0 / std::sqrt(1.0 + slope * slope);
      if (t <= skate.push_s)
        v = skate.push_m_s * t / skate.push_s;
      else
        v = std::max(0.0, v - kInner_s * model::kGravity_m_s2 * cosine * (slope + skate.rolling));
      x += kInner_s * v * cosine;
      if (x >= lip) flight.emplace(x_posture, ground, lip, v);
    }
  }
  differentiate_poses(out);
  return out;
}

std::vector<std::string> skate_names() {
  std::vector<std::string> names;
  names.reserve(kSkateEntries.size());
  for (const auto& [name, make] : kSkateEntries) names.emplace_back(name);
  return names;
}

ImportedMotion make_skate(const std::string& name) {
  for (const auto& [entry_name, make] : kSkateEntries) {
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
