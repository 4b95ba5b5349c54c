// Errors are whitened: predicted = measured - sigma r. Where a reading is missing, the figure stays
// where it was.
#include "tools/diagnose/run/shown_motion.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "tools/diagnose/verdict/heldout.h"
#include "tools/diagnose/wholebody/roll_out.h"

namespace sanso::diagnose {
namespace {

constexpr double kShotSeconds = 2.0;
constexpr double kFloatingShotSeconds = 1.0;   // a throw and its tumbling
constexpr double kRowSeconds = 0.02;           // between two rows: as smooth as a film
constexpr std::size_t kMostNumbers = 500'000;  // of all motions; 1 MB before it is packed

std::size_t every(double interval) {
  return static_cast<std::size_t>(std::max(1.0, std::round(kRowSeconds / interval)));
}

double median_interval(const std::vector<double>& t) {
  std::vector<double> steps;
  for (std::size_t k = 1; k < t.size(); ++k) steps.push_back(t[k] - t[k - 1]);
  if (steps.empty()) return kRowSeconds;
  std::nth_element(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2),
                   steps.end());
  const double middle = steps[steps.size() / 2];
  return middle > 0.0 ? middle : kRowSeconds;
}

/// The position channel of each joint, or -1.
std::vector<int> position_channels(const Problem& problem) {
  std::vector<int> out(problem->joints.size(), -1);
  for (std::size_t c = 0; c < problem->channels.size(); ++c)
    if (problem->channels[c].signal == Signal::q)
      out[problem->channels[c].joint] = static_cast<int>(c);
  return out;
}

void put(double& place, double value) {
  if (std::isfinite(value)) place = value;
}

void add_shot(const Simulated& simulated, const Shot& shot, const std::vector<int>& channels,
              std::size_t stride, std::vector<double>& row, ShownMotion& out) {
  const Problem& problem = simulated.problem;
  const Source& source = problem->sources[shot.source];
  const std::size_t joints = channels.size();
  for (std::size_t k = 0; k < shot.rows; k += stride) {
    const std::size_t recorded = recorded_row(shot, k);
    row[0] = source.drive.t[recorded];
    for (std::size_t j = 0; j < joints; ++j) {
      if (channels[j] < 0) continue;
      const auto c = static_cast<std::size_t>(channels[j]);
      const double y = measured(source, problem->channels[c], recorded);
      const double sigma = problem.scales.sigma[c];
      const auto at = static_cast<Eigen::Index>(k);
      put(row[1 + j], y);
      put(row[1 + joints + j], y - sigma * rows_of(simulated.nominal, shot, c)[at]);
      put(row[1 + 2 * joints + j], y - sigma * rows_of(simulated.patched, shot, c)[at]);
    }
    out.numbers.insert(out.numbers.end(), row.begin(), row.end());
  }
}

/// `at`: where a base begins in the row.
void put_base(const V3& p, const M3& R, std::size_t at, std::vector<double>& row) {
  for (std::size_t i = 0; i < 3; ++i) put(row[at + i], p[static_cast<Eigen::Index>(i)]);
  if (!R.allFinite()) return;
  const Eigen::Quaterniond q(R);
  row[at + 3] = q.w(), row[at + 4] = q.x(), row[at + 5] = q.y(), row[at + 6] = q.z();
}

/// Base motion over a whole recording: shots one after the other.
BaseMotion rolled_out(const WholeRecording& r, const WholeBody& body) {
  const BaseRollOut model(body, r);
  BaseMotion out;
  Span shot;
  for (std::size_t k = 1; k <= r.rows(); ++k) {
    if (k < r.rows() && r.piece[k] == r.piece[shot.first] &&
        r.t[k] - r.t[shot.first] < kFloatingShotSeconds)
      continue;
    shot.last = k;
    const BaseMotion part = model.from(shot);
    out.p.insert(out.p.end(), part.p.begin(), part.p.end());
    out.R.insert(out.R.end(), part.R.begin(), part.R.end());
    shot.first = k;
  }
  return out;
}

ShownMotion floating_motion(const WholeRecording& r, const std::vector<BaseMotion>& simulated) {
  const std::size_t stride = every(r.interval), joints = static_cast<std::size_t>(r.q.rows());
  const std::size_t width = 7 + joints, figures = 1 + simulated.size();
  ShownMotion motion{r.file, r.interval * static_cast<double>(stride), {}};
  std::vector<double> row(1 + figures * width, 0.0);
  for (std::size_t figure = 0; figure < figures; ++figure) row[4 + figure * width] = 1.0;
  for (std::size_t k = 0; k < r.rows(); k += stride) {
    row[0] = r.t[k];
    put_base(r.position ? r.p[k] : V3(V3::Zero()), r.attitude ? r.R[k] : M3(M3::Identity()), 1,
             row);
    for (std::size_t i = 0; i < simulated.size(); ++i)
      put_base(simulated[i].p[k], simulated[i].R[k], 1 + (i + 1) * width, row);
    for (std::size_t figure = 0; figure < figures; ++figure)
      for (std::size_t j = 0; j < joints; ++j)
        put(row[8 + figure * width + j],
            r.q(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(k)));
    motion.numbers.insert(motion.numbers.end(), row.begin(), row.end());
  }
  return motion;
}

}  // namespace

