#include "tools/diagnose/search/select.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/diagnose/constants.h"
#include "tools/diagnose/search/parallel.h"
#include "tools/diagnose/search/scatter.h"
#include "tools/diagnose/search/start.h"

namespace sanso::diagnose {
namespace {

/// One state of the search.
class Search {
 public:
  Search(Problem& problem, const Library& library, const SelectOptions& options)
      : problem_(problem), library_(library), options_(options) {}

  Selection run() {
    start();
    for (int step = 0; step < constants::kMaximumEffects; ++step) {
      if (!forward(step)) break;
      if (out_.accepted.size() > 1) backward();
    }
    swap();
    drop_refuted();
    judge_random();
    finish();
    return std::move(out_);
  }

 private:
  const Candidate& candidate(int i) const { return library_.candidates[static_cast<std::size_t>(i)]; }

  void say(const std::string& text) {
    out_.log.push_back(text);
    options_.progress(text);
  }

  void start() {
    correct_step(problem_, library_, Model{});
    out_.around = make_surroundings(problem_, library_, Model{});
    std::vector<int> all(library_.candidates.size());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<int>(i);
    const Eigen::VectorXd r = prediction_error(problem_, library_, Model{});
    out_.around->set_shot_scale(out_.around->starts.energy_by_shot(r));
    out_.first = screen(*out_.around, Model{}, r, all, Random(options_.seed, 1), nullptr, {}, options_.keep_groups);
    calibrate(out_.first);
    say(fmt::format("screened {} candidates ({} signatures), error level {}, critical score {:.2f}", all.size(),
                    out_.first.probes.size(), error_levels(), out_.first.critical));
  }

  std::string error_levels() const {
    std::string text;
    for (const Observed& c : problem_.channels) {
      text += fmt::format("{}{}:{} {:.2g}", text.empty() ? "" : ", ", to_string(c.signal),
                          problem_.joints[static_cast<std::size_t>(c.joint)], c.sigma);
    }
    return text;
  }

  /// Channels to their error levels, and everything that depends on them again.
  void calibrate(const Screening& screening) {
    for (std::size_t c = 0; c < problem_.channels.size(); ++c) problem_.channels[c].sigma = screening.channel_sigma[c];
    relinearise();
  }

  int free_parameters(int c) const {
    const std::vector<CandidateParameter>& all = candidate(c).parameters;
    return static_cast<int>(
        std::count_if(all.begin(), all.end(), [](const CandidateParameter& p) { return !p.structural; }));
  }

  /// What is fitted fully: of every cluster its simplest member that scores nearly as high as its strongest, then the
  /// strongest members, then the rest by score.
  std::vector<int> rivals(const Screening& screening) const {
    std::vector<int> significant, leaders, chosen;
    for (int c : screening.ranking()) {
      if (candidate(c).random) continue;  // judged by scatter, see judge_random
      const ProbeScore& best = *screening.best(c);
      // what a fit can remove is the squared score, as far as the model is linear; below a share of what counts it is
      // not tried
      const bool worth =
          constants::kLinearReach * best.score * best.score > std::max(practical(), constants::kMinimumShare * whole());
      if (best.p_family < constants::kFamilyWise && worth) significant.push_back(c);
    }
    for (int c : significant) {
      const bool new_cluster = std::none_of(leaders.begin(), leaders.end(), [&](int other) {
        return screening.similarity(c, other) > constants::kSameSignature;
      });
      if (new_cluster) leaders.push_back(c);
    }
    const auto add = [&](int c) {
      if (static_cast<int>(chosen.size()) < constants::kRivals &&
          std::find(chosen.begin(), chosen.end(), c) == chosen.end())
        chosen.push_back(c);
    };
    for (int leader : leaders) {
      int simplest = leader;
      for (int c : significant) {
        const bool member = screening.similarity(c, leader) > constants::kSameSignature;
        const bool nearly = screening.best(c)->score > 0.8 * screening.best(leader)->score;
        if (member && nearly && free_parameters(c) < free_parameters(simplest)) simplest = c;
      }
      add(simplest);
      if (leader == leaders.front()) add(leader);
    }
    for (int leader : leaders) add(leader);
    for (int c : significant) add(c);
    return chosen;
  }

