// Columns to rows of poses. Gaps split a recording into pieces; nothing is smoothed over them.
#include "tools/diagnose/wholebody/whole_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "shared/files/input_error.h"
#include "shared/math/so3.h"
#include "tools/diagnose/gate/checks.h"
#include "tools/diagnose/gate/load.h"
#include "tools/diagnose/wholebody/base_checks.h"
#include "tools/recording/mcap_recording.h"

namespace sanso::diagnose {
namespace {

std::vector<V3> three(const recording::Recording& r, const std::string& kind) {
  const auto x = r.find(kind + ":x"), y = r.find(kind + ":y"), z = r.find(kind + ":z");
  if (x.empty() || y.empty() || z.empty()) return {};
  std::vector<V3> out;
  for (std::size_t k = 0; k < r.rows(); ++k) out.emplace_back(x[k], y[k], z[k]);
  return out;
}

/// Empty cells take the value that was read before them, the first ones the first.
void hold(std::vector<double>& x) {
  const auto first = std::find_if(x.begin(), x.end(), [](double v) { return std::isfinite(v); });
  double last = first == x.end() ? 0.0 : *first;
  for (double& v : x) v = std::isfinite(v) ? v : last, last = v;
}

std::vector<V3> held(std::vector<V3> x) {
  V3 last = V3::Zero();
  for (const V3& v : x) {
    if (v.allFinite()) {
      last = v;
      break;
    }
  }
  for (V3& v : x) v = v.allFinite() ? v : last, last = v;
  return x;
}

std::vector<M3> rotations(const recording::Recording& r) {
  const auto w = r.find("base_q:w"), x = r.find("base_q:x"), y = r.find("base_q:y"),
             z = r.find("base_q:z");
  std::vector<M3> out;
  M3 last = M3::Identity();
  for (std::size_t k = 0; k < r.rows(); ++k) {
    const math::Quat q(w[k], x[k], y[k], z[k]);
    if (q.allFinite()) last = math::rotation_matrix(math::quat_normalized(q));
    out.push_back(last);
  }
  return out;
}

/// Central differences inside a piece; at its ends one-sided.
template <class Difference>
std::vector<V3> slopes(const WholeRecording& r, Difference difference) {
  std::vector<V3> out(r.rows(), V3::Zero());
  for (std::size_t k = 0; k < r.rows(); ++k) {
    const std::size_t a = k > 0 && r.piece[k - 1] == r.piece[k] ? k - 1 : k;
    const std::size_t b = k + 1 < r.rows() && r.piece[k + 1] == r.piece[k] ? k + 1 : k;
    if (b > a) out[k] = difference(a, b) / (r.t[b] - r.t[a]);
  }
  return out;
}

/// One row a joint; 0 where it is not recorded.
Eigen::MatrixXd positions(const recording::Recording& r, const WholeBody& body) {
  const RobotTree& tree = body.model.tree;
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(tree.size()),
                                              static_cast<Eigen::Index>(r.rows()));
  for (std::size_t j = 0; j < tree.size(); ++j) {
    const auto column = r.find("q:" + tree.joints[j].name);
    if (column.empty()) continue;
    std::vector<double> q = gate::without_glitches(column);
    hold(q);
    for (std::size_t k = 0; k < q.size(); ++k)
      out(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(k)) = q[k];
  }
  return out;
}

/// One row a joint; nothing unless every joint has that column.
Eigen::MatrixXd of_all_joints(const recording::Recording& r, const WholeBody& body,
                              const std::string& kind) {
  const RobotTree& tree = body.model.tree;
  Eigen::MatrixXd out(static_cast<Eigen::Index>(tree.size()), static_cast<Eigen::Index>(r.rows()));
  for (std::size_t j = 0; j < tree.size(); ++j) {
    const auto column = r.find(kind + tree.joints[j].name);
    if (column.empty()) return {};
    std::vector<double> x(column.begin(), column.end());
    hold(x);
    for (std::size_t k = 0; k < x.size(); ++k)
      out(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(k)) = x[k];
  }
  return out;
}

std::vector<FootForce> feet_of(const recording::Recording& r, const WholeBody& body) {
  std::vector<FootForce> out;
  for (const recording::Channel& c : r.channels) {
    if (!c.name.starts_with("fz:")) continue;
    const std::string link = c.name.substr(3);
    out.push_back({link, body.model.tree.links.at(link).joint, c.values});
  }
  return out;
}

WholeRecording converted(const recording::Recording& r, const WholeBody& body,
                         const GateSettings& gate) {
  WholeRecording out;
  out.file = r.file, out.name = r.stem(), out.condition = r.condition, out.t = r.t;
  out.interval = gate::sampling_interval(r.t);
  const double gap = std::max(gate.gap_periods * out.interval, gate.gap_seconds);
  out.piece.assign(r.rows(), 0);
  for (std::size_t k = 1; k < r.rows(); ++k)
    out.piece[k] = out.piece[k - 1] + (r.t[k] - r.t[k - 1] > gap ? 1 : 0);
  out.attitude = r.has("base_q:w"), out.position = r.has("base_p:x");
  out.R = out.attitude ? rotations(r) : std::vector<M3>(r.rows(), M3::Identity());
  out.p = out.position ? held(three(r, "base_p")) : std::vector<V3>(r.rows(), V3::Zero());
  out.v = held(three(r, "base_v"));
  if (out.v.empty())
    out.v = slopes(out, [&](std::size_t a, std::size_t b) { return V3(out.p[b] - out.p[a]); });
  out.w = held(three(r, "base_w"));
  if (out.w.empty())
    out.w = slopes(out, [&](std::size_t a, std::size_t b) { return turned(out.R[a], out.R[b]); });
  out.imu_acc = three(r, "imu_acc"), out.imu_gyro = three(r, "imu_gyro");
  out.acc = !out.imu_acc.empty();
  // of an IMU in base axes base_w is the gyroscope, where the attitude gives the turning beside it
  if (out.imu_gyro.empty() && out.acc && r.has("base_w:x") && out.attitude) {
    out.imu_gyro = three(r, "base_w");
    out.w = slopes(out, [&](std::size_t a, std::size_t b) { return turned(out.R[a], out.R[b]); });
    const M3 R = eigen(body.imu.R_joint_imu).transpose();
    for (V3& gyro : out.imu_gyro) gyro = R * gyro;
  }
  out.gyro = !out.imu_gyro.empty();
  out.q = positions(r, body);
  out.u = of_all_joints(r, body, "u:"), out.i = of_all_joints(r, body, "i:");
  out.commands = out.u.size() > 0 && of_all_joints(r, body, "q:").size() > 0;
  out.current = out.i.size() > 0;
  out.feet = feet_of(r, body);
  return out;
}

std::vector<std::string> legal_oddities(const recording::Recording& r, const WholeRecording& made,
                                        const WholeBody& body) {
  std::vector<std::string> notes;
  if (made.piece.back() > 0)
    notes.push_back(fmt::format("{}: {} gaps; the pieces between them are taken one by one", r.file,
                                made.piece.back()));
  const std::string uneven = gate::uneven_sampling(r.file, r.t);
  if (!uneven.empty()) notes.push_back(uneven);
  const Unrecorded none = unrecorded_joints(r, body);
  if (none.joints.empty()) return notes;
  notes.push_back(fmt::format(
      "{}: {} are not recorded and taken at rest at 0 ({:.1f} % of the mass is behind them)",
      r.file, fmt::join(none.joints.begin(), none.joints.end(), ", "), 100 * none.mass_share));
  return notes;
}

/// Size, clock but for its gaps, columns.
std::vector<Defect> first_defects(const recording::Recording& r, const WholeBody& body,
                                  const Settings& settings) {
  const GateRecording view = gate_view(r);
  std::vector<Defect> out = gate::check_size(view, settings.gate);
  if (!out.empty()) return out;
  out = gate::check_time(view, settings.gate);
  std::erase_if(out, [](const Defect& d) { return d.defect == defect::kGap; });
  return out.empty() ? check_base_columns(r, body, settings) : out;
}

}  // namespace

