#include "tools/diagnose/explain/select.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/diagnose/explain/events.h"
#include "tools/diagnose/explain/incidence.h"
#include "tools/diagnose/explain/losses.h"
#include "tools/diagnose/explain/scatter.h"
#include "tools/diagnose/explain/untie.h"

namespace sanso::diagnose {
namespace {

/// One state of the search.
class Search {
 public:
  Search(Problem& problem, const Library& library, const SelectOptions& options)
      : problem_(problem), library_(library), options_(options), regimes_(find_regimes(problem)) {}

  Selection run() {
    start();
    for (int step = 0; step < settings().decisions.maximum_effects; ++step) {
      if (!forward(step)) break;
      if (out_.accepted.size() > 1) backward();
      untie();
    }
    swap();
    drop_refuted();
    judge_random();
    finish();
    return std::move(out_);
  }

 private:
  const Settings& settings() const { return problem_.settings; }
  const Candidate& candidate(int i) const {
    return library_.candidates[static_cast<std::size_t>(i)];
  }

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
    out_.first = screen(*out_.around, Model{}, r, all, Random(options_.seed, 1), nullptr, {},
                        options_.keep_groups);
    calibrate(out_.first);
    say(fmt::format("screened {} candidates ({} signatures), error level {}, critical score {:.2f}",
                    all.size(), out_.first.probes.size(), error_levels(), out_.first.critical));
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
    for (std::size_t c = 0; c < problem_.channels.size(); ++c)
      problem_.channels[c].sigma = screening.channel_sigma[c];
    relinearise();
  }

  double practical() const { return practical_energy(problem_); }
  double whole() const { return std::max(out_.nominal_heldout.sum(), 1e-9); }

  /// By shot: which occurrence of an effect that acts at one instant it belongs to, one a
  /// recording; -1: none.
  std::vector<int> occurrences(const Chosen& effect) const {
    const Candidate& c = candidate(effect.candidate);
    std::vector<int> out(problem_.shots.size(), -1);
    for (std::size_t p = 0; p < c.parameters.size(); ++p) {
      if (c.parameters[p].role != Role::event) continue;
      for (std::size_t s = 0; s < out.size(); ++s) {
        const Shot& shot = problem_.shots[s];
        if (near_instant(problem_, shot, effect.theta[p])) out[s] = shot.source;
      }
    }
    return out;
  }

  /// What `effect` removes on held-out shots.
  HeldoutGain gain_of(const Chosen& effect, const Eigen::VectorXd& without,
                      const Eigen::VectorXd& with) const {
    return compare(settings().decisions, without, with, occurrences(effect));
  }

  /// Empty when the alternative may be accepted over the current model; else the gate that it
  /// fails. `refutable`: also the residual that it should have changed.
  std::string refused_by(const Alternative& a, bool refutable) const {
    const HeldoutGain gain = gain_of(a.fit.model.effects.back(), out_.final_heldout, a.heldout);
    if (gain.lower <= 0.0) return "held-out gain not beyond chance";
    if (gain.total < practical()) return "changes predictions by less than what matters";
    if (gain.total < settings().decisions.minimum_share * whole())
      return "removes less than 1 % of the error";
    if (!leaves_null(settings().decisions, library_, a)) return "interval contains the null";
    if (!holds_on_conditions(a)) return "worse on conditions left out";
    if (!settles_its_event(a)) return "leaves errors far above noise at its instant";
    if (refutable) return residual_against(out_.final, a.fit);
    return "";
  }

  /// What acts at one instant only has to explain that instant: any blow takes something from any
  /// jerk.
  bool settles_its_event(const Alternative& a) const {
    const std::vector<int> occurrence = occurrences(a.fit.model.effects.back());
    const auto energy = [&](const Eigen::VectorXd& r) {
      double sum = 0.0;
      for (const Event& e : find_events(problem_, out_.around->starts.project(r)))
        sum += occurrence[e.shot] >= 0 ? e.excess : 0.0;
      return sum;
    };
    return energy(a.fit.r) <= settings().decisions.minimum_share * energy(out_.final.r);
  }

  bool holds_on_conditions(const Alternative& a) const {
    if (problem_.conditions < 2) return true;
    const HeldoutGain gain =
        compare(settings().decisions, heldout_energy(*out_.around, out_.final, true),
                heldout_energy(*out_.around, a.fit, true));
    return gain.total > -gain.standard_error;
  }

