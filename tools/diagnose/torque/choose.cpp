// Which terms the missing effort is made of: forward by the largest gain in the fitted part, taken
// only where blocks are predicted that were left out; backward where a term no longer pays; and all
// of that again with the weights that what is left suggests.
#include "tools/diagnose/torque/choose.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/effects/effort_only.h"
#include "tools/diagnose/effects/parameter_of.h"

namespace sanso::diagnose {
namespace {

bool is_ripple(const EffortTerm& term) { return term.law.kind == EffortKind::ripple; }

std::vector<std::size_t> plus(std::vector<std::size_t> set, std::size_t more) {
  set.push_back(more);
  return set;
}

/// Span of a joint's angle over the rows, rad.
double range_of(const EffortRows& rows, std::size_t joint) {
  double low = 1e300, high = -1e300;
  for (const EffortRow& row : rows.rows) {
    const double q = rows.recordings[row.recording].motion[row.first].q[joint];
    if (row.joint == joint) low = std::min(low, q), high = std::max(high, q);
  }
  return std::max(0.0, high - low);
}

class Chooser {
 public:
  Chooser(EffortDesign& design, const EffortSplit& split, const Settings& settings,
          const ChooseOptions& options)
      : design_(design), split_(split), settings_(settings), options_(options) {
    for (std::size_t t = 0; t < design.terms().size(); ++t) {
      if (design.terms()[t].nuisance) choice_.nuisances.push_back(t);
    }
    const auto joints = design.rows().recordings.front().channels.size();
    for (std::size_t j = 0; j < joints; ++j) range_.push_back(range_of(design.rows(), j));
  }

  EffortChoice run() {
    for (int round = 0; round < settings_.effort.rounds; ++round) {
      const std::vector<std::size_t> before = choice_.terms;
      weigh();
      const auto most = static_cast<std::size_t>(settings_.effort.maximum_terms);
      // a drive that turns two joints is asked for what the joints' own terms leave
      for (const bool coupled : {false, true}) {
        coupled_ = coupled;
        while (choice_.terms.size() < most && forward()) {
        }
      }
      backward();
      if (choice_.terms == before) break;
    }
    return choice_;
  }

 private:
  void say(const std::string& line) {
    choice_.log.push_back(line);
    if (options_.progress) options_.progress(line);
  }

  /// Weights by what is left: of the nuisances alone in the first round, of the choice after it.
  void weigh() {
    const EffortValues x = design_.fit(choice_.active(), split_.fitted);
    design_.set_weights(
        robust_weights(design_.rows(), design_.residual(x), settings_.effort.outlier));
  }

  bool allowed(std::string_view effect) const {
    const auto has = [&](const std::vector<std::string>& list) {
      return std::find(list.begin(), list.end(), effect) != list.end();
    };
    return (options_.effects.empty() || has(options_.effects)) && !has(options_.without);
  }

  /// Taken already, another size of what was taken, or not asked for.
  bool open(std::size_t t) const {
    const EffortTerm& term = design_.terms()[t];
    if (term.nuisance || !allowed(term.effect)) return false;
    if (term.effect == kCoupledDrive.id && !coupled_) return false;
    int ripples = 0;
    for (const std::size_t taken : choice_.terms) {
      const EffortTerm& other = design_.terms()[taken];
      if (other.effect != term.effect || other.where != term.where) continue;
      if (!is_ripple(term) || term.same_as(other)) return false;
      ++ripples;
    }
    return ripples < settings_.effort.ripples;
  }

  /// sum over the fitted blocks of weights (target - X x)^2.
  double total(const EffortValues& x) const {
    const std::vector<double> losses = design_.losses(x);
    double sum = 0.0;
    for (std::size_t b = 0; b < losses.size(); ++b) sum += split_.fitted[b] * losses[b];
    return sum;
  }