  /// Fits `base` + each of `which`, in parallel; held-out energies included. `known`: earlier fits of the same
  /// candidates, to start from. Candidates far behind after the first steps are not polished.
  std::vector<Alternative> fit_all(const Model& base, const std::vector<int>& which, const Screening& screening,
                                   const std::vector<Alternative>& known = {}) const {
    std::vector<Alternative> out(which.size());
    parallel_for(static_cast<int>(which.size()), [&](int i) {
      Alternative& a = out[static_cast<std::size_t>(i)];
      a.candidate = which[static_cast<std::size_t>(i)];
      const auto before =
          std::find_if(known.begin(), known.end(), [&](const Alternative& k) { return k.candidate == a.candidate; });
      Model start{base.effects, {}};
      if (before != known.end()) {
        start.effects.push_back(before->fit.model.effects.back());
      } else {
        start = best_start(*out_.around, base, a.candidate, screening.best(a.candidate));
      }
      a.fit = fit(*out_.around, start, constants::kFirstIterations);
    });
    double best = INFINITY;
    for (const Alternative& a : out) best = std::min(best, a.fit.objective);
    const double near = best + constants::kPolishShare * std::max(0.0, out_.final.objective - best);
    parallel_for(static_cast<int>(which.size()), [&](int i) {
      Alternative& a = out[static_cast<std::size_t>(i)];
      if (!a.fit.converged && a.fit.objective <= near) {
        a.fit = fit(*out_.around, a.fit.model, constants::kIterations - constants::kFirstIterations);
      }
      a.heldout = heldout_energy(*out_.around, a.fit);
    });
    return out;
  }

  /// Best first. Among those within one standard error of the best (one-SE rule) or a difference that does
  /// not matter, the one with fewest parameters.
  void rank(std::vector<Alternative>& all) const {
    if (all.empty()) return;
    std::stable_sort(all.begin(), all.end(),
                     [](const Alternative& a, const Alternative& b) { return a.heldout.sum() < b.heldout.sum(); });
    const Eigen::VectorXd best = all.front().heldout;
    for (Alternative& a : all) {
      const HeldoutGain g = compare(a.heldout, best);
      a.behind = g.total;
      a.behind_se = g.standard_error;
    }
    std::size_t pick = 0;
    for (std::size_t i = 1; i < all.size(); ++i) {
      // a name with more parameters has to be better by something that matters
      const bool close = all[i].behind <= std::max(all[i].behind_se + noise_unit(), practical());
      if (close && free_parameters(all[i].candidate) < free_parameters(all[pick].candidate)) pick = i;
    }
    std::rotate(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(pick),
                all.begin() + static_cast<std::ptrdiff_t>(pick) + 1);
  }

  /// A difference of this many energy units is one unit of log-likelihood.
  double noise_unit() const { return 2.0; }

  /// Energy that an effect of the smallest size that matters removes, at one joint alone.
  double practical() const {
    return std::max(noise_unit(), constants::kPracticalSize * constants::kPracticalSize * rows_of_a_joint(problem_));
  }

