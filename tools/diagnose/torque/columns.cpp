// The nominal model read backwards, once for every reading of the columns.
#include "tools/diagnose/torque/columns.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include "tools/diagnose/gate/checks.h"
#include "tools/diagnose/torque/bounded_least_squares.h"
#include "tools/diagnose/torque/inverse_effort.h"

namespace sanso::diagnose {
namespace {

/// What the position columns may be in truth.
struct Reading {
  std::vector<std::size_t> from;  // by joint: the joint whose column it is
  std::vector<double> sign;
  double late = 0.0;           // s by which positions come after the torques of their row
  std::size_t joint = 0;       // the column to name
  const char* kind = nullptr;  // of defect::; null: as promised
  std::string words;
};

Reading as_promised(std::size_t joints) {
  Reading out{
      std::vector<std::size_t>(joints), std::vector<double>(joints, 1.0), 0.0, 0, nullptr, {}};
  std::iota(out.from.begin(), out.from.end(), std::size_t{0});
  return out;
}

/// The other readings that a mistake makes.
std::vector<Reading> other_readings(const Source& source, const GateSettings& settings) {
  const std::vector<TreeJoint>& tree = source.nominal.tree.joints;
  const std::size_t n = tree.size();
  std::vector<Reading> out;
  for (std::size_t j = 0; j < n; ++j) {
    Reading flipped = as_promised(n);
    flipped.sign[j] = -1.0;
    flipped.joint = j;
    flipped.kind = defect::kWrongSign;
    flipped.words = "of the other sign";
    out.push_back(flipped);
    for (std::size_t i = 0; i < j; ++i) {
      if (tree[i].prismatic != tree[j].prismatic) continue;
      Reading swapped = as_promised(n);
      std::swap(swapped.from[i], swapped.from[j]);
      swapped.joint = i;
      swapped.kind = defect::kSwapped;
      swapped.words = "exchanged with q:" + tree[j].name;
      out.push_back(swapped);
    }
  }
  for (double late = 1.5 * settings.clock_skew; late <= settings.clock_reach;
       late += 0.5 * settings.clock_skew) {
    for (const double s : {late, -late}) {
      Reading shifted = as_promised(n);
      shifted.late = s;
      shifted.kind = defect::kShiftedClock;
      shifted.words =
          fmt::format("and all other positions {:.2g} s {}", late, s > 0 ? "earlier" : "later");
      out.push_back(shifted);
    }
  }
  return out;
}

/// Rows of one recording as instants that lie some `half` rows inside it on both sides.
struct Grid {
  long rows = 0, half = 1, skip = 1, reach = 0;
  double interval = 0.0;
};

Grid grid_of(const Source& source, const Settings& settings) {
  Grid g;
  g.rows = static_cast<long>(source.drive.rows());
  g.interval = std::max(gate::sampling_interval(source.drive.t), 1e-6);
  g.half = std::max<long>(1, std::lround(0.5 * settings.effort.window / g.interval));
  g.reach = std::lround(settings.gate.clock_reach / g.interval) + g.half;
  g.skip = std::max<long>(1, (g.rows - 2 * g.reach) / settings.gate.clock_pairs);
  return g;
}

double mean_command(const std::vector<double>& command, long row, long half) {
  double sum = 0.0;
  for (long k = row - half; k <= row + half; ++k) {
    const double x = command[static_cast<std::size_t>(k)];
    sum += std::isfinite(x) ? x : 0.0;  // switched off
  }
  return sum / static_cast<double>(2 * half + 1);
}

MotionSample motion_at(const Source& source, const Reading& reading, const Grid& g, long row) {
  MotionSample out;
  const long at = row + std::lround(reading.late / g.interval);
  const auto before = static_cast<std::size_t>(at - g.half),
             after = static_cast<std::size_t>(at + g.half), here = static_cast<std::size_t>(at);
  const double span = source.drive.t[after] - source.drive.t[before];
  for (std::size_t j = 0; j < reading.from.size(); ++j) {
    const std::size_t from = reading.from[j];
    const std::vector<double>& dq = source.motion.dq[from];
    out.q[j] = reading.sign[j] * source.motion.q[from][here];
    out.dq[j] = reading.sign[j] * dq[here];
    out.ddq[j] = reading.sign[j] * (dq[after] - dq[before]) / span;
  }
  return out;
}

/// Share of a joint's torques that links and rotor of any strength, friction of any size and a
/// constant leave. Rows: torque, needed, velocity.
double unexplained(const Eigen::MatrixX3d& rows) {
  const double rest = 0.1 * std::sqrt(rows.col(2).squaredNorm() / static_cast<double>(rows.rows()));
  Eigen::MatrixX4d A(rows.rows(), 4);
  A.col(0) = rows.col(1);
  A.col(1) = rows.col(2);
  A.col(2) = rows.col(2).array() / (rows.col(2).array().square() + rest * rest + 1e-12).sqrt();
  A.col(3).setOnes();
  const Eigen::Vector4d scale = A.colwise().norm().transpose().cwiseMax(1e-12);
  A *= scale.cwiseInverse().asDiagonal();
  const double infinite = std::numeric_limits<double>::infinity();
  const Eigen::VectorXd x = bounded_least_squares(A.transpose() * A, A.transpose() * rows.col(0),
                                                  Eigen::Vector4d(0, 0, 0, -infinite),
                                                  Eigen::Vector4d::Constant(infinite));
  const double all = (rows.col(0).array() - rows.col(0).mean()).square().sum();
  return all > 0.0 ? std::min(1.0, (rows.col(0) - A * x).squaredNorm() / all) : 1.0;
}

/// Mean over the joints of what a reading leaves of their torques.
double left_by(const Source& source, const Reading& reading, const Grid& g) {
  const std::size_t n = reading.from.size();
  InverseEffort inverse(source.nominal);
  std::vector<Eigen::MatrixX3d> rows(
      n, Eigen::MatrixX3d((g.rows - 2 * g.reach + g.skip - 1) / g.skip, 3));
  Eigen::Index at = 0;
  JointVector load{};
  for (long k = g.reach; k < g.rows - g.reach; k += g.skip, ++at) {
    const MotionSample motion = motion_at(source, reading, g, k);
    inverse.loads(motion, load);
    for (std::size_t j = 0; j < n; ++j) {
      const double rotor = source.nominal.joints[j].nominal.armature * motion.ddq[j];
      rows[j].row(at) << mean_command(source.drive.joints[j].command, k, g.half), load[j] + rotor,
          motion.dq[j];
    }
  }
  double sum = 0.0;
  for (const Eigen::MatrixX3d& of_joint : rows) sum += unexplained(of_joint);
  return sum / static_cast<double>(n);
}

bool driven_by_torques(const Source& source) {
  const std::vector<JointParams>& joints = source.nominal.joints;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    if (joints[j].nominal.actuator != Actuator::torque || source.drive.joints[j].q.empty() ||
        source.drive.joints[j].command.empty())
      return false;
  }
  return !joints.empty();
}

std::string column_of(const Source& source, const Reading& reading) {
  return "q:" + source.nominal.tree.joints[reading.joint].name;
}

/// Best first; half a period of a regular motion later looks like the other sign, so one reading
/// alone would be no advice.
std::string in_words(const Source& source, const std::vector<std::pair<double, Reading>>& better) {
  constexpr std::size_t kTold = 4;
  std::string out;
  for (std::size_t k = 0; k < std::min(kTold, better.size()); ++k) {
    const auto& [left, reading] = better[k];
    out += fmt::format("{}{:.2g} % with {} {}", k == 0 ? "" : ", or ", 100 * left,
                       column_of(source, reading), reading.words);
  }
  return out;
}

std::optional<Defect> check(const Source& source, const Settings& settings) {
  const Grid g = grid_of(source, settings);
  if (!driven_by_torques(source) || g.rows - 2 * g.reach < settings.gate.least_rows) return {};
  const std::size_t n = source.nominal.joints.size();
  double promised = INFINITY;  // whatever delay a robot may have
  for (const double late : {0.0, 0.5 * settings.gate.clock_skew, settings.gate.clock_skew}) {
    Reading reading = as_promised(n);
    reading.late = late;
    promised = std::min(promised, left_by(source, reading, g));
    if (promised <= settings.gate.columns_fit) return {};
  }
  std::vector<std::pair<double, Reading>> better;
  for (Reading& reading : other_readings(source, settings.gate)) {
    const double left = left_by(source, reading, g);
    if (settings.gate.columns_better * left <= promised)
      better.emplace_back(left, std::move(reading));
  }
  if (better.empty()) return {};
  std::stable_sort(better.begin(), better.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  const Reading& best = better.front().second;
  return Defect{source.file, column_of(source, best), -1, best.kind,
                fmt::format("{:.2g} % of the torques stay unexplained by the motion as it is "
                            "recorded, {}; mend the columns",
                            100 * promised, in_words(source, better))};
}

}  // namespace

std::vector<Defect> check_columns(const std::vector<Source>& sources, const Settings& settings) {
  std::vector<Defect> out;
  for (const Source& source : sources)
    if (std::optional<Defect> found = check(source, settings)) out.push_back(std::move(*found));
  return out;
}

}  // namespace sanso::diagnose