  /// Appends the ripple of each kind and joint that describes most of what is left.
  void look_for_ripples() {
    const EffortValues x = design_.fit(choice_.active(), split_.fitted);
    const Eigen::VectorXd left = design_.residual(x);
    std::vector<EffortTerm> found;
    for (std::size_t j = 0; j < range_.size(); ++j) {
      if (design_.rows().recordings.front().nominal.tree.joints[j].prismatic) continue;
      for (const Effect* effect : effort_effects(EffortKind::ripple)) {
        if (!allowed(effect->id)) continue;
        const int order = strongest_order(left, j, *effect);
        if (order == 0) continue;
        EffortTerm term = ripple_term(design_.rows(), *effect, j, order);
        const bool known =
            std::any_of(design_.terms().begin(), design_.terms().end(),
                        [&](const EffortTerm& other) { return other.same_as(term); });
        if (!known) found.push_back(std::move(term));
      }
    }
    if (!found.empty()) design_.append(std::move(found));
  }

  /// Order whose sine and cosine take most out of the joint's residual and is not taken; 0: the
  /// joint does not turn through a period of any.
  int strongest_order(const Eigen::VectorXd& left, std::size_t joint, const Effect& effect) const {
    const bool friction = effect.effort.dry == DryFriction::ripples;
    const double range = range_[joint];
    int highest = settings_.effort.highest_order;
    for (const EffectParameter& p : effect.parameters) {
      if (p.role == Role::order) highest = std::min(highest, static_cast<int>(p.high));
    }
    int best = 0;
    double most = 0.0;
    for (int order = 1; order <= highest; ++order) {
      if (order * range < 2.0 * std::numbers::pi) continue;
      const EffortTerm asked = ripple_term(design_.rows(), effect, joint, order);
      const bool taken =
          std::any_of(choice_.terms.begin(), choice_.terms.end(),
                      [&](std::size_t t) { return design_.terms()[t].same_as(asked); });
      const double power = taken ? 0.0 : power_of(left, joint, order, friction);
      if (power > most) most = power, best = order;
    }
    return best;
  }

  /// s^2 + c^2 over the joint's rows of the fitted part, q and dq in the middle of each:
  ///
  ///   s = sum of e sin(order q),  c = sum of e cos(order q),  e = weights left
  ///
  /// Of a friction that ripples, e has the sign of dq.
  double power_of(const Eigen::VectorXd& left, std::size_t j, int order, bool friction) const {
    double s = 0.0, c = 0.0;
    const EffortRows& rows = design_.rows();
    for (std::size_t i = 0; i < rows.rows.size(); ++i) {
      const EffortRow& row = rows.rows[i];
      if (row.joint != j || split_.fitted[row.block] == 0.0) continue;
      const MotionSample& m = rows.recordings[row.recording].motion[(row.first + row.last) / 2];
      const auto k = static_cast<Eigen::Index>(i);
      const double e = left[k] * design_.weights()[k] * (friction && m.dq[j] < 0.0 ? -1.0 : 1.0);
      s += e * std::sin(order * m.q[j]), c += e * std::cos(order * m.q[j]);
    }
    return s * s + c * c;
  }

  /// Takes the first of the best terms that predicts blocks it was not fitted to.
  bool forward() {
    look_for_ripples();
    const std::vector<std::size_t> active = choice_.active();
    const double before = total(design_.fit(active, split_.fitted));
    std::vector<std::size_t> candidates;
    for (std::size_t t = 0; t < design_.terms().size(); ++t) {
      if (open(t)) candidates.push_back(t);
    }
    // gain = total without the candidate - total with it, both fitted
    std::vector<double> gain(candidates.size());
    parallel_for(candidates.size(), [&](std::size_t c) {
      gain[c] = before - total(design_.fit(plus(active, candidates[c]), split_.fitted));
    });
    std::vector<std::size_t> order(candidates.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return gain[a] > gain[b]; });
    // those that are not plausible cost nothing and take no place
    std::erase_if(order, [&](std::size_t i) {
      return !(gain[i] > 0.0) || !plausible(active, candidates[i]);
    });
    const auto tried = std::min(order.size(), static_cast<std::size_t>(settings_.decisions.rivals));
    for (std::size_t i = 0; i < tried; ++i) {
      if (!pays(active, candidates[order[i]])) continue;
      // those that gain more than half as much may be the same in simpler words
      std::vector<std::size_t> next;
      for (std::size_t k = i + 1; k < order.size() && gain[order[k]] > 0.5 * gain[order[i]]; ++k)
        next.push_back(candidates[order[k]]);
      take(active, less_wild(active, simplest(active, candidates[order[i]], next), next));
      return true;
    }
    return false;
  }