WholeData judge_whole(const std::vector<recording::Recording>& recordings, const WholeBody& body,
                      const Settings& settings) {
  WholeData data;
  data.notes = body.notes;
  data.hashes = data_hash(recordings);
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    const recording::Recording& r = recordings[i];
    std::vector<Defect> defects = first_defects(r, body, settings);
    for (std::size_t k = 0; k < i && defects.empty(); ++k) {
      if (data.hashes[r.file] == data.hashes[recordings[k].file] && r.file != recordings[k].file)
        defects.push_back(
            {r.file, "", -1, defect::kCopyOfFile,
             "every value equals " + recordings[k].file + "; a copy proves nothing, leave it out"});
    }
    if (defects.empty()) {
      WholeRecording made = converted(r, body, settings.gate);
      defects = check_base_agreement(r, made, body, settings);
      for (std::string& note : legal_oddities(r, made, body)) data.notes.push_back(std::move(note));
      data.recordings.push_back(std::move(made));
    }
    data.defects.insert(data.defects.end(), defects.begin(), defects.end());
  }
  if (recordings.empty())
    data.defects.push_back({"", "", -1, defect::kEmpty, "no recording was given"});
  return data;
}

WholeData load_whole(const std::vector<std::string>& files, const WholeBody& body,
                     const Settings& settings) {
  std::vector<recording::Recording> read;
  std::vector<Defect> defects;
  for (const std::string& file : files) {
    std::vector<Defect> here = inspect_file(file, settings.gate);
    if (here.empty()) {
      try {
        read.push_back(recording::read_recording(file));
      } catch (const files::InputError& error) {
        here.push_back(defect_of(error));
      }
    }
    defects.insert(defects.end(), here.begin(), here.end());
  }
  if (read.empty() && !defects.empty()) return {{}, defects, {}, {}};
  WholeData data = judge_whole(read, body, settings);
  data.defects.insert(data.defects.begin(), defects.begin(), defects.end());
  return data;
}

}  // namespace sanso::diagnose
