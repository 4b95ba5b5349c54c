// Gram-Schmidt against the worlds that differ by a nuisance only; what is left of the effect is
// measured against the noise.
#include "tools/conceal/severity.h"

#include <algorithm>
#include <cmath>

namespace sanso::conceal {

namespace {

using Column = std::vector<double>;

double inner(const Column& a, const Column& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

void subtract(Column& a, double factor, const Column& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] -= factor * b[i];
}

Column difference(const Column& a, const Column& b) {
  Column d = a;
  subtract(d, 1.0, b);
  return d;
}

/// Adds `column` to an orthonormal basis unless it lies in its span.
void extend(std::vector<Column>& basis, Column column) {
  const double before = std::sqrt(inner(column, column));
  for (int pass = 0; pass < 2; ++pass) {
    for (const Column& b : basis) subtract(column, inner(column, b), b);
  }
  const double after = std::sqrt(inner(column, column));
  if (before == 0 || after < 1e-6 * before) return;
  for (double& x : column) x /= after;
  basis.push_back(std::move(column));
}

/// The same world with one nuisance a little off.
std::vector<WorldTruth> nuisance_worlds(const WorldTruth& world) {
  std::vector<WorldTruth> worlds(5, world);
  for (LinkSpec& link : worlds[0].robot.links) {
    link.mass *= 1.02;
    for (double& i : link.inertia) i *= 1.02;
  }
  for (LinkSpec& link : worlds[1].robot.links) {
    for (double& x : link.com) x *= 1.02;
  }
  for (JointTruth& joint : worlds[2].joints) joint.viscous *= 1.1;
  for (JointTruth& joint : worlds[3].joints) joint.coulomb *= 1.1;
  for (JointTruth& joint : worlds[4].joints) joint.command_delay_s += 0.001;
  return worlds;
}

}  // namespace

std::vector<Column> SeverityMeter::channels_of(const WorldTruth& world) const {
  const auto n = static_cast<std::size_t>(world.robot.size());
  std::vector<Column> channels(2 * n);
  for (const Experiment& experiment : experiments_) {
    const Signals s = run_experiment(world, experiment, seed_);
    for (std::size_t j = 0; j < n; ++j) {
      channels[j].insert(channels[j].end(), s.q[j].begin(), s.q[j].end());
      channels[n + j].insert(channels[n + j].end(), s.dq[j].begin(), s.dq[j].end());
    }
  }
  return channels;
}

SeverityMeter::SeverityMeter(const WorldTruth& without, std::vector<Experiment> experiments,
                             std::uint64_t seed)
    : experiments_(std::move(experiments)), seed_(seed) {
  const auto baseline = channels_of(without);
  const std::size_t n = baseline.size() / 2;
  for (std::size_t c = 0; c < baseline.size(); ++c) {
    const double quantum = c < n ? without.joints[c].quantum : kRateQuantum;
    const double offset = c < n ? without.joints[c].record_offset : 0.0;
    Channel channel{quantum / std::sqrt(12.0), offset, baseline[c], {}};
    extend(channel.nuisances, Column(baseline[c].size(), 1.0));
    channels_.push_back(std::move(channel));
  }
  for (const WorldTruth& world : nuisance_worlds(without)) {
    const auto changed = channels_of(world);
    for (std::size_t c = 0; c < changed.size(); ++c) {
      extend(channels_[c].nuisances, difference(changed[c], channels_[c].baseline));
    }
  }
}

double SeverityMeter::ratio(const WorldTruth& with) const {
  const auto changed = channels_of(with);
  double loudest = 0;
  for (std::size_t c = 0; c < changed.size(); ++c) {
    const Channel& channel = channels_[c];
    Column d = difference(changed[c], channel.baseline);
    for (const Column& nuisance : channel.nuisances) subtract(d, inner(d, nuisance), nuisance);
    const double rms = std::sqrt(inner(d, d) / static_cast<double>(d.size()));
    if (std::isfinite(rms)) loudest = std::max(loudest, rms / channel.noise);
    if (c >= with.joints.size()) continue;
    const double of_record = std::abs(with.joints[c].record_offset - channel.record_offset);
    loudest = std::max(loudest, of_record / channel.noise);
  }
  return loudest;
}

double size_for_ratio(const Hideable& effect, int at, const WorldTruth& without,
                      const SeverityMeter& meter, double target, const Random& random,
                      double& reached) {
  const auto ratio_at = [&](double size) {
    WorldTruth world = without;
    Random same = random;  // the effect's other parameters are the same at every size
    effect.apply(world, at, size, same);
    return meter.ratio(world);
  };
  // secant on the logarithm inside a bracket; an effect with a threshold may be silent at first
  double size = effect.typical;
  double low = 1e-5 * effect.typical, high = effect.largest;
  constexpr int kTries = 7;
  for (int i = 0;; ++i) {
    reached = ratio_at(size);
    const bool close = reached > 0 && std::abs(std::log(target / reached)) < 0.1;
    const bool cannot = (reached < target && size >= effect.largest) || low >= high;
    if (close || cannot || i == kTries) break;
    (reached < target ? low : high) = size;
    const double secant = reached > 1e-3 * target ? size * target / reached : high;
    size = secant > low && secant < high ? secant
           : secant >= high              ? std::min(high, 2 * size)
                                         : std::sqrt(low * high);
    if (size == low) size = std::sqrt(low * high);
  }
  return size;
}

}  // namespace sanso::conceal
