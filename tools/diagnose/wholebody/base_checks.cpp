// A refusal here needs two readings: the one that was promised does not fit, another does.
#include "tools/diagnose/wholebody/base_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "shared/math/so3.h"
#include "tools/diagnose/stats/robust.h"

namespace sanso::diagnose {
namespace {

constexpr const char* kUnknownLink = "unknown link";
constexpr double kGravity = 9.81;

struct Columns {
  const char* kind;
  const char* parts;
};
constexpr Columns kSets[] = {{"base_p", "xyz"}, {"base_q", "wxyz"}, {"base_v", "xyz"},
                             {"base_w", "xyz"}, {"imu_acc", "xyz"}, {"imu_gyro", "xyz"}};

std::vector<Defect> incomplete_sets(const recording::Recording& r) {
  std::vector<Defect> out;
  for (const auto& [kind, parts] : kSets) {
    std::string missing, any;
    for (const char* c = parts; *c != 0; ++c) {
      const std::string name = std::string(kind) + ":" + *c;
      (r.has(name) ? any : missing) = name;
    }
    if (!missing.empty() && !any.empty())
      out.push_back({r.file, missing, -1, defect::kMissingChannel,
                     any + " is there, " + missing + " is not; a vector needs all of its parts"});
  }
  if (!r.has("base_q:w") && !r.has("imu_acc:x"))
    out.push_back({r.file, "base_q:w", -1, defect::kMissingChannel,
                   "neither base_q:w,x,y,z nor imu_acc:x,y,z: nothing says where the floating base "
                   "is; record one of them, or write base = \"fixed\" for a robot in a stand"});
  return out;
}

std::vector<Defect> bad_values(const recording::Recording& r, const BaseSettings& base) {
  std::vector<Defect> out;
  for (const recording::Channel& c : r.channels) {
    const auto bad =
        std::find_if(c.values.begin(), c.values.end(), [](double v) { return std::isinf(v); });
    if (bad != c.values.end())
      out.push_back(
          {r.file, c.name, bad - c.values.begin(), defect::kNotANumber, "infinite value"});
  }
  for (const char* part : {"base_q:w", "base_q:x", "base_q:y", "base_q:z"}) {
    if (!r.has(part)) return out;
  }
  const auto w = r.find("base_q:w"), x = r.find("base_q:x"), y = r.find("base_q:y"),
             z = r.find("base_q:z");
  for (std::size_t k = 0; k < r.rows(); ++k) {
    const double norm = std::sqrt(w[k] * w[k] + x[k] * x[k] + y[k] * y[k] + z[k] * z[k]);
    if (std::isnan(norm) || std::abs(norm - 1.0) < base.quaternion) continue;
    out.push_back({r.file, "base_q:w", static_cast<long>(k), defect::kWrongUnit,
                   fmt::format("norm {:.3g}; expected a unit quaternion w x y z", norm)});
    break;
  }
  return out;
}

std::vector<Defect> bad_joints(const recording::Recording& r, const WholeBody& body,
                               const BaseSettings& base) {
  std::vector<Defect> out;
  const Unrecorded none = unrecorded_joints(r, body);
  if (none.mass_share > base.unrecorded_mass) {
    out.push_back({r.file, "q:" + none.joints.front(), -1, defect::kMissingChannel,
                   fmt::format("{} joints are not recorded, with {:.0f} % of the mass behind them; "
                               "expected q:{}",
                               none.joints.size(), 100 * none.mass_share, none.joints.front())});
  }
  for (const TreeJoint& joint : body.model.tree.joints) {
    const auto q = r.find("q:" + joint.name);
    if (q.empty() || joint.prismatic || !(joint.lower < joint.upper)) continue;
    const double reach = std::max(std::abs(joint.lower), std::abs(joint.upper));
    const double seen = std::max(std::abs(quantile(q, 0.05)), std::abs(quantile(q, 0.95)));
    if (seen > 2.0 * reach + base.beyond_limits)
      out.push_back({r.file, "q:" + joint.name, -1, defect::kWrongUnit,
                     fmt::format("reaches {:.3g}, the URDF's limits {:.3g} rad; expected rad, "
                                 "these may be degrees or counts",
                                 seen, reach)});
  }
  return out;
}

std::vector<Defect> bad_feet(const recording::Recording& r, const WholeBody& body) {
  std::vector<Defect> out;
  for (const recording::Channel& c : r.channels) {
    if (c.name.starts_with("fz:") && !body.model.tree.links.contains(c.name.substr(3)))
      out.push_back({r.file, c.name, -1, kUnknownLink,
                     "no link " + c.name.substr(3) + " in the URDF; expected fz:<link of a foot>"});
  }
  return out;
}

std::vector<V3> vectors(const recording::Recording& r, const std::string& kind) {
  const auto x = r.find(kind + ":x"), y = r.find(kind + ":y"), z = r.find(kind + ":z");
  std::vector<V3> out;
  for (std::size_t k = 0; k < x.size(); ++k) out.emplace_back(x[k], y[k], z[k]);
  return out;
}

/// Pooled over the three axes: how well b = slope * a holds.
struct Agreement {
  double correlation = 0.0, slope = 0.0, rms = 0.0;  // of a
  bool holds(const BaseSettings& base) const { return correlation > 1.0 - base.agrees; }
  bool turned_round(const BaseSettings& base) const { return correlation < base.agrees - 1.0; }
  bool other_unit(const BaseSettings& base, const GateSettings& gate) const {
    return holds(base) && (slope > gate.wrong_unit || slope * gate.wrong_unit < 1.0);
  }
  /// Holds without doubt, and where the promised reading holds less.
  bool better_than(const Agreement& promised, const BaseSettings& base) const {
    return correlation > 1.0 - 0.5 * base.agrees &&
           correlation > promised.correlation + base.better;
  }
};
Agreement agreement(const std::vector<V3>& a, const std::vector<V3>& b, int least) {
  double aa = 0.0, bb = 0.0, ab = 0.0;
  std::size_t rows = 0;
  for (std::size_t k = 0; k < std::min(a.size(), b.size()); ++k) {
    if (!a[k].allFinite() || !b[k].allFinite()) continue;
    aa += a[k].squaredNorm(), bb += b[k].squaredNorm(), ab += a[k].dot(b[k]), ++rows;
  }
  if (rows < static_cast<std::size_t>(least) || aa <= 0.0 || bb <= 0.0) return {};
  return {ab / std::sqrt(aa * bb), ab / aa, std::sqrt(aa / static_cast<double>(rows))};
}

/// Turning over short windows, by the attitude: in base axes, and in world axes.
struct Turning {
  std::vector<V3> base, world, recorded, mistaken;
};
Turning turning(const recording::Recording& r, const WholeRecording& made, double window) {
  Turning out;
  const std::vector<V3> w = vectors(r, "base_w");
  const auto qw = r.find("base_q:w"), qx = r.find("base_q:x"), qy = r.find("base_q:y"),
             qz = r.find("base_q:z");
  const auto other = [&](std::size_t k) {  // the same numbers read as x y z w
    return math::rotation_matrix(math::quat_normalized(math::Quat(qz[k], qw[k], qx[k], qy[k])));
  };
  const auto step = static_cast<std::size_t>(std::max(2.0, std::round(window / made.interval)));
  for (std::size_t a = 0; a + step < made.rows(); a += step) {
    const std::size_t b = a + step;
    if (made.piece[a] != made.piece[b]) continue;
    V3 sum = V3::Zero();
    for (std::size_t k = a; k <= b; ++k) sum += w[k];
    const double seconds = made.t[b] - made.t[a];
    const std::size_t m = (a + b) / 2;
    const V3 turn = made.R[m].transpose() * made.R[a] * turned(made.R[a], made.R[b]) / seconds;
    out.base.push_back(turn);
    out.world.push_back(made.R[m] * turn);
    out.recorded.push_back(sum / static_cast<double>(step + 1));
    out.mistaken.push_back(other(m).transpose() * other(a) * turned(other(a), other(b)) / seconds);
  }
  return out;
}

std::vector<Defect> bad_turning(const recording::Recording& r, const WholeRecording& made,
                                const Settings& settings) {
  const BaseSettings& base = settings.base;
  if (!r.has("base_w:x") || !made.attitude) return {};
  const Turning turn = turning(r, made, base.turning_window);
  const Agreement promised = agreement(turn.base, turn.recorded, base.compared);
  if (promised.rms < base.least_turning) return {};
  const auto defect = [&](const char* what, const std::string& message) {
    return std::vector<Defect>{{r.file, "base_w:x", -1, what, message}};
  };
  if (promised.other_unit(base, settings.gate))
    return defect(defect::kWrongUnit,
                  fmt::format("{:.3g} times what base_q turns; expected rad/s", promised.slope));
  if (promised.turned_round(base))
    return defect(defect::kWrongSign,
                  "turns against base_q; expected base_q from base axes into "
                  "world axes and base_w in base axes");
  const auto better = [&](const std::vector<V3>& other) {
    return agreement(other, turn.recorded, base.compared).better_than(promised, base);
  };
  if (better(turn.mistaken))
    return {{r.file, "base_q:w", -1, defect::kSwapped,
             "base_q agrees with base_w when it is read as x y z w; expected w x y z"}};
  if (better(turn.world))
    return defect(defect::kSwapped, "agrees with base_q in world axes; expected base axes");
  return {};
}

std::vector<Defect> bad_velocity(const recording::Recording& r, const WholeRecording& made,
                                 const Settings& settings) {
  const BaseSettings& base = settings.base;
  if (!made.position) return {};
  std::vector<V3> slope, body, recorded;
  const std::vector<V3> v = vectors(r, "base_v");
  const auto step =
      static_cast<std::size_t>(std::max(1.0, std::round(base.velocity_window / made.interval)));
  for (std::size_t a = 0; a + step < made.rows(); a += step) {
    const std::size_t b = a + step;
    if (made.piece[a] != made.piece[b]) continue;
    const V3 s = (made.p[b] - made.p[a]) / (made.t[b] - made.t[a]);
    slope.push_back(s);
    body.push_back(made.R[(a + b) / 2].transpose() * s);
    recorded.push_back(v.empty() ? s : V3(0.5 * (v[a] + v[b])));
  }
  const Agreement promised = agreement(slope, recorded, base.compared);
  if (promised.rms > base.fastest)
    return {{r.file, "base_p:x", -1, defect::kWrongUnit,
             fmt::format("moves at {:.3g} m/s; expected m, these may be mm", promised.rms)}};
  if (v.empty() || promised.rms < base.least_speed) return {};
  if (promised.other_unit(base, settings.gate))
    return {{r.file, "base_v:x", -1, defect::kWrongUnit,
             fmt::format("{:.3g} times what base_p moves; expected m/s", promised.slope)}};
  if (promised.turned_round(base))
    return {{r.file, "base_v:x", -1, defect::kWrongSign, "moves against base_p"}};
  if (promised.correlation < 1.0 - base.disagrees &&
      agreement(body, recorded, base.compared).holds(base))
    return {{r.file, "base_v:x", -1, defect::kSwapped,
             "agrees with base_p in base axes; expected world axes"}};
  return {};
}

/// Whether two numbers are the same but for what gains and payloads make of them.
bool about(double a, double b, double slack) {
  return a > b / (1.0 + slack) && a < b * (1.0 + slack);
}

std::vector<Defect> bad_acceleration(const recording::Recording& r, const WholeRecording& made,
                                     const BaseSettings& base) {
  if (!made.acc) return {};
  std::vector<double> norms;
  for (const V3& a : made.imu_acc) norms.push_back(a.norm());
  const double usual = median(norms);
  // a robot that stands or walks is pulled by one g most of the time
  if (about(usual, kGravity, base.unit_slack)) return {};
  const char* guess = about(usual, 1.0, base.unit_slack) ? ", these may be g" : "";
  return {{r.file, "imu_acc:x", -1, defect::kWrongUnit,
           fmt::format("usually {:.3g} long; expected specific force in m/s^2, 9.81 at rest{}",
                       usual, guess)}};
}

std::vector<Defect> bad_forces(const WholeRecording& made, const WholeBody& body,
                               const Settings& settings) {
  if (made.feet.empty()) return {};
  std::vector<double> sums;
  for (std::size_t k = 0; k < made.rows(); ++k) {
    double sum = 0.0;
    for (const FootForce& foot : made.feet) sum += foot.fz[k];
    sums.push_back(sum);
  }
  const double share = median(sums) / (body.mass() * kGravity);
  const std::string column = "fz:" + made.feet.front().link;
  if (share < -settings.base.pulled)
    return {{made.file, column, -1, defect::kWrongSign,
             fmt::format("the feet carry {:.2g} of the weight; expected the force of the ground "
                         "on the foot, upwards positive",
                         share)}};
  if (about(share, 1.0 / kGravity, settings.base.unit_slack))
    return {
        {made.file, column, -1, defect::kWrongUnit,
         fmt::format("the feet carry {:.2g} of the weight; expected N, these may be kg", share)}};
  if (share > settings.gate.wrong_unit)
    return {{made.file, column, -1, defect::kWrongUnit,
             fmt::format("the feet carry {:.2g} times the weight; expected N", share)}};
  return {};
}

}  // namespace

Unrecorded unrecorded_joints(const recording::Recording& r, const WholeBody& body) {
  Unrecorded out;
  const auto& joints = body.model.tree.joints;
  std::vector<char> behind(joints.size(), 0);
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const bool missing = !r.has("q:" + joints[j].name);
    if (missing) out.joints.push_back(joints[j].name);
    const bool up = joints[j].parent >= 0 && behind[static_cast<std::size_t>(joints[j].parent)];
    behind[j] = missing || up ? 1 : 0;
    if (behind[j]) out.mass_share += joints[j].body.mass / body.mass();
  }
  return out;
}

std::vector<Defect> check_base_columns(const recording::Recording& r, const WholeBody& body,
                                       const Settings& settings) {
  std::vector<Defect> out = incomplete_sets(r);
  for (auto&& more :
       {bad_values(r, settings.base), bad_joints(r, body, settings.base), bad_feet(r, body)})
    out.insert(out.end(), more.begin(), more.end());
  return out;
}

std::vector<Defect> check_base_agreement(const recording::Recording& r, const WholeRecording& made,
                                         const WholeBody& body, const Settings& settings) {
  std::vector<Defect> out = bad_turning(r, made, settings);
  for (auto&& more : {bad_velocity(r, made, settings), bad_acceleration(r, made, settings.base),
                      bad_forces(made, body, settings)})
    out.insert(out.end(), more.begin(), more.end());
  return out;
}

}  // namespace sanso::diagnose
