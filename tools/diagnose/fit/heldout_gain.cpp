// What a fit is worth on data that it did not see: shots left out by one Gauss-Newton step or by
// fitting again, intervals that hold for the parts, gains with a bound that chance leaves.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/fit/fit.h"
#include "tools/diagnose/fit/normal_equations.h"
#include "tools/diagnose/fit/quick_fit.h"
#include "tools/diagnose/stats/robust.h"
#include "tools/diagnose/stats/series.h"
#include "tools/diagnose/stats/significance.h"

namespace sanso::diagnose {
namespace {

std::size_t group_of(const Shot& shot) { return shot.group; }
std::size_t condition_of(const Shot& shot) { return shot.condition; }

/// A fit without one part of the shots: one Gauss-Newton step from the full fit, shorter where the
/// shots that are left do not gain from it; a fit of its own where they gain from none.
struct Without {
  Eigen::VectorXd step;    // from the full fit
  Eigen::VectorXd energy;  // by shot, not bounded
};

/// `rest`: surroundings that leave the part out.
Without refit_without(const Surroundings& rest, const FitResult& result,
                      const Eigen::VectorXd& delta) {
  const auto cost = [&](const Model& model, const Eigen::VectorXd& energy) {
    return prior_energy(rest, model) + rest.bounded(energy).sum();
  };
  const auto energy_of = [&](const Eigen::VectorXd& r) { return rest.starts.energy_by_shot(r); };
  const double seen = cost(result.model, energy_of(result.r));
  double least = INFINITY;
  Model best;
  for (const double share : {1.0, 0.5, 0.25}) {
    Model model = moved(rest, result.model, share * delta);
    Eigen::VectorXd energy = energy_of(prediction_error(rest.problem, *rest.library, model));
    const double is = cost(model, energy);
    if (is <= seen) return {share * delta, std::move(energy)};
    if (is < least) least = is, best = std::move(model);
  }
  if (!std::isfinite(least)) best = moved(rest, result.model, 0.25 * delta);
  const QuickFit own = quick_fit(rest, best, rest.settings().fitting.first_iterations);
  return {displacement(rest, result.model, own.model), energy_of(own.r)};
}

/// How a fit moves when a part of the shots is left out: one Gauss-Newton step, exact where the
/// model is linear.
class LeaveOneOut {
 public:
  LeaveOneOut(const Surroundings& around, const FitResult& result, std::size_t parts,
              std::size_t (*part_of)(const Shot&))
      : around_(around),
        result_(result),
        room_(room_to_move(around, result.model)),
        part_of_(part_of),
        n_(result.J.cols()) {
    grams_ = around.starts.gram_by(with_error(result.J, result.r), parts, part_of,
                                   around.weights(around.starts.energy_by_shot(result.r)));
  }

  Without without(std::size_t part) const { return without(part, result_.fixed); }

  /// The numbers in `held` keep what all shots say of them.
  Without without(std::size_t part, std::vector<char> held) const {
    Surroundings rest = around_;
    (part_of_ == condition_of ? rest.left_out_condition : rest.left_out) = part;
    return refit_without(rest, result_, delta(part, std::move(held)));
  }

  /// What is fixed, and the numbers (of effects and of tolerances) that this part alone tells: of
  /// these the other parts can say whether they hold there, and not what they are.
  std::vector<char> told_by(std::size_t part) const {
    Eigen::MatrixXd all = gram();
    all.diagonal() += 1e-9 * all.diagonal() + Eigen::VectorXd::Constant(n_, 1e-12);
    for (Eigen::Index i = 0; i < n_; ++i) all(i, i) += prior(around_, result_.parameters, i);
    const auto variance = [this](const Eigen::MatrixXd& H) {
      return Eigen::VectorXd(H.ldlt().solve(Eigen::MatrixXd::Identity(n_, n_)).diagonal());
    };
    const Eigen::VectorXd with = variance(all);
    const Eigen::VectorXd without = variance(all - grams_[part].topLeftCorner(n_, n_));
    std::vector<char> held = result_.fixed;
    for (Eigen::Index i = 0; i < n_; ++i) {
      if (without[i] > around_.settings().decisions.only_there * with[i]) held[i] = 1;
    }
    return held;
  }

