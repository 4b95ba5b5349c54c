// What a fit is worth on data that it did not see: shots left out by one Gauss-Newton step or by
// fitting again, intervals that hold for the parts, gains with a bound that chance leaves.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>

#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/fit/fit.h"
#include "tools/diagnose/fit/normal_equations.h"
#include "tools/diagnose/stats/robust.h"
#include "tools/diagnose/stats/series.h"
#include "tools/diagnose/stats/significance.h"

namespace sanso::diagnose {
namespace {

int group_of(const Shot& shot) { return shot.group; }
int condition_of(const Shot& shot) { return shot.condition; }

/// How a fit moves when a part of the shots is left out: one Gauss-Newton step, exact where the
/// model is linear.
class LeaveOneOut {
 public:
  LeaveOneOut(const Surroundings& around, const FitResult& result, int parts,
              int (*part_of)(const Shot&))
      : around_(around), result_(result), n_(result.J.cols()) {
    grams_ = around.starts.gram_by(with_error(result.J, result.r), parts, part_of,
                                   around.weights(around.starts.energy_by_shot(result.r)));
  }

  /// J' M J of all shots.
  Eigen::MatrixXd gram() const {
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(n_, n_);
    for (const Eigen::MatrixXd& G : grams_) sum += G.topLeftCorner(n_, n_);
    return sum;
  }

  /// Change of the parameters without this part.
  Eigen::VectorXd delta(std::size_t part) const {
    const Eigen::MatrixXd& G = grams_[part];
    Eigen::MatrixXd rest = gram() - G.topLeftCorner(n_, n_);
    // of the part alone; the whole gradient is zero
    Eigen::VectorXd gradient = G.topRightCorner(n_, 1);
    for (Eigen::Index i = 0; i < n_; ++i) {
      rest(i, i) += prior(around_, result_.parameters, i);
      if (!result_.fixed[static_cast<std::size_t>(i)]) continue;
      rest.row(i).setZero();
      rest.col(i).setZero();
      rest(i, i) = 1.0;
      gradient[i] = 0.0;
    }
    return rest.ldlt().solve(gradient);
  }

  /// Delete-one-group variance, widened to Student's 95 % half-width for so few groups over the
  /// normal's (Tukey 1958).
  Eigen::VectorXd jackknife_variance() const {
    const auto parts = static_cast<double>(grams_.size());
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(n_), square = sum;
    for (std::size_t part = 0; part < grams_.size(); ++part) {
      const Eigen::VectorXd d = delta(part);
      sum += d;
      square += d.cwiseAbs2();
    }
    if (parts < 2.0) return Eigen::VectorXd::Zero(n_);
    const double freedom = parts - 1.0;
    // t / 1.96 at 95 %: within 5 % from 2 up
    const double student = 1.0 + 1.4 / freedom + 2.0 / (freedom * freedom);
    return student * student * (parts - 1.0) / parts * (square - sum.cwiseAbs2() / parts);
  }

 private:
  const Surroundings& around_;
  const FitResult& result_;
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
  const Problem& problem = *around.problem;
  const int parts = by_condition ? problem.conditions : problem.groups;
  const auto part_of = by_condition ? condition_of : group_of;
  const LeaveOneOut left_out(around, result, parts, part_of);
  Eigen::VectorXd heldout = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(problem.shots.size()));
  for (int part = 0; part < parts; ++part) {
    const Eigen::VectorXd delta = left_out.delta(static_cast<std::size_t>(part));
    const Eigen::VectorXd energy = around.starts.energy_by_shot(result.r + result.J * delta);
    for (std::size_t s = 0; s < problem.shots.size(); ++s) {
      if (part_of(problem.shots[s]) == part)
        heldout[static_cast<Eigen::Index>(s)] = energy[static_cast<Eigen::Index>(s)];
    }
  }
  return around.bounded(heldout);
}

Eigen::VectorXd refitted_energy(const Surroundings& around, const FitResult& result) {
  const Problem& problem = *around.problem;
  std::vector<Eigen::VectorXd> energy(static_cast<std::size_t>(problem.groups));
  parallel_for(problem.groups, [&](int group) {
    Surroundings rest = around;
    rest.left_out = group;
    const FitResult fitted = fit(rest, result.model, around.settings().fitting.first_iterations);
    energy[static_cast<std::size_t>(group)] =
        around.bounded(around.starts.energy_by_shot(fitted.r));
  });
  Eigen::VectorXd heldout(static_cast<Eigen::Index>(problem.shots.size()));
  for (std::size_t s = 0; s < problem.shots.size(); ++s) {
    const auto i = static_cast<Eigen::Index>(s);
    heldout[i] = energy[static_cast<std::size_t>(problem.shots[s].group)][i];
  }
  return heldout;
}

namespace {
double lower_bound(const DecisionSettings& settings, const std::vector<double>& values) {
  constexpr std::uint64_t kSeed = 4;  // the same comparison has the same bound
  return moving_block_lower_bound(values, settings.gain_level, settings.gain_draws, Random(kSeed));
}
double standard_error(const std::vector<double>& values) {
  return standard_deviation(values) *
         std::sqrt(static_cast<double>(values.size()) * autocorrelation_time(values));
}
}  // namespace

HeldoutGain compare(const DecisionSettings& settings, const Eigen::VectorXd& before,
                    const Eigen::VectorXd& after, const std::vector<int>& occurrence) {
  HeldoutGain gain = compare(settings, before, after);
  std::map<int, double> there;
  std::vector<double> rest;
  for (Eigen::Index i = 0; i < before.size(); ++i) {
    const int which = occurrence[static_cast<std::size_t>(i)];
    if (which < 0) rest.push_back(before[i] - after[i]);
    if (which >= 0) there[which] += before[i] - after[i];
  }
  if (there.empty()) return gain;
  std::vector<double> occurrences;
  for (const auto& [which, removed] : there) occurrences.push_back(removed);
  gain.lower = lower_bound(settings, occurrences) + lower_bound(settings, rest);
  gain.standard_error = std::hypot(standard_error(occurrences), standard_error(rest));
  return gain;
}

HeldoutGain compare(const DecisionSettings& settings, const Eigen::VectorXd& before,
                    const Eigen::VectorXd& after) {
  HeldoutGain gain;
  const Eigen::VectorXd d = before - after;
  std::vector<double> values(d.data(), d.data() + d.size());
  gain.total = d.sum();
  gain.standard_error = standard_error(values);
  gain.lower = lower_bound(settings, values);
  std::sort(values.rbegin(), values.rend());
  double best = 0.0;
  for (std::size_t i = 0; i < std::min<std::size_t>(3, values.size()); ++i)
    best += std::max(0.0, values[i]);
  gain.concentration = gain.total > 0.0 ? std::min(1.0, best / gain.total) : 0.0;
  return gain;
}

}  // namespace sanso::diagnose
