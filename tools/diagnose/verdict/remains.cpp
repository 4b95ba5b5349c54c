// Three questions to what the last model leaves: does the joint's state predict the missing torque,
// does the velocity channel tell the motion of the position channel, do single stretches repeat?
#include "tools/diagnose/verdict/remains.h"

#include <algorithm>

#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/explain/polling.h"
#include "tools/diagnose/verdict/velocity.h"

namespace sanso::diagnose {
namespace {

// streams of random draws, one a joint from here on
constexpr std::uint64_t kTorqueStream = 100, kVelocityStream = 10000;

std::vector<Predictability> predictable(const std::vector<TorqueSample>& samples,
                                        std::size_t joints, unsigned long seed,
                                        std::uint64_t stream, const Settings& settings) {
  std::vector<Predictability> out(joints);
  parallel_for(joints, [&](std::size_t j) {
    out[j] = predictability(samples, j, Random(seed, stream + j), settings);
  });
  return out;
}

/// An accepted effect acts on the joint's velocity channel.
bool velocity_has_a_name(const Library& library, const Selection& selection, std::size_t joint) {
  return std::any_of(selection.accepted.begin(), selection.accepted.end(), [&](const Accepted& a) {
    const Candidate& c = library[a.candidate];
    const bool here = std::find(c.joints.begin(), c.joints.end(), joint) != c.joints.end();
    return here && (find_effect(c.effect)->needs & kVelocity) != 0;
  });
}

/// Energy beyond noise, in units of the measurement noise (or the trust floor) whatever a channel
/// was scaled by, of what projects as r and is expected to scatter by S (squares; empty: 0):
///
///   sum over position entries of  (sigma / floor)^2 (r^2 - S) - 1
double excess(const Problem& problem, const Eigen::VectorXd& r, const Eigen::VectorXd& S) {
  double sum = 0.0;
  for (std::size_t c = 0; c < problem->channels.size(); ++c) {
    const Observed& channel = problem->channels[c];
    if (channel.signal != Signal::q) continue;
    for (const Shot& shot : problem->shots) {
      const double sigma = problem.scales.sigma[c];
      const double unit = sigma * sigma / (channel.floor * channel.floor);
      sum += unit * rows_of(r, shot, c).squaredNorm() - static_cast<double>(shot.rows);
      if (S.size() > 0) sum -= unit * rows_of(S, shot, c).sum();
    }
  }
  return sum;
}

/// What chance explains is not left.
double remaining_share(const Selection& selection) {
  const Problem& problem = selection.around->problem;
  const StartElimination& starts = selection.around->starts;
  const double before = excess(problem, starts.project(selection.nominal.r), {}),
               after =
                   excess(problem, starts.project(selection.final.r), selection.expected_scatter);
  return before > 0.0 ? std::clamp(after / before, 0.0, 1.0) : 0.0;
}

/// Noise levels of the position error; what commands do that wait to be taken is no more left than
/// chance that has a name.
double level_left(const Selection& selection, unsigned long seed) {
  const Surroundings& around = *selection.around;
  const Eigen::VectorXd& named = selection.expected_scatter;
  const double level = position_error_level(around, selection.final.r, named);
  if (level <= around.settings().decisions.adequate) return level;
  const Eigen::VectorXd polled = scatter_of_polling(selection, seed);
  return position_error_level(around, selection.final.r,
                              named.size() > 0 ? Eigen::VectorXd(polled + named) : polled);
}

std::vector<Stretch> stretches_of(const Comparison& comparison, const std::vector<Event>& events) {
  std::vector<Stretch> out;
  for (const Event& e : events) {
    const Shot& shot = comparison.shots[e.shot];
    const Source& source = comparison.sources[shot.source];
    out.push_back({source.file, comparison.joints[e.joint], source.drive.t[shot.window.first],
                   source.drive.t[shot.window.last], e.level});
  }
  return out;
}

}  // namespace

Remains what_is_left(const std::vector<Source>& sources, const std::vector<NoiseLevel>& noise,
                     const Library& library, const Selection& selection, const WholeTime& whole,
                     unsigned long seed) {
  const Settings& settings = whole.comparison().settings;
  const std::size_t joints = whole.comparison().joints.size();
  Remains out;
  out.share = remaining_share(selection);
  out.level = level_left(selection, seed);
  out.missing = missing_torque(sources, noise, library, selection.final.model, settings);
  out.torque = predictable(out.missing, joints, seed, kTorqueStream, settings);
  out.velocity = predictable(velocity_errors(sources, noise, settings), joints, seed,
                             kVelocityStream, settings);
  std::erase_if(out.velocity, [&](const Predictability& p) {
    return velocity_has_a_name(library, selection, p.joint);
  });
  const EventsLeft left = whole.left_by(library, selection.final.model);
  const RepeatedEvents again = repeated(left.events);
  out.stretches = stretches_of(whole.comparison(), left.events);
  out.stretches_joint = again.joint;
  out.stretches_matter =
      selection.expected_scatter.size() == 0 &&  // chance that has a name makes them
      again.energy > std::max(practical_energy(whole.comparison()),
                              settings.decisions.minimum_share * whole.nominal().energy);
  return out;
}

}  // namespace sanso::diagnose
