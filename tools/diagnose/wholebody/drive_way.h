// Rows that are left out a third at a time: what a choice of terms gains on rows that it has not
// seen.
#pragma once

#include <algorithm>
#include <memory>
#include <numeric>
#include <vector>

#include "tools/diagnose/stats/random.h"
#include "tools/diagnose/stats/significance.h"
#include "tools/diagnose/wholebody/drive_fit.h"

namespace sanso::diagnose {

using Terms = std::vector<const DriveTerm*>;

inline Terms plus(Terms terms, const DriveTerm* more) {
  terms.push_back(more);
  return terms;
}
inline Terms without(Terms terms, const DriveTerm* less) {
  std::erase(terms, less);
  return terms;
}

/// One way of cutting the rows, with what is fitted when a third is left out.
class Way {
 public:
  const std::vector<Normal>* groups = nullptr;
  std::vector<std::unique_ptr<Eliminated>> fitted;
  /// Squared deviations of every group, predicted by the other thirds. `strain`: and how far the
  /// nuisances are from what a nominal model says, shared by the groups: a robot that is far off in
  /// a dozen figures is no better a prediction than one cause.
  std::vector<double> left_out(const Terms& terms, bool strain) const {
    return predicted(terms, [&](const Normal& group, const Eliminated::Fit& fit) {
      return group.loss(fit.figures) +
             (strain ? fit.strained / static_cast<double>(groups->size()) : 0.0);
    });
  }
  /// The same with the terms alone, as a model that is patched with them has it.
  std::vector<double> left_by_named(const Terms& terms) const {
    return predicted(terms, [](const Normal& group, const Eliminated::Fit& fit) {
      return group.loss(fit.named);
    });
  }

 private:
  std::vector<double> predicted(const Terms& terms, const auto& loss) const {
    std::vector<double> out(groups->size());
    for (std::size_t part = 0; part < fitted.size(); ++part) {
      const Eliminated::Fit fit = fitted[part]->fit(terms);
      for (std::size_t g = part; g < groups->size(); g += fitted.size())
        out[g] = loss((*groups)[g], fit);
    }
    return out;
  }
};

/// What terms gain on rows left out: the least of all ways, as shares of what is left without.
struct Gain {
  double share = 0.0, low = 0.0;  // and the bound that chance leaves (moving blocks of groups)
};

/// `left(way, terms)`: what is left of every group of a way.
Gain gain_in(const std::vector<Way>& ways, const Terms& less, const Terms& more,
             const Asking& asking, const auto& left) {
  Gain out{1e300, 1e300};
  for (const Way& way : ways) {
    const std::vector<double> a = left(way, less), b = left(way, more);
    std::vector<double> gained;
    for (std::size_t g = 0; g < a.size(); ++g) gained.push_back(a[g] - b[g]);
    const double all = std::max(std::accumulate(a.begin(), a.end(), 0.0), 1e-300);
    const DecisionSettings& d = asking.decisions;
    const double low =
        moving_block_lower_bound(gained, d.gain_level, d.gain_draws, Random(asking.seed, 41));
    out.share = std::min(out.share, std::accumulate(gained.begin(), gained.end(), 0.0) / all);
    out.low = std::min(out.low, low / all);
  }
  return out;
}

}  // namespace sanso::diagnose
