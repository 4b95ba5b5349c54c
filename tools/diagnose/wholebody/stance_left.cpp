// A window's rows are what a force on the base, or a torque at a joint, would leave in them, as far
// as the ground's forces do not hide it. Scales are robust: a push is rare.
#include "tools/diagnose/wholebody/stance_left.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace sanso::diagnose {
namespace {

/// What a window leaves, read as a force on the base and as a torque at every joint.
struct Reading {
  V3 force = V3::Zero();
  double explained = 0.0;        // squares that go with the force
  double vertical = 0.0;         // squares that would go with a vertical force alone
  std::vector<double> by_joint;  // squares that go with the torque
};

Reading reading_of(const Eigen::MatrixXd& U, const Eigen::VectorXd& left) {
  Reading out;
  const Eigen::MatrixXd F = U.leftCols(3);
  const Eigen::Vector3d c = F.transpose() * left;
  Eigen::Matrix3d A = F.transpose() * F;
  A.diagonal().array() += 1e-9 * (A.trace() + 1e-300);
  out.force = A.ldlt().solve(c), out.explained = c.dot(out.force);
  out.vertical = c[2] * c[2] / A(2, 2);
  for (Eigen::Index j = 3; j < U.cols(); ++j) {
    const double squares = U.col(j).squaredNorm(), with = U.col(j).dot(left);
    out.by_joint.push_back(squares > 1e-300 ? with * with / squares : 0.0);
  }
  return out;
}

std::vector<Reading> readings_of(const DriveRows& rows, const Eigen::VectorXd& left) {
  std::vector<Reading> out(rows.windows.size());
  for (std::size_t first = 0; first < rows.window.size();) {
    std::size_t last = first;
    while (last < rows.window.size() && rows.window[last] == rows.window[first]) ++last;
    const auto a = static_cast<Eigen::Index>(first), n = static_cast<Eigen::Index>(last - first);
    out[rows.window[first]] = reading_of(rows.unknown.middleRows(a, n), left.segment(a, n));
    first = last;
  }
  return out;
}

/// By recording: what a force on the base is in nine of ten windows, at most.
std::vector<double> usual_sizes(const DriveRows& rows, const std::vector<Reading>& readings) {
  std::vector<std::vector<double>> sizes;
  for (std::size_t w = 0; w < readings.size(); ++w) {
    const auto r = rows.windows[w].recording;
    sizes.resize(std::max(sizes.size(), r + 1));
    sizes[r].push_back(readings[w].explained);
  }
  std::vector<double> out;
  for (std::vector<double>& x : sizes) {
    std::sort(x.begin(), x.end());
    out.push_back(x.empty() ? 0.0 : std::sqrt(x[x.size() * 9 / 10]));
  }
  return out;
}

/// Neighbouring windows are one push.
void add_push(const StanceWindow& here, const Reading& r, double size, StanceLeft& out) {
  const bool goes_on = !out.pushes.empty() && out.pushes.back().recording == here.recording &&
                       here.from - out.pushes.back().to < 0.5 * (here.to - here.from);
  if (!goes_on) {
    out.pushes.push_back({here.recording, here.from, here.to, r.force, size});
    return;
  }
  Push& p = out.pushes.back();
  p.to = here.to;
  if (size > p.beyond) p.beyond = size, p.force = r.force;
}

/// A foot that comes down hits from below.
bool may_be_a_foot(const Reading& r) { return r.vertical > 0.95 * r.explained; }

}  // namespace

StanceLeft stance_left(const DriveRows& rows, const Eigen::VectorXd& figures, double beyond) {
  const std::vector<Reading> readings = readings_of(rows, rows.y - rows.X * figures);
  const std::vector<double> usual = usual_sizes(rows, readings);
  StanceLeft out;
  out.at.assign(static_cast<std::size_t>(rows.columns.joints) + 1, 0.0);
  for (std::size_t w = 0; w < readings.size(); ++w) {
    const Reading& r = readings[w];
    const StanceWindow& here = rows.windows[w];
    const double size = std::sqrt(r.explained) / std::max(1.0, usual[here.recording]);
    if (size >= beyond && !may_be_a_foot(r)) add_push(here, r, size, out);
    // no window alone says where something is that stays
    const auto counted = [most = beyond * beyond](double squares) {
      return most * std::log1p(squares / most);
    };
    out.at[0] += counted(r.explained / 3.0);
    for (std::size_t j = 0; j < r.by_joint.size(); ++j) out.at[j + 1] += counted(r.by_joint[j]);
  }
  for (double& x : out.at) x /= std::max<double>(1.0, static_cast<double>(readings.size()));
  std::sort(out.pushes.begin(), out.pushes.end(),
            [](const Push& a, const Push& b) { return a.beyond > b.beyond; });
  return out;
}

DriveRows without(const DriveRows& rows, const std::vector<Push>& pushes) {
  const auto pushed = [&](const StanceWindow& w) {
    const double width = w.to - w.from;
    return std::any_of(pushes.begin(), pushes.end(), [&](const Push& p) {
      return p.recording == w.recording && w.to > p.from - width && w.from < p.to + width;
    });
  };
  DriveRows out = rows;
  std::vector<Eigen::Index> kept;
  out.channel.clear(), out.recording.clear(), out.piece.clear(), out.window.clear();
  for (std::size_t i = 0; i < rows.window.size(); ++i) {
    if (pushed(rows.windows[rows.window[i]])) continue;
    kept.push_back(static_cast<Eigen::Index>(i));
    out.channel.push_back(rows.channel[i]), out.recording.push_back(rows.recording[i]);
    out.piece.push_back(rows.piece[i]), out.window.push_back(rows.window[i]);
  }
  out.X = rows.X(kept, Eigen::all), out.y = rows.y(kept);
  out.unknown = rows.unknown(kept, Eigen::all), out.loop = rows.loop(kept);
  return out;
}

}  // namespace sanso::diagnose
