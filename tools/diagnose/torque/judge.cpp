// Held-out losses without each term, a block bootstrap of the sizes, and the swap of each term.
#include "tools/diagnose/torque/judge.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/stats/robust.h"
#include "tools/diagnose/stats/significance.h"
#include "tools/diagnose/torque/drive_gain.h"

namespace sanso::diagnose {
namespace {

double sum_over(const std::vector<double>& losses, const BlockCounts& counts) {
  double sum = 0.0;
  for (std::size_t b = 0; b < losses.size(); ++b) sum += counts[b] * losses[b];
  return sum;
}

/// losses a - b on the counted blocks.
std::vector<double> differences(const std::vector<double>& a, const std::vector<double>& b,
                                const BlockCounts& counts) {
  std::vector<double> out;
  for (std::size_t k = 0; k < counts.size(); ++k) {
    if (counts[k] != 0.0) out.push_back(a[k] - b[k]);
  }
  return out;
}

class Judge {
 public:
  Judge(const EffortDesign& design, const EffortSplit& split, const EffortChoice& choice,
        const Settings& settings, unsigned long seed)
      : design_(design),
        split_(split),
        choice_(choice),
        settings_(settings),
        seed_(seed),
        all_(split.fitted.size(), 1.0),
        fitted_(design.fit(choice.active(), split.fitted)),
        final_(design.fit(choice.active(), all_)) {
    resample();
  }

  std::vector<JudgedTerm> terms() const {
    std::vector<JudgedTerm> out(choice_.terms.size());
    parallel_for(static_cast<int>(out.size()), [&](int i) {
      out[static_cast<std::size_t>(i)] = judged(choice_.terms[static_cast<std::size_t>(i)]);
    });
    return out;
  }

  /// Value of any column with its interval.
  JudgedValue value(int column) const {
    std::vector<double> drawn;
    for (const EffortValues& x : draws_) drawn.push_back(x[column]);
    const double deviation = standard_deviation(drawn);
    JudgedValue out;
    out.value = final_[column];
    out.low = out.value - 1.96 * deviation, out.high = out.value + 1.96 * deviation;
    return out;
  }

  const EffortValues& fitted() const { return fitted_; }

 private:
  /// Blocks drawn with replacement in pairs of neighbours, and few blocks spread too little.
  void resample() {
    const std::vector<int> active = choice_.active();
    draws_.resize(static_cast<std::size_t>(settings_.decisions.bootstrap));
    const int blocks = static_cast<int>(all_.size());
    const int length = std::max(1, std::min(blocks / 3, static_cast<int>(std::cbrt(blocks))));
    parallel_for(settings_.decisions.bootstrap, [&](int d) {
      Random random(seed_, static_cast<std::uint64_t>(d));
      BlockCounts counts(all_.size(), 0.0);
      for (int taken = 0; taken < blocks;) {
        const int from = random.below(blocks - length + 1);
        for (int k = 0; k < length && taken < blocks; ++k, ++taken)
          counts[static_cast<std::size_t>(from + k)] += 1.0;
      }
      const double wider = std::sqrt(blocks / std::max(1.0, static_cast<double>(blocks - length)));
      draws_[static_cast<std::size_t>(d)] = final_ + wider * (design_.fit(active, counts) - final_);
    });
  }

  JudgedTerm judged(int t) const {
    const EffortTerm& term = design_.terms()[static_cast<std::size_t>(t)];
    JudgedTerm out;
    out.term = term;
    for (int c = 0; c < term.size(); ++c) {
      const auto i = static_cast<std::size_t>(c);
      JudgedValue v = value(design_.first_column(t) + c);
      v.low = std::max(v.low, term.low[i]), v.high = std::min(v.high, term.high[i]);
      v.unit = term.units[i];
      v.at_bound = v.value <= term.low[i] || v.value >= term.high[i];
      if (v.low > 0.0 || v.high < 0.0) out.spans_null = false;
      out.values.push_back(v);
    }
    // together: a ripple's sine may be nothing beside its cosine
    const std::vector<double> full = design_.losses(fitted_, term.joints);
    const EffortValues x = design_.fit(choice_.active_without(t), split_.fitted);
    const std::vector<double> gains =
        differences(design_.losses(x, term.joints), full, split_.heldout);
    const double nominal =
        sum_over(design_.losses(EffortValues::Zero(fitted_.size()), term.joints), split_.heldout);
    double gain = 0.0;
    for (const double g : gains) gain += g;
    const double low = bound(gains);
    out.predicts = low > 0.0;
    out.heldout_gain = nominal > 0.0 ? gain / nominal : 0.0;
    out.heldout_gain_low = nominal > 0.0 ? low / nominal : 0.0;
    out.equally_good = equally_good(t, full);
    return out;
  }

  double bound(const std::vector<double>& x) const {
    return moving_block_lower_bound(x, settings_.decisions.gain_level,
                                    settings_.decisions.gain_draws, Random(seed_));
  }

