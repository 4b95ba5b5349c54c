// Held-out losses without each term, a block bootstrap of the sizes, and the swap of each term.
#include "tools/diagnose/torque/judge.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/stats/random.h"
#include "tools/diagnose/stats/robust.h"
#include "tools/diagnose/stats/significance.h"
#include "tools/diagnose/torque/disagreement.h"
#include "tools/diagnose/torque/drive_gain.h"

namespace sanso::diagnose {
namespace {

double sum_over(const std::vector<double>& losses, const BlockCounts& counts) {
  double sum = 0.0;
  for (std::size_t b = 0; b < losses.size(); ++b) sum += counts[b] * losses[b];
  return sum;
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
    parallel_for(out.size(), [&](std::size_t i) { out[i] = judged(choice_.terms[i]); });
    return out;
  }

  /// Value of any column with its interval.
  JudgedValue value(Eigen::Index column) const {
    std::vector<double> drawn;
    for (const EffortValues& x : draws_) drawn.push_back(x[column]);
    const double deviation = standard_deviation(drawn);
    JudgedValue out;
    out.value = final_[column];
    out.low = out.value - kNormal95 * deviation, out.high = out.value + kNormal95 * deviation;
    return out;
  }

  const EffortValues& fitted() const { return fitted_; }

 private:
  /// Blocks drawn with replacement in pairs of neighbours, and few blocks spread too little.
  void resample() {
    const std::vector<std::size_t> active = choice_.active();
    draws_.resize(static_cast<std::size_t>(settings_.decisions.bootstrap));
    const std::size_t blocks = all_.size();
    const auto root = static_cast<std::size_t>(std::cbrt(blocks));
    const std::size_t length = std::max<std::size_t>(1, std::min(blocks / 3, root));
    parallel_for(draws_.size(), [&](std::size_t d) {
      Random random(seed_, d);
      BlockCounts counts(all_.size(), 0.0);
      for (std::size_t taken = 0; taken < blocks;) {
        const std::size_t from = random.below(blocks - length + 1);
        for (std::size_t k = 0; k < length && taken < blocks; ++k, ++taken) counts[from + k] += 1.0;
      }
      const double wider = std::sqrt(blocks / std::max(1.0, static_cast<double>(blocks - length)));
      draws_[d] = final_ + wider * (design_.fit(active, counts) - final_);
    });
  }

  JudgedTerm judged(std::size_t t) const {
    const EffortTerm& term = design_.terms()[t];
    JudgedTerm out;
    out.term = term;
    for (std::size_t c = 0; c < term.size(); ++c) {
      JudgedValue v = value(design_.first_column(t) + static_cast<Eigen::Index>(c));
      v.low = std::max(v.low, term.low[c]), v.high = std::min(v.high, term.high[c]);
      v.unit = term.units[c];
      v.at_bound = term.stopped(c, v.value);
      if (v.low > 0.0 || v.high < 0.0) out.spans_null = false;
      out.values.push_back(v);
    }
    // together: a ripple's sine may be nothing beside its cosine
    const std::vector<double> full = design_.losses(fitted_, term.joints);
    const EffortValues x = design_.fit(choice_.active_without(t), split_.fitted);
    const std::vector<double> without = design_.losses(x, term.joints);
    const double nominal =
        sum_over(design_.losses(EffortValues::Zero(fitted_.size()), term.joints), split_.heldout);
    const double gain = total(without, full);
    const EffortGain sure = gain_of(without, full, split_.heldout, settings_, seed_);
    out.predicts = sure.low > 0.0;
    out.heldout_gain = nominal > 0.0 ? gain / nominal : 0.0;
    // the bound as a share of the gain, in whichever measure is surer
    out.heldout_gain_low = sure.gain > 0.0 ? out.heldout_gain * sure.low / sure.gain : 0.0;
    out.equally_good = equally_good(t, full);
    return out;
  }

