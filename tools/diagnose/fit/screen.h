// Screening by matched filter: the signature of every candidate at every probe size, compared with
// what is left of the error.
//   z_h = s' M r / sqrt(s' M s)   after projecting out starts and nuisances, channels scaled by
//   their overdispersed errors
// Family-wise p over all candidates, places and probes: step-down max-T, null law N(0, correlation
// of the signatures).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tools/diagnose/fit/fit.h"
#include "tools/diagnose/stats/random.h"

namespace sanso::diagnose {

/// One probe of one candidate.
struct ProbeScore {
  std::size_t candidate = 0, probe = 0;
  double z = 0.0;  // matched-filter score; sign: + means towards the probe
  // |z|, or max(z, 0) where the parameter can leave its null in one direction only
  double score = 0.0;
  // the same of all probes of the candidate that differ from it in sizes alone, less what that many
  // explain by chance: a force has a direction, and no probe of an axis has it
  double together = 0.0;
  double amount = 0.0;     // best multiple of (probe - null), linear
  double signature = 0.0;  // sqrt(s' M s): size of the full probe in noise levels
  double p_family = 1.0;
};

struct Screening {
  std::vector<ProbeScore> probes;
  Eigen::MatrixXd correlation;  // of the projected signatures, probes x probes
  // |z| that the family's maximum exceeds with probability family_wise under the null
  double critical = 0.0;
  Scales scales;  // error level of a model large enough, by channel; not below the floor

  /// For methods that select on held-out groups: inner products of [known | signatures | error] by
  /// group, channels in these scales; `known` columns (nuisances) come first. Empty unless
  /// asked for.
  std::vector<Eigen::MatrixXd> by_group;
  Eigen::Index known = 0;

  /// Mean square of all scores: 1 under noise alone, more when what is left is no noise.
  double mean_square() const;
  /// Candidates by what their probes explain together, strongest first.
  std::vector<std::size_t> ranking() const;
  /// Best probe of a candidate; nullptr when it was not screened.
  const ProbeScore* best(std::size_t candidate) const;
  /// Indices of a candidate's strongest probe and of the one least like it.
  std::vector<std::size_t> two_probes(std::size_t candidate) const;
  /// |correlation| of two candidates' best probes (0 when either was not screened).
  double similarity(std::size_t a, std::size_t b) const;
};

/// Screens `which` around `model` whose prediction error is `r`. Cost: one pass a probe. With an
/// `earlier` screening only two probes of every candidate are tried again: its strongest one and
/// its most different one.
/// `accepted`: derivatives by the parameters of the model's own effects, projected out like the
/// nuisances; empty: none.
/// `keep_groups`: fills Screening::by_group.
Screening screen(const Surroundings& around, const Model& model, const Eigen::VectorXd& r,
                 const std::vector<std::size_t>& which, Random random,
                 const Screening* earlier = nullptr, const Eigen::MatrixXd& accepted = {},
                 bool keep_groups = false);

}  // namespace sanso::diagnose