  /// J' M J of all shots.
  Eigen::MatrixXd gram() const {
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(n_, n_);
    for (const Eigen::MatrixXd& G : grams_) sum += G.topLeftCorner(n_, n_);
    return sum;
  }

  /// Change of the parameters without this part: coordinates that would leave their bounds stop
  /// there, and the others take up what they leave.
  Eigen::VectorXd delta(std::size_t part, std::vector<char> held) const {
    const Eigen::MatrixXd& G = grams_[part];
    Eigen::MatrixXd rest = gram() - G.topLeftCorner(n_, n_);
    for (Eigen::Index i = 0; i < n_; ++i) rest(i, i) += prior(around_, result_.parameters, i);
    // of the part alone; the whole gradient is zero
    const Eigen::VectorXd gradient = G.topRightCorner(n_, 1);
    Eigen::VectorXd step = Eigen::VectorXd::Zero(n_);
    for (Eigen::Index round = 0; round <= n_; ++round) {
      step = solve_with_held(rest, gradient, held, step);
      if (!hold_at_bounds(step, held)) break;
    }
    return step;
  }

  /// Delete-one-group variance, widened to Student's 95 % half-width for so few groups over the
  /// normal's (Tukey 1958).
  Eigen::VectorXd jackknife_variance() const {
    const auto parts = static_cast<double>(grams_.size());
    if (parts < 2.0) return Eigen::VectorXd::Zero(n_);
    std::vector<Eigen::VectorXd> steps(grams_.size());
    parallel_for(grams_.size(), [&](std::size_t part) { steps[part] = without(part).step; });
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(n_), square = sum;
    for (const Eigen::VectorXd& d : steps) {
      sum += d;
      square += d.cwiseAbs2();
    }
    const double freedom = parts - 1.0;
    // t / 1.96 at 95 %: within 5 % from 2 up
    const double student = 1.0 + 1.4 / freedom + 2.0 / (freedom * freedom);
    return student * student * (parts - 1.0) / parts * (square - sum.cwiseAbs2() / parts);
  }

 private:
  /// H step = g with the entries of `step` that are held kept as they are.
  static Eigen::VectorXd solve_with_held(Eigen::MatrixXd H, Eigen::VectorXd g,
                                         const std::vector<char>& held,
                                         const Eigen::VectorXd& step) {
    for (Eigen::Index i = 0; i < g.size(); ++i) {
      if (held[i]) g -= H.col(i) * step[i];
    }
    for (Eigen::Index i = 0; i < g.size(); ++i) {
      if (!held[i]) continue;
      H.row(i).setZero();
      H.col(i).setZero();
      H(i, i) = 1.0;
      g[i] = step[i];
    }
    return H.ldlt().solve(g);
  }

  /// Stops what leaves its bounds there; false: nothing does.
  bool hold_at_bounds(Eigen::VectorXd& step, std::vector<char>& held) const {
    bool any = false;
    for (Eigen::Index i = 0; i < step.size(); ++i) {
      const double inside = std::clamp(step[i], room_(i, 0), room_(i, 1));
      if (held[i] || inside == step[i]) continue;
      step[i] = inside;
      held[i] = 1;
      any = true;
    }
    return any;
  }