  /// Parameters of the last effect of a fit: f(parameter, value, sigma, held at a bound) until it returns true.
  template <class F>
  bool any_parameter(const Alternative& a, const F& f) const {
    const std::vector<double> sigma = parameter_sigmas(a.fit, library_);
    const std::vector<CandidateParameter>& parameters = candidate(a.candidate).parameters;
    const std::size_t first = sigma.size() - parameters.size();
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      if (parameters[i].structural) continue;
      if (f(parameters[i], a.fit.model.effects.back().theta[i], sigma[first + i], a.fit.fixed[first + i] != 0))
        return true;
    }
    return false;
  }
  bool leaves_null(const Alternative& a) const {
    const std::vector<CandidateParameter>& all = candidate(a.candidate).parameters;
    if (std::all_of(all.begin(), all.end(), [](const CandidateParameter& p) { return p.structural; })) return true;
    return any_parameter(a, [](const CandidateParameter& p, double value, double sigma, bool fixed) {
      return std::abs(value - p.null) > (fixed ? 0.0 : constants::kStandardErrors * sigma);
    });
  }
  bool at_bound(const Alternative& a) const {
    return any_parameter(
        a, [](const CandidateParameter& p, double value, double, bool fixed) { return fixed && !at_null(p, value); });
  }
  double whole() const { return std::max(out_.nominal_heldout.sum(), 1e-9); }

  /// Empty when the alternative may be accepted over the current model; else the gate that it fails. `refutable`: also
  /// the residual that it should have changed.
  std::string refused_by(const Alternative& a, bool refutable) const {
    const HeldoutGain gain = compare(out_.final_heldout, a.heldout);
    if (gain.lower <= 0.0) return "held-out gain not beyond chance";
    if (gain.total < practical()) return "changes predictions by less than what matters";
    if (gain.total < constants::kMinimumShare * whole()) return "removes less than 1 % of the error";
    if (!leaves_null(a)) return "interval contains the null";
    if (!holds_on_conditions(a)) return "worse on conditions left out";
    if (refutable) return options_.refuted_by(*out_.around, out_.final, a.fit);
    return "";
  }

  bool holds_on_conditions(const Alternative& a) const {
    if (problem_.conditions < 2) return true;
    const HeldoutGain gain =
        compare(heldout_energy(*out_.around, out_.final, true), heldout_energy(*out_.around, a.fit, true));
    return gain.total > -gain.standard_error;
  }

  bool forward(int step) {
    std::vector<int> open;
    for (std::size_t i = 0; i < library_.candidates.size(); ++i) {
      if (!out_.final.model.has(static_cast<int>(i))) open.push_back(static_cast<int>(i));
    }
    Screening screening =
        step == 0 ? out_.first
                  : screen(*out_.around, out_.final.model, out_.final.r, open, Random(options_.seed, 10 + step),
                           &out_.first, out_.final.J.leftCols(out_.final.parameters));
    if (step > 0) calibrate(screening);
    const std::vector<int> which = rivals(screening);
    if (which.empty()) {
      say(fmt::format("step {}: no candidate stands out (strongest score {:.2f}, critical {:.2f})", step + 1,
                      screening.probes.empty() ? 0.0 : screening.best(screening.ranking().front())->score,
                      screening.critical));
      return false;
    }
    std::vector<Alternative> fitted = fit_all(out_.final.model, which, screening);
    rank(fitted);
    // first those inside their bounds that no residual contradicts; one of two missing effects may look contradicted
    for (const auto& [bounds_allowed, refutable] : {std::pair{false, true}, {false, false}, {true, true}}) {
      for (std::size_t i = 0; i < fitted.size(); ++i) {
        if (at_bound(fitted[i]) != bounds_allowed) continue;
        const std::string refused = refused_by(fitted[i], refutable);
        const HeldoutGain gain = compare(out_.final_heldout, fitted[i].heldout);
        say(fmt::format("step {}: {}: held-out gain {:.1f} % of the error (at least {:.1f}){}{}", step + 1,
                        candidate(fitted[i].candidate).title(), 100 * gain.total / whole(), 100 * gain.lower / whole(),
                        bounds_allowed ? ", ends at a bound" : "",
                        refused.empty() ? ", accepted" : ", refused: " + refused));
        if (!refused.empty()) continue;
        accept(std::move(fitted), i, screening);
        return true;
      }
    }
    return false;
  }

