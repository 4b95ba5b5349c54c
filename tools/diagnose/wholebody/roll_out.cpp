// Centroidal momentum: the ground alone changes it, and what the joints do within it is known, so
// that the base has the rest. A contact is an impulse at a point, by Gauss-Seidel over all that
// touch: no approach, Coulomb's cone, and the rebound that the model states.
#include "tools/diagnose/wholebody/roll_out.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "shared/math/so3.h"
#include "tools/diagnose/stats/robust.h"

namespace sanso::diagnose {
namespace {

constexpr double kStep_s = 0.001;
constexpr int kSweeps = 30;                // of the impulses; ten points settle in fewer
constexpr double kRebounds_m_s = 0.05;     // slower approaches do not rebound
constexpr double kPushedOut = 0.1;         // of a depth, a step
constexpr double kFrictionUnstated = 0.6;  // plastic or rubber on wood
constexpr double kTouches_m = 0.005;       // of a pose as it is recorded
constexpr std::size_t kHalfWindow = 5;     // rows on both sides that say a velocity

M3 turn_of(const V3& rotation) { return math::rotation_matrix(math::quat_exp(rotation)); }

/// The upright leaned by rotations about the level's x and y.
V3 leaned(const V3& up, const V2& rotation) {
  const Level level(up);
  return turn_of(rotation[0] * level.x + rotation[1] * level.y) * up;
}

}  // namespace

/// Base pose with the momenta of the whole: linear, and about its centre of mass.
struct BaseRollOut::State {
  V3 p = V3::Zero(), v = V3::Zero(), w = V3::Zero();  // v, w: of the base, while it begins
  M3 R = M3::Identity();
  V3 linear = V3::Zero(), angular = V3::Zero();
  bool begun = false;
};

struct BaseRollOut::Contact {
  V3 arm = V3::Zero();    // from the centre of mass
  V3 moved = V3::Zero();  // by the joints, m/s
  double friction = 0.0, rebound = 0.0, along = 0.0;
  V3 across = V3::Zero();  // impulses so far: along the normal, across it
};

/// Of the whole, and what its joints do in a step.
struct BaseRollOut::Inertia {
  double mass = 0.0;
  V3 spun = V3::Zero();  // angular momentum of the joints' motion
  M3 I_inverse = M3::Identity();
};

BaseRollOut::BaseRollOut(const WholeBody& body, const WholeRecording& recording)
    : body_(body),
      known_(apply_effects(body_)),
      recording_(recording),
      points_(touch_points(body_)) {
  const V3 up = upwards(body_);
  gravity_ = -eigen(body_.model.gravity).norm() * leaned(up, known_.pose_tilt);
  normal_ = leaned(up, known_.pose_tilt + known_.slope);
  restitution_ = std::clamp(body_.ground.restitution.value_or(0.0), 0.0, 1.0);
  for (const TouchPoint& point : points_)
    friction_.push_back(body_.material_of(point.link).friction.value_or(kFrictionUnstated));
  ground_ = ground_height();
}

bool BaseRollOut::possible(const WholeBody& body, const WholeRecording& recording) {
  return recording.position && recording.attitude && body.mass() > 0.0 && !body.shapes.empty();
}

double BaseRollOut::lowest(const BodyKinematics& kinematics) const {
  double out = std::numeric_limits<double>::infinity();
  for (const TouchPoint& point : points_)
    out = std::min(out, normal_.dot(kinematics.at(point.joint, point.at)) - point.radius);
  return out;
}

/// As stated, else where the lowest rows are.
double BaseRollOut::ground_height() const {
  if (body_.ground.height) return *body_.ground.height * normal_.dot(upwards(body_));
  constexpr std::size_t kRows = 2000;
  BodyKinematics kinematics(body_);
  std::vector<double> heights;
  for (std::size_t k = 0; k < recording_.rows(); k += 1 + recording_.rows() / kRows) {
    kinematics.set(recording_.R[k], recording_.p[k] / known_.pose_scale,
                   recording_.q.col(static_cast<Eigen::Index>(k)));
    if (const double h = lowest(kinematics); std::isfinite(h)) heights.push_back(h);
  }
  return heights.empty() ? 0.0 : quantile(heights, 0.05);
}

/// Velocities are those of a few rows around the first, all in the air or none: one row alone is
/// noise, and a hit between them is no velocity.
BaseRollOut::State BaseRollOut::start(const Span& shot) const {
  const WholeRecording& r = recording_;
  const std::size_t first = shot.first;
  BodyKinematics kinematics(body_);
  const auto flies = [&](std::size_t k) {
    kinematics.set(r.R[k], r.p[k] / known_.pose_scale, r.q.col(static_cast<Eigen::Index>(k)));
    return lowest(kinematics) - ground_ > kTouches_m;
  };
  const bool falls = flies(first);
  const auto alike = [&](std::size_t k) {
    return r.piece[k] == r.piece[first] && flies(k) == falls;
  };
  std::size_t a = first, b = first;
  while (a > 0 && first - a < kHalfWindow && alike(a - 1)) --a;
  while (b + 1 < r.rows() && b - first < kHalfWindow && alike(b + 1)) ++b;
  State s;
  s.R = r.R[first], s.p = r.p[first] / known_.pose_scale;
  double n = 0.0, sum_t = 0.0, sum_tt = 0.0;
  V3 sum_p = V3::Zero(), sum_tp = V3::Zero();
  for (std::size_t k = a; k <= b; ++k) {
    const double t = r.t[k] - r.t[first];
    V3 p = r.p[k] / known_.pose_scale;
    if (falls) p -= 0.5 * t * t * gravity_;
    n += 1.0, sum_t += t, sum_tt += t * t, sum_p += p, sum_tp += t * p;
    s.w += r.R[k] * r.w[k];
  }
  s.w /= n;
  s.v = n > 2.0 ? V3((n * sum_tp - sum_t * sum_p) / (n * sum_tt - sum_t * sum_t))
                : V3(r.v[first] / known_.pose_scale);
  return s;
}

/// Points that would go into the ground during this step.
std::vector<BaseRollOut::Contact> BaseRollOut::contacts(const State& s, const BodyKinematics& now,
                                                        const BodyKinematics& later,
                                                        double h) const {
  const V3 com = now.com(), v_com = s.linear / now.mass();
  std::vector<Contact> out;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const TouchPoint& point = points_[i];
    const V3 at = now.at(point.joint, point.at), under = at - point.radius * normal_;
    const double gap = normal_.dot(under) - ground_;
    Contact c{under - com, (later.at(point.joint, point.at) - at - (later.com() - com)) / h};
    const double into = -normal_.dot(v_com + s.w.cross(c.arm) + c.moved);
    if (gap - h * into > 0.0) continue;
    c.friction = friction_[i];
    if (into > kRebounds_m_s) c.rebound = restitution_ * into;
    out.push_back(c);
  }
  return out;
}