  const Surroundings& around_;
  const FitResult& result_;
  Eigen::MatrixXd room_;  // n x 2: how far a coordinate may move
  std::size_t (*part_of_)(const Shot&);
  Eigen::Index n_;
  std::vector<Eigen::MatrixXd> grams_;
};

}  // namespace

Eigen::MatrixXd robust_covariance(const Surroundings& around, const FitResult& result,
                                  double inflation) {
  const LeaveOneOut left_out(around, result, around.problem->groups, group_of);
  const Eigen::Index n = result.J.cols();
  Eigen::MatrixXd H = left_out.gram() / std::max(1.0, inflation);
  for (Eigen::Index i = 0; i < n; ++i) {
    H(i, i) += prior(around, result.parameters, i);
    const bool structural = i < result.parameters && H(i, i) < 1e-5;  // moves nothing: no interval
    if (!structural) continue;
    H.row(i).setZero();
    H.col(i).setZero();
    H(i, i) = 1.0;
  }
  Eigen::MatrixXd covariance = H.ldlt().solve(Eigen::MatrixXd::Identity(n, n));
  Eigen::VectorXd spread = left_out.jackknife_variance();
  // a formula that is a little wrong gives each condition its own value; two conditions say too
  // little about that
  if (around.problem->conditions >= 3) {
    spread = spread.cwiseMax(
        LeaveOneOut(around, result, around.problem->conditions, condition_of).jackknife_variance());
  }
  Eigen::VectorXd stretch = Eigen::VectorXd::Ones(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    if (covariance(i, i) > 0.0) stretch[i] = std::sqrt(std::max(1.0, spread[i] / covariance(i, i)));
  }
  return stretch.asDiagonal() * covariance * stretch.asDiagonal();
}

Eigen::VectorXd heldout_energy(const Surroundings& around, const FitResult& result,
                               bool by_condition) {
  const Problem& problem = around.problem;
  const std::size_t parts = by_condition ? problem->conditions : problem->groups;
  const auto part_of = by_condition ? condition_of : group_of;
  const LeaveOneOut left_out(around, result, parts, part_of);
  Eigen::VectorXd heldout = Eigen::VectorXd::Zero(problem->shots.size());
  parallel_for(parts, [&](std::size_t part) {
    const Eigen::VectorXd energy = by_condition
                                       ? left_out.without(part, left_out.told_by(part)).energy
                                       : left_out.without(part).energy;
    for (std::size_t s = 0; s < problem->shots.size(); ++s) {
      if (part_of(problem->shots[s]) == part) heldout[s] = energy[s];
    }
  });
  return around.bounded(heldout);
}

Eigen::VectorXd refitted_energy(const Surroundings& around, const FitResult& result) {
  const Problem& problem = around.problem;
  std::vector<Eigen::VectorXd> energy(problem->groups);
  parallel_for(problem->groups, [&](std::size_t group) {
    Surroundings rest = around;
    rest.left_out = group;
    const QuickFit fitted =
        quick_fit(rest, result.model, around.settings().fitting.first_iterations);
    energy[group] = around.bounded(around.starts.energy_by_shot(fitted.r));
  });
  Eigen::VectorXd heldout(problem->shots.size());
  for (std::size_t s = 0; s < problem->shots.size(); ++s) {
    heldout[s] = energy[problem->shots[s].group][s];
  }
  return heldout;
}

namespace {

using Values = std::vector<double>;

double sum(const Values& x) { return std::accumulate(x.begin(), x.end(), 0.0); }

/// Of which recording a shot is, and which occurrence of an effect, if any.
struct Place {
  std::size_t recording = 0;
  std::optional<std::size_t> occurrence = {};
};

/// `x` recording by recording, in their order; recordings of very few shots are one together: alone
/// they cannot tell how much they scatter.
std::vector<Values> by_recording(const DecisionSettings& settings,
                                 const std::vector<std::pair<std::size_t, double>>& x) {
  std::map<std::size_t, Values> of;
  for (const auto& [recording, value] : x) of[recording].push_back(value);
  std::vector<Values> out;
  Values few;
  for (auto& [recording, values] : of) {
    if (std::cmp_less(values.size(), settings.fewest_shots))
      few.insert(few.end(), values.begin(), values.end());
    else
      out.push_back(std::move(values));
  }
  if (!few.empty()) out.push_back(std::move(few));
  return out;
}

Paired paired(const DecisionSettings& settings, const std::vector<Values>& strata) {
  constexpr std::uint64_t kSeed = 4;  // the same comparison has the same bound
  Values all;
  for (const Values& x : strata) all.insert(all.end(), x.begin(), x.end());
  const double independent = static_cast<double>(all.size()) * autocorrelation_time(all);
  return {sum(all), standard_deviation(all) * std::sqrt(independent),
          stratified_lower_bound(strata, settings.gain_level / kGainMeasures, settings.gain_draws,
                                 Random(kSeed))};
}

/// Shots of one occurrence are taken together, and apart from all others.
Paired paired(const DecisionSettings& settings, const Values& x, const std::vector<Place>& places) {
  std::map<std::size_t, double> there;
  std::vector<std::pair<std::size_t, double>> rest;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (places[i].occurrence)
      there[*places[i].occurrence] += x[i];
    else
      rest.emplace_back(places[i].recording, x[i]);
  }
  const Paired b = paired(settings, by_recording(settings, rest));
  if (there.empty()) return b;
  Values occurrences;
  for (const auto& [which, gained] : there) occurrences.push_back(gained);
  const Paired a = paired(settings, {occurrences});
  return {a.total + b.total, std::hypot(a.standard_error, b.standard_error), a.lower + b.lower};
}

Values differences(const Eigen::VectorXd& before, const Eigen::VectorXd& after) {
  const Eigen::VectorXd d = before - after;
  return {d.data(), d.data() + d.size()};
}

Values bounded_differences(const Eigen::VectorXd& before, const Eigen::VectorXd& after,
                           double unit) {
  Values out;
  for (Eigen::Index i = 0; i < before.size(); ++i)
    out.push_back(unit * std::log((unit + before[i]) / (unit + after[i])));
  return out;
}

/// Signs of `x` times the ranks of their sizes, over the sum of all ranks.
Values signed_ranks(const Values& x) {
  std::vector<std::size_t> order(x.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return std::abs(x[a]) < std::abs(x[b]); });
  const auto n = static_cast<double>(x.size());
  Values out(x.size(), 0.0);
  for (std::size_t k = 0; k < order.size(); ++k) {
    const double value = x[order[k]];
    const double rank = (static_cast<double>(k) + 1.0) / (0.5 * n * (n + 1.0));
    if (value != 0.0) out[order[k]] = std::copysign(rank, value);
  }
  return out;
}