Simulated simulate_heldout(const std::vector<Source>& sources, const std::vector<NoiseLevel>& noise,
                           const Library& library, const HeldoutProof& proof,
                           const Settings& settings) {
  ProblemOptions options;
  options.shot_seconds = kShotSeconds;
  options.maximum_rows = 4 * settings.data.maximum_rows;
  options.secondary = false;
  Simulated out{restricted(make_problem(sources, noise, options, settings), proof.part), {}, {}};
  if (out.problem->shots.empty()) return out;
  out.nominal = prediction_error(out.problem, library, Model{});
  out.patched = prediction_error(out.problem, library, proof.model);
  return out;
}

std::vector<ShownMotion> shown_motions(const Simulated& simulated) {
  const Problem& problem = simulated.problem;
  const std::vector<int> channels = position_channels(problem);
  std::vector<ShownMotion> out;
  std::size_t before = problem->sources.size(), numbers = 0, stride = 1;
  std::vector<double> row(1 + 3 * channels.size(), 0.0);
  for (const Shot& shot : problem->shots) {
    if (numbers > kMostNumbers) break;
    if (shot.source != before) {
      before = shot.source;
      const Source& source = problem->sources[shot.source];
      const double interval = median_interval(source.drive.t) *
                              static_cast<double>(std::max<std::size_t>(1, shot.stride));
      stride = every(interval);
      out.push_back({source.file, interval * static_cast<double>(stride), {}});
    }
    const std::size_t had = out.back().numbers.size();
    add_shot(simulated, shot, channels, stride, row, out.back());
    numbers += out.back().numbers.size() - had;
  }
  return out;
}

ShownMotions shown_motions(const std::vector<WholeRecording>& recordings, const WholeBody& nominal,
                           const WholeBody& patched) {
  ShownMotions out;
  out.simulated = std::all_of(recordings.begin(), recordings.end(), [&](const WholeRecording& r) {
    return BaseRollOut::possible(nominal, r);
  });
  if (out.simulated && !recordings.empty())
    out.ground = BaseRollOut(nominal, recordings.front()).ground();
  std::size_t numbers = 0;
  for (const WholeRecording& r : recordings) {
    if (numbers > kMostNumbers) break;
    std::vector<BaseMotion> simulated;
    if (out.simulated) simulated = {rolled_out(r, nominal), rolled_out(r, patched)};
    out.motions.push_back(floating_motion(r, simulated));
    numbers += out.motions.back().numbers.size();
  }
  return out;
}

}  // namespace sanso::diagnose