  bool forward(int step) {
    std::vector<int> open;
    for (std::size_t i = 0; i < library_.candidates.size(); ++i) {
      if (!out_.final.model.has(static_cast<int>(i))) open.push_back(static_cast<int>(i));
    }
    Screening screening = step == 0 ? out_.first
                                    : screen(*out_.around, out_.final.model, out_.final.r, open,
                                             Random(options_.seed, 10 + step), &out_.first,
                                             out_.final.J.leftCols(out_.final.parameters));
    if (step > 0) calibrate(screening);
    const std::vector<int> which =
        rivals(settings(), library_, screening,
               std::max(practical(), settings().decisions.minimum_share * whole()));
    if (which.empty()) {
      say(fmt::format(
          "step {}: no candidate stands out (strongest score {:.2f}, critical {:.2f})", step + 1,
          screening.probes.empty() ? 0.0 : screening.best(screening.ranking().front())->score,
          screening.critical));
      return false;
    }
    std::vector<Alternative> fitted =
        fit_all(*out_.around, out_.final.model, out_.final.objective, which, screening);
    rank(library_, problem_, fitted);
    // first those inside their bounds that no residual contradicts; one of two missing effects may
    // look contradicted
    for (const auto& [bounds_allowed, refutable] :
         {std::pair{false, true}, {false, false}, {true, true}}) {
      for (std::size_t i = 0; i < fitted.size(); ++i) {
        if (at_bound(library_, fitted[i]) != bounds_allowed) continue;
        const std::string refused = refused_by(fitted[i], refutable);
        const HeldoutGain gain =
            gain_of(fitted[i].fit.model.effects.back(), out_.final_heldout, fitted[i].heldout);
        say(fmt::format("step {}: {}: held-out gain {:.1f} % of the error (at least {:.1f}){}{}",
                        step + 1, candidate(fitted[i].candidate).title(),
                        100 * gain.total / whole(), 100 * gain.lower / whole(),
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
    // 0.1 GB each on twelve joints, and done with
    for (Alternative& a : fitted) a.fit.J.resize(0, 0);
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
    out_.nominal = out_.accepted.empty()
                       ? out_.final
                       : fit(*out_.around, Model{{}, out_.nominal.model.nuisance}, 1);
    out_.nominal_heldout = heldout_energy(*out_.around, out_.nominal);
    out_.final_heldout = heldout_energy(*out_.around, out_.final);
  }

  FitResult without(std::size_t index) const {
    Model model = out_.final.model;
    model.effects.erase(model.effects.begin() + static_cast<std::ptrdiff_t>(index));
    return fit(*out_.around, model, 4);
  }

  /// Drops what the others have made superfluous; the effect accepted last was judged just now.
  void backward(std::size_t just_judged = 1) {
    for (std::size_t i = 0; i + just_judged < out_.accepted.size();) {
      if (candidate(out_.accepted[i].candidate)
              .random) {  // needed for the scatter, whatever its mean gains
        ++i;
        continue;
      }
      const FitResult reduced = without(i);
      const HeldoutGain gain = gain_of(out_.final.model.effects[i],
                                       heldout_energy(*out_.around, reduced), out_.final_heldout);
      const bool needed = gain.lower > 0.0 && gain.total > practical() &&
                          gain.total > settings().decisions.minimum_share * whole();
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

  /// Tied effects and what takes them back at some of their joints, each joint for itself; all of
  /// them have to be needed.
  void untie() {
    for (const Untied& u :
         untied(library_, out_.final.model, settings().decisions.maximum_effects)) {
      std::optional<FitResult> apart = fit_untied(*out_.around, u, out_.final);
      say(fmt::format("untie {}: {}",
                      candidate(out_.final.model.effects[u.replaced.front()].candidate).title(),
                      apart ? "accepted" : "refused, predicts worse"));
      if (!apart) continue;
      replace(u, std::move(*apart));
      backward(0);
      return;
    }
  }

  void replace(const Untied& u, FitResult apart) {
    double p_family = 0.0;
    for (const std::size_t i : u.replaced) p_family = std::max(p_family, out_.accepted[i].p_family);
    std::vector<Accepted> accepted;
    for (const std::size_t i : u.stay) accepted.push_back(std::move(out_.accepted[i]));
    for (std::size_t i = u.stay.size(); i < u.model.effects.size(); ++i) {
      Accepted entry;
      entry.candidate = u.model.effects[i].candidate;
      entry.p_family = p_family;
      accepted.push_back(std::move(entry));
    }
    out_.accepted = std::move(accepted);
    out_.final = std::move(apart);
    relinearise();
  }

  /// Every accepted effect against its rivals, everything else refitted; the better one stays, the
  /// others are kept as rivals.
  void swap() {
    for (std::size_t i = 0; i < out_.accepted.size(); ++i) {
      Accepted& entry = out_.accepted[i];
      Model base = out_.final.model;
      const Chosen own = base.effects[i];
      base.effects.erase(base.effects.begin() + static_cast<std::ptrdiff_t>(i));
      const std::vector<int> which =
          replacements(settings().decisions, library_, out_.first, out_.final.model,
                       entry.candidate, entry.alternatives);
      std::vector<Alternative> tried =
          fit_all(*out_.around, base, out_.final.objective, which, out_.first, entry.alternatives);
      Alternative self{entry.candidate, out_.final, out_.final_heldout};
      tried.push_back(self);
      rank(library_, problem_, tried);
      const bool replaced = tried.front().candidate != entry.candidate &&
                            !tried.front().far_behind && !at_bound(library_, tried.front()) &&
                            leaves_null(settings().decisions, library_, tried.front()) &&
                            self.heldout.sum() - tried.front().heldout.sum() > kNoiseUnit &&
                            holds_on_conditions(tried.front());
      if (replaced) {
        say(fmt::format("swapped {} for {}", candidate(entry.candidate).title(),
                        candidate(tried.front().candidate).title()));
        Chosen other = tried.front().fit.model.effects.back();
        entry.candidate = other.candidate;
        // the new effect stands last: put it in its predecessor's place
        Model model = tried.front().fit.model;
        model.effects.pop_back();
        model.effects.insert(model.effects.begin() + static_cast<std::ptrdiff_t>(i), other);
        out_.final.model = model;
        relinearise();
      }
      const Eigen::VectorXd chosen = out_.final_heldout;
      std::vector<Alternative> others;
      for (Alternative& a : tried) {
        if (a.candidate == entry.candidate) continue;
        const HeldoutGain g = gain_of(out_.final.model.effects[i], a.heldout, chosen);
        a.behind = g.total;
        a.behind_se = g.standard_error;
        a.similarity = out_.first.similarity(a.candidate, entry.candidate);
        others.push_back(std::move(a));
      }
      std::stable_sort(
          others.begin(), others.end(),
          [](const Alternative& a, const Alternative& b) { return a.behind < b.behind; });
      for (Alternative& a : others) a.fit.J.resize(0, 0);
      entry.alternatives = std::move(others);
    }
  }

  /// With everything else refitted, an effect whose own residual contradicts it is no explanation.
  /// One without which predictions would be far worse stays as a description of the data.
  /// The residual that what `with` adds to `without` should have changed and did not; empty: none.
  std::string residual_against(const FitResult& without, const FitResult& with) const {
    return refuted_by(incidence(*out_.around, regimes_, without, with));
  }

  void drop_refuted() {
    for (std::size_t i = 0; i < out_.accepted.size();) {
      const FitResult reduced = without(i);
      const std::string refuted = residual_against(reduced, out_.final);
      if (refuted.empty()) {
        ++i;
        continue;
      }
      const Eigen::VectorXd energy = heldout_energy(*out_.around, reduced);
      if (compare(settings().decisions, energy, out_.final_heldout).total >
          settings().decisions.stand_in_share * energy.sum()) {
        say("contradicted, kept as a description: " +
            candidate(out_.accepted[i].candidate).title() + ", " + refuted);
        out_.accepted[i].contradicted = refuted;
        ++i;
        continue;
      }
      say("refuted: " + candidate(out_.accepted[i].candidate).title() + ", " + refuted);
      out_.refuted.push_back(candidate(out_.accepted[i].candidate).title() + " (" + refuted + ")");
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

  /// Effects that are chance, by the scatter that everything else leaves. Asked only where more
  /// than noise is left, and named only where no more than noise is left with it: an explanation
  /// that is complete, or none.
  void judge_random() {
    constexpr std::uint64_t kStream = 1000;
    if (judge_losses()) return;
    if (left_level({}) <= settings().decisions.adequate) return;
    const std::vector<ScatterScore> scores =
        judge_scatter(*out_.around, out_.final, practical(), Random(options_.seed, kStream));
    const ScatterScore* best = nullptr;
    // to noise alone: a chance that would scatter more than was seen is none either
    double closest = INFINITY;
    for (const ScatterScore& one : scores) {
      const bool measured = one.p_family < settings().decisions.family_wise &&
                            one.energy > practical() && !one.beyond;
      const double left = std::isfinite(one.left) ? one.left : left_level({});
      say(fmt::format(
          "scatter: {}: score {:.1f}, p {:.3g}, size {:.3g} [{:.3g}, {:.3g}], {:.2f} noise levels "
          "left",
          candidate(one.candidate).title(), one.score, one.p_family, one.size, one.low, one.high,
          left));
      const double from_noise = std::abs(std::log(std::max(left, 1e-3)));
      if (measured && one.low > 0.0 && from_noise < closest) best = &one, closest = from_noise;
    }
    if (best != nullptr && closest <= std::log(settings().decisions.adequate)) accept_random(*best);
  }

  /// Lost commands, one by one: named when what they explain matters and no more than noise is left
  /// with them. True when they were.
  bool judge_losses() {
    const LossScore found = find_losses(*out_.around, out_.final);
    if (found.candidate < 0) return false;
    const CandidateParameter& parameter = candidate(found.candidate).parameters.front();
    const char* refused =
        !found.blind ? "refused: chance does not choose what shows little"
        : found.misfit > settings().decisions.standard_errors ? "refused: losses are whole"
        : found.left > settings().decisions.adequate          ? "refused: more than noise is left"
        : found.energy <= practical() ? "refused: changes less than what matters"
        : found.low <= parameter.null || found.size >= parameter.high ? "refused: ends at a bound"
                                                                      : "";
    const bool named = *refused == 0;
    say(fmt::format(
        "lost commands: {}: {} found, {} of {} that would show: {:.3g} [{:.3g}, {:.3g}], p "
        "{:.3g}, misfit "
        "{:.2f}, {:.2f} noise levels left, {}",
        candidate(found.candidate).title(), found.lost.size(), found.seen, found.visible,
        found.size, found.low, found.high, found.p_family, found.misfit, found.left,
        named ? "accepted" : refused));
    if (!named) return false;
    ScatterScore s;
    s.candidate = found.candidate;
    s.size = found.size;
    s.low = found.low;
    s.high = found.high;
    s.p_family = found.p_family;
    accept_random(s);
    const Eigen::VectorXd projected = out_.around->starts.project(out_.final.r);
    out_.expected_scatter +=
        (projected.cwiseAbs2() - in_search_levels(found.repaired).cwiseAbs2()).cwiseMax(0.0);
    return true;
  }

  /// Errors in noise levels, divided as the search divides them.
  Eigen::VectorXd in_search_levels(Eigen::VectorXd r) const {
    for (const Shot& shot : problem_.shots) {
      for (std::size_t c = 0; c < problem_.channels.size(); ++c) {
        r.segment(static_cast<Eigen::Index>(shot.offset + c * shot.rows),
                  static_cast<Eigen::Index>(shot.rows)) *=
            problem_.channels[c].floor / problem_.channels[c].sigma;
      }
    }
    return r;
  }

  /// A random effect into the model; accepted effects that stood in for its mean leave it, where
  /// predictions lose nothing.
  void accept_random(const ScatterScore& found) {
    const Candidate& own = candidate(found.candidate);
    std::vector<double> theta = own.probes.front();
    theta.front() = found.size;
    Model model = out_.final.model;
    model.effects.push_back({found.candidate, theta});
    resmooth(problem_, jitter_of(problem_, library_, model));
    out_.around = make_surroundings(problem_, library_, model);
    out_.final = fit(*out_.around, model, 4);
    out_.final_heldout = heldout_energy(*out_.around, out_.final);
    for (std::size_t i = 0; i < out_.accepted.size();) {
      const FitResult reduced = without(i);
      const Eigen::VectorXd energy = heldout_energy(*out_.around, reduced);
      const HeldoutGain gain = compare(settings().decisions, energy, out_.final_heldout);
      if (!stands_in(candidate(out_.accepted[i].candidate), own) ||
          (gain.lower > 0.0 && gain.total > practical())) {
        ++i;
        continue;
      }
      say("stood in for the mean of " + own.title() + ": " +
          candidate(out_.accepted[i].candidate).title());
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
    if (out_.expected_scatter.size() == 0)
      out_.expected_scatter = Eigen::VectorXd::Zero(out_.final.r.size());
    if (found.expected.size() > 0) out_.expected_scatter += found.expected;
    relinearise();
    backward();
  }

  static bool stands_in(const Candidate& other, const Candidate& own) {
    const bool known = std::find(own.confounders.begin(), own.confounders.end(), other.effect) !=
                       own.confounders.end();
    return known && (other.joints == own.joints || other.joints.size() > own.joints.size());
  }

  /// How much more than noise is left, in the directions of the candidates that are not named.
  double left_over() {
    std::vector<int> open;
    for (std::size_t i = 0; i < library_.candidates.size(); ++i) {
      if (!out_.final.model.has(static_cast<int>(i))) open.push_back(static_cast<int>(i));
    }
    return screen(*out_.around, out_.final.model, out_.final.r, open, Random(options_.seed, 2),
                  &out_.first)
        .mean_square();
  }

  void finish() {
    if (!out_.accepted.empty())
      out_.final.covariance = robust_covariance(*out_.around, out_.final, left_over());
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
      entry.gain = gain_of(out_.final.model.effects[i], heldout_energy(*out_.around, entry.without),
                           out_.final_heldout);
      entry.without.J.resize(0, 0);
    }
  }

  Problem& problem_;
  const Library& library_;
  const SelectOptions& options_;
  const Regimes regimes_;  // of the recorded motion
  Selection out_;
};

}  // namespace

Selection select(Problem& problem, const Library& library, const SelectOptions& options) {
  return Search(problem, library, options).run();
}

}  // namespace sanso::diagnose