  /// A term that a limit stops stands for something else, and is no ground to go on from; nor is
  /// a friction that would be negative at some angle.
  bool plausible(const std::vector<std::size_t>& active, std::size_t t) const {
    const EffortTerm& term = design_.terms()[t];
    const std::vector<std::size_t> with = plus(active, t);
    const EffortValues x = design_.fit(with, split_.fitted);
    for (std::size_t c = 0; c < term.size(); ++c) {
      if (term.stopped(c, design_.value(x, t, c))) return false;
    }
    return term.law.dry != DryFriction::ripples || friction_is_positive(design_, with, x);
  }

  /// The best term, or one with fewer numbers at the same joints that predicts as well.
  std::size_t simplest(const std::vector<std::size_t>& active, std::size_t best,
                       const std::vector<std::size_t>& next) const {
    const EffortTerm& term = design_.terms()[best];
    for (const std::size_t t : next) {
      const EffortTerm& other = design_.terms()[t];
      if (other.size() >= term.size() || other.joints != term.joints) continue;
      const EffortGain g = crossed_gain(design_, plus(active, t), plus(active, best), split_.fitted,
                                        term.joints, settings_, options_.seed);
      if (g.low <= 0.0 && plausible(active, t) && pays(active, t)) return t;
    }
    return best;
  }

  /// A link that is wild (EffortColumns) stands back where another term at its joint does nearly as
  /// well: a rotor does what an enormous mass does.
  std::size_t less_wild(const std::vector<std::size_t>& active, std::size_t best,
                        const std::vector<std::size_t>& next) const {
    const EffortTerm& term = design_.terms()[best];
    const auto left = [&](std::size_t t) {
      return total(design_.fit(plus(active, t), split_.fitted));
    };
    const EffortValues x = design_.fit(plus(active, best), split_.fitted);
    if (!(design_.value(x, best, 0) > term.law.wild)) return best;
    const double before = total(design_.fit(active, split_.fitted)), gain = before - left(best);
    const double enough = (1.0 - settings_.effort.nearly) * gain;
    for (const std::size_t t : next) {
      const EffortTerm& other = design_.terms()[t];
      const bool link = other.law.kind == EffortKind::link;
      if (link || other.joints.back() != term.joints.back()) continue;
      if (before - left(t) > enough && plausible(active, t) && pays(active, t)) return t;
    }
    return best;
  }

  /// Adds t to the choice, tells what is reached, and what share of the error left it predicts.
  void take(const std::vector<std::size_t>& active, std::size_t t) {
    const EffortTerm& term = design_.terms()[t];
    const EffortGain g = crossed_gain(design_, active, plus(active, t), split_.fitted, term.joints,
                                      settings_, options_.seed);
    choice_.terms.push_back(t);
    tell();
    say(fmt::format("+ {}: {:.1f} % of what is left there", in_words(term), 100 * g.share));
  }

  /// Values of the choice and the share that they remove, 1 - total(x) / total(0).
  void tell() const {
    if (!options_.reached) return;
    const EffortValues x = design_.fit(choice_.active(), split_.fitted);
    std::vector<JudgedTerm> chosen;
    for (const std::size_t t : choice_.terms) {
      JudgedTerm out;
      out.term = design_.terms()[t];
      for (std::size_t c = 0; c < out.term.size(); ++c) {
        const double value = design_.value(x, t, c);
        out.values.push_back({value, value, value, out.term.units[c], false});
      }
      chosen.push_back(std::move(out));
    }
    const double before = total(EffortValues::Zero(x.size()));
    options_.reached(chosen, before > 0.0 ? 1.0 - total(x) / before : 0.0);
  }

  /// Predicts blocks it was not fitted to beyond chance, and takes a share that matters.
  bool pays(const std::vector<std::size_t>& active, std::size_t t) const {
    const EffortTerm& term = design_.terms()[t];
    const EffortGain g = crossed_gain(design_, active, plus(active, t), split_.fitted, term.joints,
                                      settings_, options_.seed);
    return g.low > 0.0 && g.share >= settings_.decisions.minimum_share;
  }