  /// Names at the same joints, with no more numbers, that leave no more on held-out data beyond
  /// chance when they stand in for term t.
  std::vector<std::string> equally_good(std::size_t t, const std::vector<double>& full) const {
    const EffortTerm& term = design_.terms()[t];
    std::vector<std::string> out;
    for (std::size_t r = 0; r < design_.terms().size(); ++r) {
      const EffortTerm& rival = design_.terms()[r];
      const bool taken =
          std::find(choice_.terms.begin(), choice_.terms.end(), r) != choice_.terms.end();
      if (taken || rival.nuisance || rival.effect == term.effect || rival.size() > term.size() ||
          !acts_alike(rival, term))
        continue;
      std::vector<std::size_t> active = choice_.active_without(t);
      const std::vector<double> none =
          design_.losses(design_.fit(active, split_.fitted), term.joints);
      active.push_back(r);
      const EffortValues x = design_.fit(active, split_.fitted);
      if (!plausible(r, active, x)) continue;
      const std::vector<double> other = design_.losses(x, term.joints);
      if (gain_of(other, full, split_.heldout, settings_, seed_).low > 0.0) continue;
      // not told apart for want of data is not as good: it has to do most of what the term does
      const double gain = total(none, full);
      if (gain > 0.0 && total(none, other) < settings_.decisions.stand_in_share * gain) continue;
      if (std::find(out.begin(), out.end(), rival.effect) == out.end()) out.push_back(rival.effect);
    }
    return out;
  }

  /// Held-out gain of b over a.
  double total(const std::vector<double>& a, const std::vector<double>& b) const {
    return sum_over(a, split_.heldout) - sum_over(b, split_.heldout);
  }