  /// Names at the same joints, with no more numbers, that leave no more on held-out data beyond
  /// chance when they stand in for term t.
  std::vector<std::string> equally_good(int t, const std::vector<double>& full) const {
    const EffortTerm& term = design_.terms()[static_cast<std::size_t>(t)];
    std::vector<std::string> out;
    for (int r = 0; r < static_cast<int>(design_.terms().size()); ++r) {
      const EffortTerm& rival = design_.terms()[static_cast<std::size_t>(r)];
      const bool taken =
          std::find(choice_.terms.begin(), choice_.terms.end(), r) != choice_.terms.end();
      if (taken || rival.nuisance || rival.effect == term.effect || rival.size() > term.size() ||
          !acts_alike(rival, term))
        continue;
      std::vector<int> active = choice_.active_without(t);
      active.push_back(r);
      const std::vector<double> other =
          design_.losses(design_.fit(active, split_.fitted), term.joints);
      if (bound(differences(other, full, split_.heldout)) > 0.0) continue;
      if (std::find(out.begin(), out.end(), rival.effect) == out.end()) out.push_back(rival.effect);
    }
    return out;
  }

  /// A rival has to act on a joint that the term acts on most: a link also moves those before it.
  static bool acts_alike(const EffortTerm& rival, const EffortTerm& term) {
    return std::find(rival.joints.begin(), rival.joints.end(), term.joints.back()) !=
           rival.joints.end();
  }

  const EffortDesign& design_;
  const EffortSplit& split_;
  const EffortChoice& choice_;
  const Settings& settings_;
  unsigned long seed_;
  BlockCounts all_;
  EffortValues fitted_, final_;
  std::vector<EffortValues> draws_;
};

/// RMS of what changes from one window to the next, as white noise would: second differences.
double noise_of(const std::vector<double>& left) {
  std::vector<double> second;
  for (std::size_t k = 1; k + 1 < left.size(); ++k)
    second.push_back((left[k + 1] - 2 * left[k] + left[k - 1]) / std::sqrt(6.0));
  return robust_sigma(second);
}

/// Held-out scores of one joint.
EffortScore score_of(const EffortDesign& design, const EffortSplit& split, const EffortValues& x,
                     int joint) {
  const EffortRows& rows = design.rows();
  const Eigen::VectorXd left = design.residual(x);
  const auto held = [&](const EffortRow& row) {
    return split.heldout[static_cast<std::size_t>(row.block)] != 0.0;
  };
  std::vector<double> before, after, effort, fitted_effort;
  for (std::size_t i = 0; i < rows.rows.size(); ++i) {
    const EffortRow& row = rows.rows[i];
    if (row.joint != joint) continue;
    const auto k = static_cast<Eigen::Index>(i);
    const double recorded = design.recorded(i);
    if (!held(row)) {
      fitted_effort.push_back(recorded);
      continue;
    }
    before.push_back(design.target()[k]), after.push_back(left[k]), effort.push_back(recorded);
  }
  const EffortRecording& first = rows.recordings.front();
  const auto j = static_cast<std::size_t>(joint);
  EffortScore out;
  out.joint = first.nominal.tree.joints[j].name;
  out.channel = first.channels[j].column.empty() ? "tau:" + out.joint : first.channels[j].column;
  out.unit = design.unit(joint);
  const double middle = fitted_effort.empty() ? 0.0 : mean(fitted_effort);
  for (double& e : effort) e -= middle;
  out.nominal = rms(before), out.constant = rms(effort), out.patched = rms(after);
  out.noise = noise_of(after);
  return out;
}

}  // namespace

EffortOutcome explain_effort(const EffortRows& rows, const Settings& settings,
                             const ChooseOptions& options) {
  EffortDesign design(rows);
  design.append(effort_terms(rows, settings));
  EffortOutcome out;
  out.notes = rows.notes;
  out.gains = scale_unknown_gains(design, settings);
  const EffortSplit split = split_blocks(rows, settings.effort);
  out.heldout_names = split.heldout_names;
  const EffortChoice choice = choose_terms(design, split, settings, options);
  out.log = choice.log;
  const Judge judge(design, split, choice, settings, options.seed);
  out.terms = judge.terms();
  for (EffortGainFound& gain : out.gains) {
    const int column = gain_column(design, gain.joint);
    if (column < 0 || !gain.determined) continue;
    // recorded = (1 + x) needed, so one unit of it is worth 1 / (1 + x)
    const JudgedValue x = judge.value(column);
    const double scale = gain.value;
    gain.value = scale / (1.0 + x.value);
    gain.low = scale / (1.0 + x.high), gain.high = scale / std::max(1e-9, 1.0 + x.low);
  }
  for (std::size_t j = 0; j < rows.recordings.front().channels.size(); ++j) {
    if (rows.recordings.front().channels[j].known)
      out.scores.push_back(score_of(design, split, judge.fitted(), static_cast<int>(j)));
  }
  const Eigen::VectorXd left = design.residual(judge.fitted());
  for (std::size_t i = 0; i < rows.rows.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    out.left.push_back({rows.rows[i], left[k], design.target()[k]});
  }
  return out;
}

}  // namespace sanso::diagnose