/// Impulses at all that touches, each against the others.
void BaseRollOut::push(State& s, std::vector<Contact>& touching, const Inertia& whole) const {
  const auto add = [&](const V3& impulse, const V3& arm) {
    s.linear += impulse, s.angular += arm.cross(impulse);
    s.w = whole.I_inverse * (s.angular - whole.spun);
  };
  const auto yields = [&](const V3& arm, const V3& way) {  // velocity that an impulse there gives
    return 1.0 / whole.mass + way.dot((whole.I_inverse * arm.cross(way)).cross(arm));
  };
  const auto velocity = [&](const Contact& c) {
    return V3(s.linear / whole.mass + s.w.cross(c.arm) + c.moved);
  };
  for (int sweep = 0; sweep < (touching.empty() ? 0 : kSweeps); ++sweep) {
    for (Contact& c : touching) {
      const double wanted = (c.rebound - normal_.dot(velocity(c))) / yields(c.arm, normal_);
      const double more = std::max(-c.along, wanted);
      c.along += more;
      add(more * normal_, c.arm);
      const V3 v = velocity(c), slip = v - normal_.dot(v) * normal_;
      if (slip.norm() < 1e-12) continue;
      V3 across = c.across - slip / yields(c.arm, slip.normalized());
      if (const double most = c.friction * c.along; across.norm() > most)
        across *= most / across.norm();
      add(across - c.across, c.arm);
      c.across = across;
    }
  }
}

void BaseRollOut::step(State& s, const Eigen::VectorXd& q, const Eigen::VectorXd& q_next,
                       double h) const {
  BodyKinematics now(body_), later(body_);
  now.set(s.R, s.p, q), later.set(s.R, s.p, q_next);
  const V3 com = now.com();
  const M3 I = now.inertia();
  const Inertia whole{now.mass(), now.spin_to(later) / h, I.inverse()};
  if (!s.begun) {
    s.linear = whole.mass * (s.v + s.w.cross(com - s.p) + (later.com() - com) / h);
    s.angular = I * s.w + whole.spun;
    s.begun = true;
  }
  const V3 v_before = s.linear / whole.mass;
  s.linear += h * whole.mass * gravity_;
  s.w = whole.I_inverse * (s.angular - whole.spun);
  std::vector<Contact> touching = contacts(s, now, later, h);
  push(s, touching, whole);
  const M3 turn = turn_of(h * s.w);
  const V3 com_next = com + 0.5 * h * (v_before + s.linear / whole.mass);
  s.p = com_next - turn * (later.com() - s.p);
  s.R = turn * s.R;
  now.set(s.R, s.p, q_next);
  // positions are put right without a velocity, which would throw the robot up
  if (const double depth = ground_ - lowest(now); depth > 0.0) s.p += kPushedOut * depth * normal_;
}

BaseMotion BaseRollOut::from(const Span& shot) const {
  const WholeRecording& r = recording_;
  State s = start(shot);
  BaseMotion out;
  for (std::size_t k = shot.first; k < shot.last; ++k) {
    out.p.push_back(known_.pose_scale * s.p), out.R.push_back(s.R);
    if (k + 1 == shot.last) break;
    const Eigen::VectorXd a = r.q.col(static_cast<Eigen::Index>(k)),
                          b = r.q.col(static_cast<Eigen::Index>(k + 1));
    const double seconds = r.t[k + 1] - r.t[k];
    const int steps = std::max(1, static_cast<int>(std::ceil(seconds / kStep_s)));
    for (int i = 0; i < steps; ++i)
      step(s, a + (b - a) * i / steps, a + (b - a) * (i + 1) / steps, seconds / steps);
  }
  return out;
}

}  // namespace sanso::diagnose
