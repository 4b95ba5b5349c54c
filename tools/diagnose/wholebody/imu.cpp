// What the IMU should read follows from the base's motion alone: no joint torque, no contact and no
// mass stands between them. A turned IMU turns both its vectors; a wrong vertical of the base's
// attitude turns the specific force alone.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "shared/math/so3.h"
#include "tools/diagnose/compare/measured_motion.h"
#include "tools/diagnose/stats/random.h"
#include "tools/diagnose/stats/robust.h"
#include "tools/diagnose/stats/significance.h"
#include "tools/diagnose/stats/smoother.h"
#include "tools/diagnose/wholebody/imu_choice.h"
#include "tools/diagnose/wholebody/questions.h"

namespace sanso::diagnose {
namespace {

/// Track of the assumed IMU: where it is and how it is turned, row by row.
struct ImuTrack {
  std::vector<M3> R;
  std::vector<V3> acceleration;  // world, m/s^2; zeros without positions
};

ImuTrack imu_track(const Asking& asking, const WholeRecording& r) {
  ImuTrack out;
  BodyKinematics kinematics(asking.body);
  const ImuPlace& imu = asking.body.imu;
  std::array<std::vector<double>, 3> x;
  for (std::size_t k = 0; k < r.rows(); ++k) {
    kinematics.set(r.R[k], r.p[k] / asking.known.pose_scale, r.q.col(static_cast<Eigen::Index>(k)));
    out.R.push_back(kinematics.rotation(imu.joint) * eigen(imu.R_joint_imu));
    const V3 p = kinematics.at(imu.joint, eigen(imu.p_joint_imu));
    for (std::size_t i = 0; i < 3; ++i) x[i].push_back(p[static_cast<Eigen::Index>(i)]);
  }
  out.acceleration.assign(r.rows(), V3::Zero());
  if (!r.position) return out;
  for (std::size_t i = 0; i < 3; ++i) {
    const SmoothedState s = smooth_position(r.t, x[i], position_noise(x[i]), asking.smoother);
    for (std::size_t k = 0; k < r.rows(); ++k)
      out.acceleration[k][static_cast<Eigen::Index>(i)] = s.ddq[k];
  }
  return out;
}

V3 mean_of(const std::vector<V3>& x, std::size_t a, std::size_t b) {
  V3 sum = V3::Zero();
  for (std::size_t k = a; k <= b; ++k) sum += x[k];
  return sum / static_cast<double>(b - a + 1);
}

/// Windows of one recording; `leans`: the upright that each reads with this mount, in world axes.
void add_windows(const Asking& asking, std::size_t number, std::vector<ImuWindow>& out,
                 const ImuMount* mount = nullptr, Leans* leans = nullptr) {
  const WholeRecording& r = asking.recordings[number];
  if (!r.acc || !r.attitude) return;
  const ImuTrack track = imu_track(asking, r);
  const V3 gravity = eigen(asking.body.model.gravity);
  const Level level(upwards(asking.body));
  std::vector<V3> predicted;
  for (std::size_t k = 0; k < r.rows(); ++k)
    predicted.push_back(track.R[k].transpose() * (track.acceleration[k] - gravity));
  const auto step =
      static_cast<std::size_t>(std::max(2.0, std::round(asking.settings.window / r.interval)));
  for (std::size_t a = 0; a + step < r.rows(); a += step) {
    const std::size_t b = a + step, m = (a + b) / 2;
    if (r.piece[a] != r.piece[b]) continue;
    ImuWindow w;
    w.acc_predicted = mean_of(predicted, a, b);
    w.acc = mean_of(r.imu_acc, a, b) - asking.known.acc_bias;
    w.with_gyro = r.gyro;
    w.gyro_predicted =
        track.R[m].transpose() * track.R[a] * turned(track.R[a], track.R[b]) / (r.t[b] - r.t[a]);
    if (r.gyro) w.gyro = mean_of(r.imu_gyro, a, b) - asking.known.gyro_bias;
    w.group = asking.group_of(number, r.t[a] - r.t.front());
    if (!w.acc.allFinite() || !w.gyro.allFinite()) continue;
    out.push_back(w);
    if (leans == nullptr) continue;
    const double t = r.t[a] - r.t.front();
    const V3 felt = track.R[m] * mount->turn.transpose() * (w.acc - mount->acc_bias);
    const V3 upright = felt - mean_of(track.acceleration, a, b);
    leans->add(level.lean(upright.normalized()) - lean_of(asking.known.pose_tilt),
               level.heading(r.R[m]), "imu", number,
               static_cast<std::size_t>(t / asking.settings.block), w.group);
  }
}

V3 rotation_vector(const M3& R) { return turned(M3::Identity(), R); }

/// Covariances by resampling groups: of the turn, of the biases. The axis about which the robot
/// turns most is the one about which the mount is known least, so axes are not averaged.
struct Spread {
  M3 turn = M3::Zero(), acc_bias = M3::Zero(), gyro_bias = M3::Zero();
};

V3 deviations_of(const M3& covariance) { return covariance.diagonal().cwiseSqrt(); }

/// In the direction of x; of nothing the largest.
double deviation_along(const M3& covariance, const V3& x) {
  const double size = x.norm();
  if (size <= 0.0) return deviations_of(covariance).maxCoeff();
  return std::sqrt(std::max(0.0, x.dot(covariance * x))) / size;
}

Spread spread_of(const std::vector<ImuWindow>& windows, const ImuMount& whole,
                 const ImuParts& parts, const Asking& asking) {
  std::vector<std::vector<const ImuWindow*>> groups;
  for (const ImuWindow& w : windows) {
    groups.resize(std::max(groups.size(), w.group + 1));
    groups[w.group].push_back(&w);
  }
  std::erase_if(groups, [](const auto& g) { return g.empty(); });
  Random random(asking.seed, 31);
  Spread out;
  const std::size_t n = groups.size();
  const int draws = asking.settings.imu_draws;
  for (int d = 0; d < draws; ++d) {
    std::vector<ImuWindow> drawn;
    for (std::size_t k = 0; k < n; ++k) {
      for (const ImuWindow* w : groups[random.below(n)]) drawn.push_back(*w);
    }
    const ImuMount m = fit_mount(drawn, asking.settings, parts);
    const V3 turn = rotation_vector(m.turn * whole.turn.transpose());
    const V3 acc = m.acc_bias - whole.acc_bias, gyro = m.gyro_bias - whole.gyro_bias;
    out.turn += turn * turn.transpose();
    out.acc_bias += acc * acc.transpose(), out.gyro_bias += gyro * gyro.transpose();
  }
  const auto drawn_groups = static_cast<double>(n);
  const double widen = drawn_groups / std::max(1.0, drawn_groups - 1.0) / draws;
  for (M3* s : {&out.turn, &out.acc_bias, &out.gyro_bias}) *s *= widen;
  return out;
}

/// Error on held-out groups with nothing changed, and with what the others say.
FitScore held_out(const std::vector<ImuWindow>& windows, const ImuParts& parts,
                  const Asking& asking) {
  std::vector<ImuWindow> fitted, left;
  for (const ImuWindow& w : windows) (w.group % 3 == 2 ? left : fitted).push_back(w);
  const ImuMount m = fit_mount(fitted, asking.settings, parts);
  FitScore s;
  s.nominal = acc_error(left, {}), s.patched = acc_error(left, m), s.noise = m.acc_rms;
  return s;
}

/// A link of the URDF that is turned as the IMU is found to be; empty: none.
std::string link_like(const WholeBody& body, const M3& R_joint_imu, int joint, double nearest) {
  std::string best;
  for (const auto& [name, place] : body.model.tree.links) {
    if (place.joint != joint) continue;
    const double off = turned(eigen(place.R_joint_link), R_joint_imu).norm();
    if (off < nearest) nearest = off, best = name;
  }
  return best;
}

Finding vector_finding(WholeFigure figure, const std::vector<std::string>& where,
                       const std::vector<std::string>& names, const V3& value, const M3& covariance,
                       const std::string& unit, const FitScore& score, const Chance& chance) {
  Finding f;
  const Effect& effect = effect_of(figure);
  f.effect = effect.id, f.family = to_string(effect.family);
  f.where = where, f.regime = "everywhere";
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    const double x = value[axis], off = kNormal95 * deviations_of(covariance)[axis];
    f.parameters[names[i]] = {x, x - off, x + off, unit, false};
  }
  f.heldout_gain = score.nominal > 0.0
                       ? 1.0 - score.patched * score.patched / (score.nominal * score.nominal)
                       : 0.0;
  f.p_family =
      chance.family_wise(value.norm() / std::max(deviation_along(covariance, value), 1e-300));
  f.one_of = {f.effect};
  return f;
}

/// Across an axis, rad/s RMS: turning about the axis of a turn says nothing of it.
double rms_turning_across(const V3& axis, const std::vector<ImuWindow>& windows) {
  double sum = 0.0;
  for (const ImuWindow& w : windows)
    sum += w.with_gyro ? axis.cross(w.gyro_predicted).squaredNorm() : 0.0;
  return std::sqrt(sum / static_cast<double>(windows.size()));
}

struct Judged {
  const std::vector<ImuWindow>& windows;
  ImuChoice choice;
  ImuMount mount;
  Spread spread;
  FitScore score;
  double z = 0.0;  // standard deviations beyond which a size is no chance
};

/// In words, for the log and the notes.
std::string text_of(const V3& x, const M3& covariance, const std::string& unit) {
  const V3 s = deviations_of(covariance);
  return fmt::format("[{:.4g}, {:.4g}, {:.4g}] +- [{:.2g}, {:.2g}, {:.2g}] {}", x[0], x[1], x[2],
                     s[0], s[1], s[2], unit);
}

Answered judge_turn(const Asking& asking, const Judged& j) {
  Answered out;
  const V3 turn = rotation_vector(j.mount.turn);
  const double surely = j.z * deviation_along(j.spread.turn, turn) + asking.settings.mount;
  out.answers.detectable.push_back(
      {name_of(WholeFigure::imu_turn), asking.body.imu.link, "x, y, z", "rad",
       j.z * deviations_of(j.spread.turn).maxCoeff() + asking.settings.mount});
  out.answers.log.push_back("imu turned by " + text_of(turn, j.spread.turn, "rad"));
  if (!j.choice.parts.turn || turn.norm() <= surely) return out;
  Finding f = vector_finding(WholeFigure::imu_turn, {asking.body.imu.link}, {"x", "y", "z"}, turn,
                             j.spread.turn, "rad", j.score, asking.chance());
  const bool by_gyro =
      rms_turning_across(turn.normalized(), j.windows) > asking.settings.enough_turning;
  if (!by_gyro && turn.norm() < asking.settings.surely_mounted)
    f.one_of.push_back(name_of(WholeFigure::slope));
  if (j.choice.bias_rivals) f.one_of.push_back(name_of(WholeFigure::imu_bias));
  f.status = status_of(f);
  out.answers.findings.push_back(f);
  out.patch.imu_turn = turn;
  const M3 R_true = eigen(asking.body.imu.R_joint_imu) * j.mount.turn.transpose();
  const std::string link =
      link_like(asking.body, R_true, asking.body.imu.joint, asking.settings.same_frame);
  if (!link.empty() && link != asking.body.imu.link)
    out.answers.notes.push_back("the IMU is turned as the link " + link +
                                " of the URDF is: [imu] link = \"" + link + "\"");
  return out;
}

Answered judge_biases(const Asking& asking, const Judged& j) {
  Answered out;
  const bool gyro = std::any_of(j.windows.begin(), j.windows.end(),
                                [](const ImuWindow& w) { return w.with_gyro; });
  const double of_gyro =
      j.z * deviation_along(j.spread.gyro_bias, j.mount.gyro_bias) + asking.settings.gyro_bias;
  const double of_acc =
      j.z * deviation_along(j.spread.acc_bias, j.mount.acc_bias) + asking.settings.acc_bias;
  const std::vector<std::string> where{asking.body.imu.link};
  const std::string bias = name_of(WholeFigure::imu_bias);
  out.answers.detectable.push_back({bias, asking.body.imu.link, "acc", "m/s^2", of_acc});
  out.answers.log.push_back("imu biases: gyro " +
                            text_of(j.mount.gyro_bias, j.spread.gyro_bias, "rad/s") + ", acc " +
                            text_of(j.mount.acc_bias, j.spread.acc_bias, "m/s^2"));
  if (gyro) {
    out.answers.detectable.push_back({bias, asking.body.imu.link, "gyro", "rad/s", of_gyro});
    if (j.mount.gyro_bias.norm() > of_gyro) {
      Finding f =
          vector_finding(WholeFigure::imu_bias, where, {"gyro_x", "gyro_y", "gyro_z"},
                         j.mount.gyro_bias, j.spread.gyro_bias, "rad/s", {}, asking.chance());
      f.status = status_of(f);
      out.answers.findings.push_back(f);
      out.patch.gyro_bias = j.mount.gyro_bias;
    }
  }
  if (!j.choice.parts.acc_bias || j.mount.acc_bias.norm() <= of_acc) return out;
  Finding f =
      vector_finding(WholeFigure::imu_bias, where, {"acc_x", "acc_y", "acc_z"}, j.mount.acc_bias,
                     j.spread.acc_bias, "m/s^2", j.score, asking.chance());
  f.one_of.push_back(name_of(WholeFigure::imu_turn));
  f.status = status_of(f);
  out.answers.findings.push_back(f);
  out.patch.acc_bias = j.mount.acc_bias;
  return out;
}

std::vector<ImuWindow> all_windows(const Asking& asking) {
  std::vector<ImuWindow> out;
  for (std::size_t r = 0; r < asking.recordings.size(); ++r) add_windows(asking, r, out);
  return out;
}

}  // namespace

