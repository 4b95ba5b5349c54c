// A joint lacks what its loop gives less than its current shows, and what its current shows less
// than the motion needs: together, what the model's drive lacks.
#include "tools/diagnose/wholebody/stance_shown.h"

#include <cmath>

#include "tools/diagnose/wholebody/drive_rows.h"

namespace sanso::diagnose {
namespace {

/// Rows [first, last) of a window.
struct WindowRows {
  Eigen::Index first = 0, last = 0;
};

void add(double missing, double sigma, TorqueSample& out) {
  out.missing += missing, out.sigma = std::hypot(out.sigma, sigma);
}

void add_samples(const DriveRows& rows, const WindowRows& at, const Eigen::VectorXd& left,
                 std::vector<TorqueSample>& out) {
  const Eigen::Index n = at.last - at.first;
  const StanceWindow& w = rows.windows[rows.window[static_cast<std::size_t>(at.first)]];
  std::vector<TorqueSample> here;
  for (Eigen::Index j = 0; j < rows.columns.joints; ++j) {
    TorqueSample s;
    s.source = w.recording, s.joint = static_cast<std::size_t>(j), s.t = 0.5 * (w.from + w.to);
    s.q = w.q[j], s.dq = w.dq[j], s.error = w.error[j], s.motor = w.given[j];
    // least squares of  left = unknown torque,  a newton metre being usual
    const auto unknown = rows.unknown.col(3 + j).segment(at.first, n);
    const double squares = 1.0 + unknown.squaredNorm();
    add(unknown.dot(left.segment(at.first, n)) / squares, 1.0 / std::sqrt(squares), s);
    here.push_back(s);
  }
  for (Eigen::Index i = at.first; i < at.last; ++i) {
    const double per_torque = rows.loop[i];
    const std::size_t joint = rows.channel[static_cast<std::size_t>(i)];
    if (per_torque > 0.0) add(left[i] / per_torque, 1.0 / per_torque, here[joint]);
  }
  out.insert(out.end(), here.begin(), here.end());
}

}  // namespace

StanceShown stance_shown(const DriveRows& rows, const Eigen::VectorXd& named) {
  const Eigen::VectorXd patched = rows.y - rows.X * named;
  StanceShown out;
  for (std::size_t first = 0; first < rows.window.size();) {
    std::size_t last = first;
    while (last < rows.window.size() && rows.window[last] == rows.window[first]) ++last;
    const WindowRows at{static_cast<Eigen::Index>(first), static_cast<Eigen::Index>(last)};
    const StanceWindow& w = rows.windows[rows.window[first]];
    const auto rms = [&](const Eigen::VectorXd& left) {
      return std::sqrt(left.segment(at.first, at.last - at.first).squaredNorm() /
                       static_cast<double>(last - first));
    };
    out.moments.push_back({w.recording, 0.5 * (w.from + w.to), rms(rows.y), rms(patched)});
    add_samples(rows, at, rows.y, out.nominal);
    add_samples(rows, at, patched, out.patched);
    first = last;
  }
  return out;
}

}  // namespace sanso::diagnose