  void accept(std::vector<Alternative> fitted, std::size_t i, const Screening& screening) {
    Accepted entry;
    entry.candidate = fitted[i].candidate;
    entry.p_family = screening.best(entry.candidate)->p_family;
    out_.final = fitted[i].fit;
    fitted.erase(fitted.begin() + static_cast<std::ptrdiff_t>(i));
    for (Alternative& a : fitted) a.similarity = screening.similarity(a.candidate, entry.candidate);
    for (Alternative& a : fitted) a.fit.J.resize(0, 0);  // 0.1 GB each on twelve joints, and done with
    entry.alternatives = std::move(fitted);
    out_.accepted.push_back(std::move(entry));
    relinearise();
  }

  /// Starts and nuisances at the current model; its fit polished there, the nominal model's too.
  void relinearise() {
    correct_step(problem_, library_, out_.final.model);
    out_.around = make_surroundings(problem_, library_, out_.final.model);
    out_.around->set_shot_scale(
        out_.around->starts.energy_by_shot(prediction_error(problem_, library_, out_.final.model)));
    out_.final = fit(*out_.around, out_.final.model, 3);
    out_.nominal = out_.accepted.empty() ? out_.final : fit(*out_.around, Model{{}, out_.nominal.model.nuisance}, 1);
    out_.nominal_heldout = heldout_energy(*out_.around, out_.nominal);
    out_.final_heldout = heldout_energy(*out_.around, out_.final);
  }

  FitResult without(std::size_t index) const {
    Model model = out_.final.model;
    model.effects.erase(model.effects.begin() + static_cast<std::ptrdiff_t>(index));
    return fit(*out_.around, model, 4);
  }

  void backward() {
    for (std::size_t i = 0; i + 1 < out_.accepted.size();) {
      if (candidate(out_.accepted[i].candidate).random) {  // needed for the scatter, whatever its mean gains
        ++i;
        continue;
      }
      const FitResult reduced = without(i);
      const HeldoutGain gain = compare(heldout_energy(*out_.around, reduced), out_.final_heldout);
      const bool needed =
          gain.lower > 0.0 && gain.total > practical() && gain.total > constants::kMinimumShare * whole();
      if (needed) {
        ++i;
        continue;
      }
      say("no longer needed: " + candidate(out_.accepted[i].candidate).title());
      out_.accepted.erase(out_.accepted.begin() + static_cast<std::ptrdiff_t>(i));
      out_.final = reduced;
      relinearise();
    }
  }

  /// Which candidates to try in place of an accepted one: its cluster, its known confounders, what was fitted beside
  /// it.
  std::vector<int> replacements(const Accepted& entry) const {
    std::vector<std::pair<double, int>> order;
    for (std::size_t i = 0; i < library_.candidates.size(); ++i) {
      const int c = static_cast<int>(i);
      if (out_.final.model.has(c) || candidate(c).random) continue;
      const Candidate &own = candidate(entry.candidate), &other = candidate(c);
      const double similarity = out_.first.similarity(entry.candidate, c);
      const bool same_place = other.joints == own.joints || other.joints.empty() || own.joints.empty();
      const bool known = same_place && std::find(own.confounders.begin(), own.confounders.end(), other.effect) !=
                                           own.confounders.end();
      const bool fitted = std::any_of(entry.alternatives.begin(), entry.alternatives.end(),
                                      [&](const Alternative& a) { return a.candidate == c; });
      if (similarity > constants::kSameSignature || known || fitted)
        order.emplace_back(similarity + (known ? 0.5 : 0.0), c);
    }
    std::stable_sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    std::vector<int> out;
    for (const auto& [score, c] : order) {
      if (static_cast<int>(out.size()) < constants::kRivals) out.push_back(c);
    }
    return out;
  }