std::optional<LeanFit> imu_vertical(const Asking& asking) {
  const std::vector<ImuWindow> windows = all_windows(asking);
  if (windows.empty()) return std::nullopt;
  const ImuMount mount = fit_mount(windows, asking.settings);
  std::vector<ImuWindow> again;
  Leans leans;
  for (std::size_t r = 0; r < asking.recordings.size(); ++r)
    add_windows(asking, r, again, &mount, &leans);
  return LeanFit::of(leans, asking.tolerances.zero, asking.chance());
}

Answered ask_imu(const Asking& asking) {
  Answered out;
  const std::vector<ImuWindow> windows = all_windows(asking);
  std::vector<char> seen;
  for (const ImuWindow& w : windows) {
    seen.resize(std::max(seen.size(), w.group + 1), 0);
    seen[w.group] = 1;
  }
  if (std::count(seen.begin(), seen.end(), 1) < asking.settings.imu_groups) {
    const char* why = "no IMU beside a base attitude (imu_acc:, base_q:) over some seconds";
    out.answers.cannot(WholeFigure::imu_bias, why), out.answers.cannot(WholeFigure::imu_turn, why);
    return out;
  }
  ++out.answers.asked;
  const double z = asking.chance().deviations();
  Judged j{windows, choose_parts(windows, asking.chance()), {}, {}, {}, z};
  // where neither is needed, what may hide is what a fit of both leaves open
  const bool none = !j.choice.parts.turn && !j.choice.parts.acc_bias;
  const ImuParts parts = none ? ImuParts{} : j.choice.parts;
  j.mount = fit_mount(windows, asking.settings, parts);
  j.spread = spread_of(windows, j.mount, parts, asking);
  j.score = held_out(windows, parts, asking);
  out.answers.scores[kImuBalance] = j.score;
  out.take(judge_turn(asking, j));
  out.take(judge_biases(asking, j));
  return out;
}

}  // namespace sanso::diagnose