  /// As of a term that is chosen: no limit stops it, no friction is negative.
  bool plausible(std::size_t r, const std::vector<std::size_t>& active,
                 const EffortValues& x) const {
    const EffortTerm& term = design_.terms()[r];
    for (std::size_t c = 0; c < term.size(); ++c) {
      if (term.stopped(c, design_.value(x, r, c))) return false;
    }
    return term.law.dry != DryFriction::ripples || friction_is_positive(design_, active, x);
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

/// How fast a joint moved in the fitted part; beyond it a model is asked for what it never saw.
struct Reach {
  double speed = 0.0, acceleration = 0.0;

  static Reach of(const EffortRows& rows, const EffortSplit& split, std::size_t joint) {
    Reach out;
    for (const EffortRow& row : rows.rows) {
      if (row.joint != joint || split.fitted[row.block] == 0.0) continue;
      const MotionSample& m = middle(rows, row);
      out.speed = std::max(out.speed, std::abs(m.dq[joint]));
      out.acceleration = std::max(out.acceleration, std::abs(m.ddq[joint]));
    }
    return out;
  }
  /// Not faster than `beyond` times what was fitted.
  bool holds(const EffortRows& rows, const EffortRow& row, double beyond) const {
    const MotionSample& m = middle(rows, row);
    const std::size_t j = row.joint;
    return std::abs(m.dq[j]) <= beyond * speed && std::abs(m.ddq[j]) <= beyond * acceleration;
  }

 private:
  static const MotionSample& middle(const EffortRows& rows, const EffortRow& row) {
    return rows.recordings[row.recording].motion[(row.first + row.last) / 2];
  }
};

/// Held-out scores of one joint. `named`: values of the terms alone that predict.
EffortScore score_of(const EffortDesign& design, const EffortSplit& split, const EffortValues& x,
                     const EffortValues& named, std::size_t joint, double beyond) {
  const EffortRows& rows = design.rows();
  const Eigen::VectorXd left = design.residual(x), left_by_named = design.residual(named);
  const auto held = [&](const EffortRow& row) { return split.heldout[row.block] != 0.0; };
  const Reach reach = Reach::of(rows, split, joint);
  EffortScore out;
  std::vector<double> before, after, after_named, effort, fitted_effort;
  for (std::size_t i = 0; i < rows.rows.size(); ++i) {
    const EffortRow& row = rows.rows[i];
    if (row.joint != joint) continue;
    const auto k = static_cast<Eigen::Index>(i);
    const double recorded = design.recorded(i);
    if (!held(row)) {
      fitted_effort.push_back(recorded);
      continue;
    }
    if (!reach.holds(rows, row, beyond)) {
      ++out.beyond;
      continue;
    }
    before.push_back(design.target()[k]), after.push_back(left[k]), effort.push_back(recorded);
    after_named.push_back(left_by_named[k]);
  }
  const EffortRecording& first = rows.recordings.front();
  const std::string& column = first.channels[joint].column;
  out.joint = first.nominal.tree.joints[joint].name;
  out.channel = column.empty() ? "tau:" + out.joint : column;
  out.unit = design.unit(joint);
  const double middle = fitted_effort.empty() ? 0.0 : mean(fitted_effort);
  out.zero = rms(effort);
  for (double& e : effort) e -= middle;
  out.nominal = rms(before), out.constant = rms(effort), out.patched = rms(after);
  out.named = rms(after_named);
  out.noise = noise_of(after);
  return out;
}

/// By condition, or by recording where all have one: 1 for its blocks.
std::map<std::string, BlockCounts> groups_of(const EffortRows& rows) {
  std::map<std::string, int> conditions;
  for (const EffortRecording& r : rows.recordings) ++conditions[r.condition];
  std::map<std::string, BlockCounts> out;
  for (std::size_t b = 0; b < rows.recording_of_block.size(); ++b) {
    const EffortRecording& r = rows.recordings[rows.recording_of_block[b]];
    BlockCounts& counts =
        out[conditions.size() > 1 ? r.condition : std::filesystem::path(r.file).stem().string()];
    counts.resize(rows.recording_of_block.size(), 0.0);
    counts[b] = 1.0;
  }
  return out;
}

/// A group's own values of all columns, and their deviations between pieces of it left out.
std::pair<EffortValues, EffortValues> told_by(const EffortDesign& design,
                                              const std::vector<std::size_t>& active,
                                              const BlockCounts& group, int pieces) {
  const EffortValues all = design.fit(active, group);
  EffortValues squares = EffortValues::Zero(all.size());
  int count = 0;
  const auto blocks = static_cast<int>(std::count(group.begin(), group.end(), 1.0));
  for (int part = 0; part < pieces; ++part) {
    BlockCounts counts = group;
    int seen = 0;
    for (double& c : counts) {
      if (c != 0.0 && seen++ * pieces / std::max(1, blocks) == part) c = 0.0;
    }
    squares += (design.fit(active, counts) - all).cwiseAbs2();
    ++count;
  }
  // jackknife over a few large pieces
  return {all, (squares * (count - 1.0) / count).cwiseSqrt()};
}

/// What the recordings do not agree about, of terms that predict.
std::vector<std::string> disagreements(const EffortDesign& design, const EffortChoice& choice,
                                       const std::vector<JudgedTerm>& terms,
                                       const Settings& settings) {
  std::vector<std::string> out;
  const std::map<std::string, BlockCounts> groups = groups_of(design.rows());
  if (groups.size() < 2) return out;
  std::map<std::string, std::pair<EffortValues, EffortValues>> told;
  for (const auto& [name, counts] : groups)
    told[name] = told_by(design, choice.active(), counts, settings.effort.pieces);
  for (std::size_t i = 0; i < terms.size(); ++i) {
    const JudgedTerm& t = terms[i];
    for (std::size_t c = 0; t.predicts && c < t.term.size(); ++c) {
      const Eigen::Index column =
          design.first_column(choice.terms[i]) + static_cast<Eigen::Index>(c);
      std::vector<GroupValue> values;
      values.reserve(told.size());
      for (const auto& [name, value] : told)
        values.push_back({name, value.first[column], value.second[column]});
      const std::string text = disagreement(in_words(t.term) + ", " + t.term.parameters[c],
                                            t.term.units[c], values, settings.decisions);
      if (!text.empty()) out.push_back(text);
    }
  }
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
  out.heldout_last_part = split.last_part;
  const EffortChoice choice = choose_terms(design, split, settings, options);
  out.log = choice.log;
  const Judge judge(design, split, choice, settings, options.seed);
  out.terms = judge.terms();
  out.disagreements = disagreements(design, choice, out.terms, settings);
  out.notes.insert(out.notes.end(), out.disagreements.begin(), out.disagreements.end());
  for (EffortGainFound& gain : out.gains) {
    const std::optional<Eigen::Index> column = gain_column(design, gain.joint);
    if (!column || !gain.determined) continue;
    // recorded = (1 + x) needed, so one unit of it is worth 1 / (1 + x)
    const JudgedValue x = judge.value(*column);
    const double scale = gain.value;
    gain.value = scale / (1.0 + x.value);
    gain.low = scale / (1.0 + x.high), gain.high = scale / std::max(1e-9, 1.0 + x.low);
  }
  const EffortValues named = design.fit(choice.active_with([&](std::size_t i) {
    return out.terms[i].predicts && !out.terms[i].spans_null;
  }),
                                        split.fitted);
  for (std::size_t j = 0; j < rows.recordings.front().channels.size(); ++j) {
    if (rows.recordings.front().channels[j].known)
      out.scores.push_back(
          score_of(design, split, judge.fitted(), named, j, settings.effort.beyond));
  }
  const Eigen::VectorXd left = design.residual(judge.fitted());
  for (std::size_t i = 0; i < rows.rows.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    out.left.push_back({rows.rows[i], left[k], design.target()[k]});
  }
  return out;
}

}  // namespace sanso::diagnose