  /// Every accepted effect against its rivals, everything else refitted; the better one stays, the others are kept as
  /// rivals.
  void swap() {
    for (std::size_t i = 0; i < out_.accepted.size(); ++i) {
      Accepted& entry = out_.accepted[i];
      Model base = out_.final.model;
      const Chosen own = base.effects[i];
      base.effects.erase(base.effects.begin() + static_cast<std::ptrdiff_t>(i));
      std::vector<Alternative> tried = fit_all(base, replacements(entry), out_.first, entry.alternatives);
      Alternative self{entry.candidate, out_.final, out_.final_heldout};
      tried.push_back(self);
      rank(tried);
      const bool replaced =
          tried.front().candidate != entry.candidate && !at_bound(tried.front()) && leaves_null(tried.front()) &&
          self.heldout.sum() - tried.front().heldout.sum() > noise_unit() && holds_on_conditions(tried.front());
      if (replaced) {
        say(fmt::format("swapped {} for {}", candidate(entry.candidate).title(),
                        candidate(tried.front().candidate).title()));
        Chosen other = tried.front().fit.model.effects.back();
        entry.candidate = other.candidate;
        Model model = tried.front().fit.model;  // the new effect stands last: put it in its predecessor's place
        model.effects.pop_back();
        model.effects.insert(model.effects.begin() + static_cast<std::ptrdiff_t>(i), other);
        out_.final.model = model;
        relinearise();
      }
      const Eigen::VectorXd chosen = out_.final_heldout;
      std::vector<Alternative> others;
      for (Alternative& a : tried) {
        if (a.candidate == entry.candidate) continue;
        const HeldoutGain g = compare(a.heldout, chosen);
        a.behind = g.total;
        a.behind_se = g.standard_error;
        a.similarity = out_.first.similarity(a.candidate, entry.candidate);
        others.push_back(std::move(a));
      }
      std::stable_sort(others.begin(), others.end(),
                       [](const Alternative& a, const Alternative& b) { return a.behind < b.behind; });
      for (Alternative& a : others) a.fit.J.resize(0, 0);
      entry.alternatives = std::move(others);
    }
  }

  /// With everything else refitted, an effect whose own residual contradicts it is no explanation. One without which
  /// predictions would be far worse stays as a description of the data.
  void drop_refuted() {
    for (std::size_t i = 0; i < out_.accepted.size();) {
      const FitResult reduced = without(i);
      const std::string refuted = options_.refuted_by(*out_.around, reduced, out_.final);
      if (refuted.empty()) {
        ++i;
        continue;
      }
      const Eigen::VectorXd energy = heldout_energy(*out_.around, reduced);
      if (compare(energy, out_.final_heldout).total > constants::kStandInShare * energy.sum()) {
        say("contradicted, kept as a description: " + candidate(out_.accepted[i].candidate).title() + ", " + refuted);
        out_.accepted[i].contradicted = refuted;
        ++i;
        continue;
      }
      say("refuted: " + candidate(out_.accepted[i].candidate).title() + ", " + refuted);
      out_.accepted.erase(out_.accepted.begin() + static_cast<std::ptrdiff_t>(i));
      out_.final = reduced;
      relinearise();
      for (Accepted& entry : out_.accepted) entry.contradicted.clear();
      i = 0;
    }
  }

  double left_level(const Eigen::VectorXd& scatter) const {
    return position_error_level(*out_.around, out_.final.r, scatter);
  }

  /// Effects that are chance, by the scatter that everything else leaves. Asked only where more than noise is left, and
  /// named only where no more than noise is left with it: an explanation that is complete, or none.
  void judge_random() {
    constexpr std::uint64_t kStream = 1000;
    if (left_level({}) <= constants::kAdequate) return;
    const std::vector<ScatterScore> scores =
        judge_scatter(*out_.around, out_.final, practical(), Random(options_.seed, kStream));
    if (scores.empty()) return;
    const ScatterScore& best = scores.front();
    const bool measured = best.p_family < constants::kFamilyWise && best.energy > practical() && !best.beyond;
    const double left = measured ? left_level(best.expected) : left_level({});
    const bool stands = measured && best.low > 0.0 && left <= constants::kAdequate;
    say(fmt::format("scatter: {}: score {:.1f}, p {:.3g}, size {:.3g} [{:.3g}, {:.3g}], {:.2f} noise levels left{}",
                    candidate(best.candidate).title(), best.score, best.p_family, best.size, best.low, best.high, left,
                    stands ? ", accepted" : ""));
    if (stands) accept_random(best);
  }