  /// Drops the least useful of the terms that no longer predict, until all do.
  void backward() {
    while (!choice_.terms.empty()) {
      std::optional<std::size_t> worst;
      double least = 0.0;
      for (const std::size_t t : choice_.terms) {
        const EffortTerm& term = design_.terms()[t];
        const EffortGain g = crossed_gain(design_, choice_.active_without(t), choice_.active(),
                                          split_.fitted, term.joints, settings_, options_.seed);
        if (g.low <= 0.0 && (!worst || g.share < least)) worst = t, least = g.share;
      }
      if (!worst) return;
      say("- " + in_words(design_.terms()[*worst]));
      std::erase(choice_.terms, *worst);
    }
  }

  EffortDesign& design_;
  const EffortSplit& split_;
  const Settings& settings_;
  const ChooseOptions& options_;
  EffortChoice choice_;
  std::vector<double> range_;
  bool coupled_ = false;  // drives of two joints are open
};

/// Recordings that judge: of several conditions the smallest, of three recordings every third.
std::vector<char> whole_recordings(const EffortRows& rows) {
  std::vector<char> held(rows.recordings.size(), 0);
  std::map<std::string, double> seconds;
  for (const EffortRecording& r : rows.recordings) seconds[r.condition] += r.t.back() - r.t.front();
  if (seconds.size() > 1) {
    const auto least = std::min_element(seconds.begin(), seconds.end(),
                                        [](auto& a, auto& b) { return a.second < b.second; });
    for (std::size_t r = 0; r < held.size(); ++r)
      held[r] = rows.recordings[r].condition == least->first ? 1 : 0;
  } else if (held.size() > 2) {
    for (std::size_t r = 2; r < held.size(); r += 3) held[r] = 1;
  }
  return held;
}

}  // namespace

EffortSplit split_blocks(const EffortRows& rows, const EffortSettings& settings) {
  const std::vector<char> held = whole_recordings(rows);
  const bool whole = std::find(held.begin(), held.end(), 1) != held.end();
  EffortSplit out;
  out.last_part = !whole;
  std::map<std::size_t, int> count, seen;
  for (const std::size_t r : rows.recording_of_block) ++count[r];
  for (const std::size_t r : rows.recording_of_block) {
    const bool early = seen[r]++ < (1.0 - settings.judged_share) * count[r];
    const bool fitted = whole ? held[r] == 0 : early;
    out.fitted.push_back(fitted ? 1.0 : 0.0), out.heldout.push_back(fitted ? 0.0 : 1.0);
  }
  for (std::size_t r = 0; r < held.size(); ++r) {
    if (whole && held[r] == 0) continue;
    out.heldout_names.push_back(whole ? rows.recordings[r].file
                                      : fmt::format("last {:.0f} % of {}",
                                                    100 * settings.judged_share,
                                                    rows.recordings[r].file));
  }
  return out;
}

std::vector<std::size_t> EffortChoice::active() const {
  return active_with([](std::size_t) { return true; });
}

std::vector<std::size_t> EffortChoice::active_without(std::size_t term) const {
  std::vector<std::size_t> out = nuisances;
  for (const std::size_t t : terms) {
    if (t != term) out.push_back(t);
  }
  return out;
}

std::vector<std::size_t> EffortChoice::active_with(
    const std::function<bool(std::size_t)>& kept) const {
  std::vector<std::size_t> out = nuisances;
  for (std::size_t i = 0; i < terms.size(); ++i) {
    if (kept(i)) out.push_back(terms[i]);
  }
  return out;
}

EffortChoice choose_terms(EffortDesign& design, const EffortSplit& split, const Settings& settings,
                          const ChooseOptions& options) {
  return Chooser(design, split, settings, options).run();
}

std::string in_words(const EffortTerm& term) {
  std::string places, fixed;
  for (const std::string& w : term.where) places += (places.empty() ? "" : ", ") + w;
  for (const auto& [name, value] : term.fixed) {
    const EffectParameter* known = find_parameter(term.effect, name);
    // the shape of a curve, which every term of the kind has alike
    if (known == nullptr || known->scale != Unit::none)
      fixed += fmt::format("{}{} {:.3g}", fixed.empty() ? " (" : ", ", name, value);
  }
  return term.effect + " at " + places + (fixed.empty() ? "" : fixed + ")");
}

}  // namespace sanso::diagnose