/// Share of a sum that its three largest entries give.
double concentration(Values removed) {
  const double total = sum(removed);
  std::sort(removed.rbegin(), removed.rend());
  double best = 0.0;
  for (std::size_t i = 0; i < std::min<std::size_t>(3, removed.size()); ++i)
    best += std::max(0.0, removed[i]);
  return total > 0.0 ? std::min(1.0, best / total) : 0.0;
}

}  // namespace

double HeldoutGain::certainty() const {
  constexpr double kUnit = 2.0;  // of energy: one of log-likelihood
  const auto of = [](const Paired& p) {
    return (p.total - kUnit) / std::max(p.standard_error, 1e-9);
  };
  return std::max(of(energy), of(bounded));
}

double typical_energy(const Eigen::VectorXd& energy) {
  return std::max(median(Values(energy.data(), energy.data() + energy.size())), 1e-9);
}

double bounded_energy(const Eigen::VectorXd& energy, double unit) {
  return unit * ((energy.array() + unit) / unit).log().sum();
}

namespace {

HeldoutGain compare(const DecisionSettings& settings, const Eigen::VectorXd& before,
                    const Eigen::VectorXd& after, const std::vector<Place>& places) {
  const double unit = typical_energy(0.5 * (before + after));
  const Values removed = differences(before, after);
  HeldoutGain gain;
  gain.energy = paired(settings, removed, places);
  gain.bounded = paired(settings, bounded_differences(before, after, unit), places);
  gain.ranks = paired(settings, signed_ranks(removed), places);
  gain.whole = bounded_energy(before, unit);
  gain.concentration = concentration(removed);
  return gain;
}

}  // namespace

HeldoutGain compare(const DecisionSettings& settings, const Eigen::VectorXd& before,
                    const Eigen::VectorXd& after) {
  return compare(settings, before, after,
                 std::vector<Place>(static_cast<std::size_t>(before.size())));
}

HeldoutGain compare(const Comparison& comparison, const Eigen::VectorXd& before,
                    const Eigen::VectorXd& after) {
  return compare(comparison, before, after,
                 std::vector<std::optional<std::size_t>>(comparison.shots.size()));
}

HeldoutGain compare(const Comparison& comparison, const Eigen::VectorXd& before,
                    const Eigen::VectorXd& after,
                    const std::vector<std::optional<std::size_t>>& occurrence) {
  std::vector<Place> places;
  for (std::size_t s = 0; s < comparison.shots.size(); ++s)
    places.push_back({comparison.shots[s].source, occurrence[s]});
  return compare(comparison.settings.decisions, before, after, places);
}

}  // namespace sanso::diagnose
