// A foot that stands flat shows the vertical of the floor through attitude and joints, and whether
// it slips.
#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>

#include "tools/diagnose/stats/robust.h"
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

/// Normal of the foot's lowest face in the frame of its joint, pointing out of the ground; nothing
/// where the shape has no flat face below.
std::optional<V3> sole_normal(const WholeBody& body, const FootForce& foot) {
  std::vector<V3> points;
  for (const CollisionShape& s : body.shapes) {
    if (s.link == foot.link && s.radius == 0.0)
      for (const Vec3& p : s.points) points.push_back(eigen(p));
  }
  if (points.size() < 4) return std::nullopt;
  BodyKinematics kinematics(body);
  kinematics.set(M3::Identity(), V3::Zero(), Eigen::VectorXd::Zero(body.model.tree.size()));
  const M3& R = kinematics.rotation(foot.joint);
  const V3 up = upwards(body);
  std::sort(points.begin(), points.end(),
            [&](const V3& a, const V3& b) { return up.dot(R * a) < up.dot(R * b); });
  V3 middle = V3::Zero();
  for (std::size_t i = 0; i < 4; ++i) middle += 0.25 * points[i];
  M3 spread = M3::Zero();
  for (std::size_t i = 0; i < 4; ++i)
    spread += (points[i] - middle) * (points[i] - middle).transpose();
  const Eigen::SelfAdjointEigenSolver<M3> axes(spread);
  if (axes.eigenvalues()[1] < 1e-8) return std::nullopt;  // an edge, no face
  const V3 normal = axes.eigenvectors().col(0);
  return up.dot(R * normal) > 0.0 ? normal : V3(-normal);
}

struct Soles {
  std::map<std::string, std::array<Samples, 2>> tilt;  // by foot: about the base's x and y, rad
  std::vector<double> slips;                           // m/s, one a stance
  double stances = 0.0;
};

void add_foot(const Asking& asking, std::size_t number, const FootForce& foot, Soles& soles) {
  const WholeRecording& r = asking.recordings[number];
  const std::optional<V3> normal = sole_normal(asking.body, foot);
  const V3 up = upwards(asking.body);
  BodyKinematics kinematics(asking.body);
  for (const Span& s : spans(r, standing(asking, r, foot))) {
    if (r.t[s.last - 1] - r.t[s.first] < asking.settings.rest_time) continue;
    soles.stances += 1.0;
    V3 first = V3::Zero(), last = V3::Zero();
    // touchdown and lift-off roll over the edges
    const std::size_t edge = s.rows() / 5;
    for (std::size_t k = s.first + edge; k < s.last - edge; ++k) {
      kinematics.set(r.R[k], r.p[k], r.q.col(static_cast<Eigen::Index>(k)));
      last = kinematics.origin(foot.joint);
      if (k == s.first + edge) first = last;
      if (!normal) continue;
      // in axes that turn with the heading: what tilts with the robot stays what it is
      const V3 x = r.R[k].col(0) - up.dot(r.R[k].col(0)) * up;
      const V3 ahead = x.norm() > 1e-6 ? V3(x.normalized()) : V3(V3::UnitX());
      const V3 n = kinematics.rotation(foot.joint) * *normal, left = up.cross(ahead);
      const int group = asking.group_of(number, r.t[k] - r.t.front());
      auto& tilt = soles.tilt[foot.link];
      tilt[0].add(-left.dot(n), 1.0, group), tilt[1].add(ahead.dot(n), 1.0, group);
    }
    const double seconds = r.t[s.last - edge - 1] - r.t[s.first + edge];
    const V3 along = (last - first) - up.dot(last - first) * up;
    if (r.position && seconds > 0.0) soles.slips.push_back(along.norm() / seconds);
  }
}

void judge_slip(const Asking& asking, const Soles& soles, WholeAnswers& answers) {
  if (soles.slips.empty()) {
    answers.cannot("contact_friction", "no base position: nobody knows whether a foot slips");
    return;
  }
  const double fast = quantile(soles.slips, 0.9);
  answers.notes.push_back(
      fmt::format("{} stances; the feet drift by {:.3g} m/s, the faster tenth "
                  "by {:.3g} m/s",
                  soles.slips.size(), median(soles.slips), fast));
  if (fast < asking.settings.slip_speed) {
    answers.cannot("contact_friction", "no foot slips: friction is bounded from below only");
  } else {
    answers.cannot("contact_friction",
                   "feet slip, and no forces along the ground were recorded to compare with");
  }
}

/// Both soles alike: the floor, the attitude or the IMU behind it; one alone: its leg.
void judge_tilt(const Asking& asking, Soles& soles, WholeAnswers& answers) {
  if (soles.tilt.empty()) {
    answers.cannot("ground_slope",
                   "no flat sole below a foot with fz:<link> (URDF <collision> box "
                   "or [[contact]] box)");
    return;
  }
  constexpr const char* kAxes[] = {"x", "y"};
  for (std::size_t axis = 0; axis < 2; ++axis) {
    Samples common;
    std::string feet;
    for (auto& [link, tilt] : soles.tilt) {
      const auto m = measured(tilt[axis], 0.0, asking.seed);
      if (!m) continue;
      feet += fmt::format("{}{} {:.4f} [{:.4f}, {:.4f}]", feet.empty() ? "" : ", ", link, m->value,
                          m->low, m->high);
      for (std::size_t i = 0; i < tilt[axis].value.size(); ++i)
        common.add(tilt[axis].value[i], 1.0, tilt[axis].group[i]);
    }
    if (feet.empty()) continue;
    answers.notes.push_back(
        fmt::format("standing soles lean about {} by {} rad", kAxes[axis], feet));
    const auto m = measured(common, 0.0, asking.seed);
    if (m)
      answers.judge({"ground_slope",
                     "contact",
                     {},
                     kAxes[axis],
                     "rad",
                     "stance",
                     0.0,
                     asking.settings.sole_tilt,
                     {"imu_misalignment", "encoder_offset"},
                     std::string("sole:") + kAxes[axis]},
                    *m, asking.decisions);
  }
}

}  // namespace

void ask_soles(const Asking& asking, WholeAnswers& answers, Patch&) {
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
    answers.cannot("ground_slope", "no foot that is known to stand (fz:<link>) beside an attitude");
    return;
  }
  judge_slip(asking, soles, answers);
  judge_tilt(asking, soles, answers);
}

}  // namespace sanso::diagnose