  /// A random effect into the model; accepted effects that stood in for its mean leave it, where predictions lose
  /// nothing.
  void accept_random(const ScatterScore& found) {
    const Candidate& own = candidate(found.candidate);
    std::vector<double> theta = own.probes.front();
    theta.front() = found.size;
    Model model = out_.final.model;
    model.effects.push_back({found.candidate, theta});
    out_.final = fit(*out_.around, model, 4);
    out_.final_heldout = heldout_energy(*out_.around, out_.final);
    for (std::size_t i = 0; i < out_.accepted.size();) {
      const FitResult reduced = without(i);
      const Eigen::VectorXd energy = heldout_energy(*out_.around, reduced);
      const HeldoutGain gain = compare(energy, out_.final_heldout);
      if (!stands_in(candidate(out_.accepted[i].candidate), own) || (gain.lower > 0.0 && gain.total > practical())) {
        ++i;
        continue;
      }
      say("stood in for the mean of " + own.title() + ": " + candidate(out_.accepted[i].candidate).title());
      out_.accepted.erase(out_.accepted.begin() + static_cast<std::ptrdiff_t>(i));
      out_.final = reduced;
      out_.final_heldout = energy;
    }
    Accepted entry;
    entry.candidate = found.candidate;
    entry.p_family = found.p_family;
    entry.low = found.low;
    entry.high = found.high;
    out_.accepted.push_back(std::move(entry));
    if (out_.expected_scatter.size() == 0) out_.expected_scatter = Eigen::VectorXd::Zero(found.expected.size());
    out_.expected_scatter += found.expected;
    relinearise();
    backward();
  }

  static bool stands_in(const Candidate& other, const Candidate& own) {
    const bool known = std::find(own.confounders.begin(), own.confounders.end(), other.effect) != own.confounders.end();
    return known && (other.joints == own.joints || other.joints.size() > own.joints.size());
  }

  /// How much more than noise is left, in the directions of the candidates that are not named.
  double left_over() {
    std::vector<int> open;
    for (std::size_t i = 0; i < library_.candidates.size(); ++i) {
      if (!out_.final.model.has(static_cast<int>(i))) open.push_back(static_cast<int>(i));
    }
    return screen(*out_.around, out_.final.model, out_.final.r, open, Random(options_.seed, 2), &out_.first)
        .mean_square();
  }

  void finish() {
    if (!out_.accepted.empty()) out_.final.covariance = robust_covariance(*out_.around, out_.final, left_over());
    const std::vector<double> sigma = parameter_sigmas(out_.final, library_);
    std::size_t next = 0;
    for (std::size_t i = 0; i < out_.accepted.size(); ++i) {
      Accepted& entry = out_.accepted[i];
      const std::size_t count = candidate(entry.candidate).parameters.size();
      for (std::size_t k = 0; k < count; ++k, ++next) {
        entry.sigma.push_back(sigma[next]);
        entry.at_bound.push_back(out_.final.fixed[next]);
      }
      entry.without = out_.accepted.size() == 1 ? out_.nominal : without(i);
      entry.gain = compare(heldout_energy(*out_.around, entry.without), out_.final_heldout);
      entry.without.J.resize(0, 0);
    }
  }

  Problem& problem_;
  const Library& library_;
  const SelectOptions& options_;
  Selection out_;
};

}  // namespace

Selection select(Problem& problem, const Library& library, const SelectOptions& options) {
  return Search(problem, library, options).run();
}

}  // namespace sanso::diagnose
