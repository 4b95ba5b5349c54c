// Two measures of a gain, the surer of them taken; folds are blocks in turn.
#include "tools/diagnose/torque/effort_gain.h"

#include <algorithm>
#include <cmath>

#include "tools/diagnose/stats/robust.h"
#include "tools/diagnose/stats/significance.h"

namespace sanso::diagnose {

EffortGain gain_of(const std::vector<double>& a, const std::vector<double>& b,
                   const BlockCounts& counts, const Settings& settings, unsigned long seed) {
  std::vector<double> squares, middle, whole;
  for (std::size_t k = 0; k < counts.size(); ++k) {
    if (counts[k] == 0.0) continue;
    squares.push_back(a[k] - b[k]), whole.push_back(a[k]);
    middle.push_back(0.5 * (a[k] + b[k]));
  }
  const double unit = std::max(median(middle), 1e-300);
  std::vector<double> logarithms, whole_log;
  for (std::size_t k = 0; k < counts.size(); ++k) {
    if (counts[k] == 0.0) continue;
    logarithms.push_back(unit * std::log((unit + a[k]) / (unit + b[k])));
    whole_log.push_back(unit * std::log((unit + a[k]) / unit));
  }
  const auto measured = [&](const std::vector<double>& gains, const std::vector<double>& left) {
    EffortGain out;
    double all = 0.0;
    for (std::size_t k = 0; k < gains.size(); ++k) out.gain += gains[k], all += left[k];
    out.low = moving_block_lower_bound(gains, 0.5 * settings.decisions.gain_level,
                                       settings.decisions.gain_draws, Random(seed));
    out.share = all > 0.0 ? out.gain / all : 0.0;
    return out;
  };
  const EffortGain energy = measured(squares, whole), bounded = measured(logarithms, whole_log);
  const auto sure = [](const EffortGain& g) { return g.gain > 0.0 ? g.low / g.gain : -1e300; };
  return sure(energy) >= sure(bounded) ? energy : bounded;
}

bool friction_is_positive(const EffortDesign& design, const std::vector<std::size_t>& active,
                          const EffortValues& x) {
  const EffortRecording& first = design.rows().recordings.front();
  for (std::size_t j = 0; j < first.channels.size(); ++j) {
    double dry = first.nominal.joints[j].nominal.coulomb + first.nominal.joints[j].coulomb,
           ripple = 0.0;
    for (const std::size_t t : active) {
      const EffortTerm& term = design.terms()[t];
      const bool here = std::find(term.joints.begin(), term.joints.end(), j) != term.joints.end();
      if (!here || term.nuisance) continue;
      const Eigen::Index column = design.first_column(t);
      if (term.law.dry == DryFriction::ripples) ripple += std::hypot(x[column], x[column + 1]);
      if (term.law.dry == DryFriction::adds) dry += x[column];
    }
    if (ripple > dry) return false;
  }
  return true;
}

EffortGain crossed_gain(const EffortDesign& design, const std::vector<std::size_t>& without,
                        const std::vector<std::size_t>& with, const BlockCounts& fitted,
                        const std::vector<std::size_t>& joints, const Settings& settings,
                        unsigned long seed) {
  const auto folds = static_cast<std::size_t>(settings.decisions.folds);
  std::vector<double> a(fitted.size()), b(fitted.size());
  for (std::size_t fold = 0; fold < folds; ++fold) {
    BlockCounts counts = fitted;
    for (std::size_t k = 0; k < counts.size(); ++k) {
      if (k % folds == fold) counts[k] = 0.0;
    }
    const std::vector<double> la = design.losses(design.fit(without, counts), joints),
                              lb = design.losses(design.fit(with, counts), joints);
    for (std::size_t k = 0; k < counts.size(); ++k) {
      if (k % folds == fold) a[k] = la[k], b[k] = lb[k];
    }
  }
  return gain_of(a, b, fitted, settings, seed);
}

}  // namespace sanso::diagnose
