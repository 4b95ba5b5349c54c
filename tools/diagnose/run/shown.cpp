// Joints, roll-outs and curves for the report.
#include "tools/diagnose/run/shown.h"

#include <algorithm>
#include <cmath>

namespace sanso::diagnose {
namespace {

constexpr int kShotsShown = 4;

/// One position channel over the first shots of the first recording. Errors are whitened:
/// predicted = measured - sigma r.
RollOut roll_out(const Problem& problem, std::size_t c, const Eigen::VectorXd& before,
                 const Eigen::VectorXd& after) {
  const Observed& channel = problem->channels[c];
  const double sigma = problem.scales.sigma[c];
  RollOut r;
  r.joint = problem->joints[channel.joint];
  r.recording = problem->sources[problem->shots.front().source].file;
  r.noise = channel.noise;
  int shown = 0;
  for (const Shot& shot : problem->shots) {
    if (shot.source != problem->shots.front().source || ++shown > kShotsShown) break;
    const Source& source = problem->sources[shot.source];
    const auto error_before = rows_of(before, shot, c), error_after = rows_of(after, shot, c);
    for (std::size_t k = 0; k < shot.rows; ++k) {
      const std::size_t row = recorded_row(shot, k);
      const double y = measured(source, channel, row);
      r.t.push_back(source.drive.t[row]);
      r.measured.push_back(y);
      r.nominal.push_back(y - sigma * error_before[k]);
      r.patched.push_back(y - sigma * error_after[k]);
    }
    r.t.push_back(r.t.back()), r.measured.push_back(NAN), r.nominal.push_back(NAN),
        r.patched.push_back(NAN);  // pen up
  }
  return r;
}

}  // namespace

std::vector<std::size_t> joints_to_show(const Verdict& verdict, const RobotTree& tree) {
  std::vector<std::size_t> out;
  const auto add = [&](const std::string& name) {
    for (std::size_t j = 0; j < tree.joints.size(); ++j) {
      const bool is = tree.joints[j].name == name || tree.joints[j].link == name;
      if (is && out.size() < 3 && std::find(out.begin(), out.end(), j) == out.end())
        out.push_back(j);
    }
  };
  for (const Finding& f : verdict.findings) {
    for (const std::string& w : f.where) add(w);
  }
  if (verdict.unexplained) add(verdict.unexplained->where);
  for (const LocationCell& c : verdict.locations) {
    if (out.empty()) add(c.where);
  }
  if (out.empty()) out.push_back(0);
  return out;
}

std::vector<RollOut> roll_outs(const Simulated& simulated, const std::vector<std::size_t>& joints) {
  const Problem& problem = simulated.problem;
  std::vector<RollOut> out;
  if (problem->shots.empty()) return out;
  for (const std::size_t joint : joints) {
    for (std::size_t c = 0; c < problem->channels.size(); ++c) {
      if (problem->channels[c].joint == joint && problem->channels[c].signal == Signal::q)
        out.push_back(roll_out(problem, c, simulated.nominal, simulated.patched));
    }
  }
  return out;
}

std::vector<std::vector<ShapeCurve>> curves_of(const std::vector<TorqueSample>& missing,
                                               const std::vector<std::size_t>& joints) {
  std::vector<std::vector<ShapeCurve>> out;
  out.reserve(joints.size());
  for (const std::size_t j : joints) out.push_back(shape_curves(missing, j));
  return out;
}

}  // namespace sanso::diagnose
