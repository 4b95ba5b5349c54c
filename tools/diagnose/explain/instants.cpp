// One instant t for all recordings. Of a shot s that ends before t the error without the effect
// counts, of one that begins after t that with it:
//
//   L(t) = sum over shots of k log(1 + e_s(t) / k)       k: median over shots of the lesser e_s
//
// first at the shots' own ends (two simulations in all), then by halves inside the shots there.
// Interval: L(t) < L(best) + chance and a row; where L crosses it lies between two instants looked
// at, sqrt(L - L(best)) taken for straight there (a parabola's are).
#include "tools/diagnose/explain/instants.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "tools/diagnose/compare/start_elimination.h"
#include "tools/diagnose/explain/whole_time.h"
#include "tools/diagnose/fit/fit.h"
#include "tools/diagnose/fit/normal_equations.h"
#include "tools/diagnose/gate/checks.h"
#include "tools/diagnose/stats/significance.h"

namespace sanso::diagnose {
namespace {

double begins(const Comparison& c, const Shot& s) {
  return c.sources[s.source].drive.t[s.window.first];
}
double ends(const Comparison& c, const Shot& s) {
  return c.sources[s.source].drive.t[s.window.last];
}

/// s; slow recordings have longer shots than the settings say.
double longest_shot(const Comparison& c) {
  double out = 0.0;
  for (const Shot& s : c.shots) out = std::max(out, ends(c, s) - begins(c, s));
  return out;
}

/// What a model leaves by shot, by the instant of one of its effects.
class ByInstant {
 public:
  ByInstant(const Problem& problem, const Library& library, Model model, std::size_t effect,
            std::size_t parameter)
      : problem_(problem), library_(library), model_(std::move(model)) {
    instant_ = &model_.effects[effect].theta[parameter];
  }

  ByInstant(const ByInstant&) = delete;  // instant_ points into model_
  ByInstant& operator=(const ByInstant&) = delete;

  Eigen::VectorXd energy(double instant) { return energy(problem_, instant); }
  /// Of these shots alone.
  Eigen::VectorXd energy(const std::vector<std::size_t>& shots, double instant) {
    return energy(with_shots(problem_, shots), instant);
  }

 private:
  Eigen::VectorXd energy(const Problem& problem, double instant) {
    *instant_ = instant;
    const Problem corrected = step_corrected(problem, library_, model_);
    const StartElimination starts(corrected, library_, model_);
    return starts.energy_by_shot(prediction_error(corrected, library_, model_));
  }

  const Problem& problem_;
  const Library& library_;
  Model model_;
  double* instant_;
};

/// k log(1 + e / k), summed.
double bounded(const Eigen::VectorXd& energy, double unit) {
  return (unit * (1.0 + energy.array() / unit).log()).sum();
}

/// L at every end of a shot, from what is left without the effect and with it.
std::vector<std::pair<double, double>> at_ends(const Comparison& c, const Eigen::VectorXd& without,
                                               const Eigen::VectorXd& with, double unit) {
  std::set<double> instants{0.0};
  for (const Shot& s : c.shots) instants.insert(ends(c, s));
  std::vector<std::pair<double, double>> out;
  for (const double t : instants) {
    Eigen::VectorXd e(without.size());
    for (Eigen::Index s = 0; s < e.size(); ++s) {
      const Shot& shot = c.shots[static_cast<std::size_t>(s)];
      const bool before = ends(c, shot) <= t, after = begins(c, shot) >= t;
      e[s] = before ? without[s] : after ? with[s] : std::min(without[s], with[s]);
    }
    out.emplace_back(t, bounded(e, unit));
  }
  return out;
}

/// Shots that hold a piece of [from, until].
std::vector<std::size_t> shots_in(const Comparison& c, double from, double until) {
  std::vector<std::size_t> out;
  for (std::size_t s = 0; s < c.shots.size(); ++s) {
    if (ends(c, c.shots[s]) > from && begins(c, c.shots[s]) < until) out.push_back(s);
  }
  return out;
}

using Curve = std::vector<std::pair<double, double>>;  // instant, L there

const std::pair<double, double>& least(const Curve& curve) {
  return *std::min_element(curve.begin(), curve.end(),
                           [](const auto& a, const auto& b) { return a.second < b.second; });
}

/// The piece of the curve around its least value that lies below `level`.
std::pair<double, double> piece_below(Curve curve, double level) {
  std::sort(curve.begin(), curve.end());
  const auto best = std::find(curve.begin(), curve.end(), least(curve));
  const auto height = [&](double value) { return std::sqrt(std::max(0.0, value - best->second)); };
  const auto crossing = [&](const auto& inside, const auto& outside) {
    const double below = height(level) - height(inside.second),
                 whole = height(outside.second) - height(inside.second);
    return inside.first + (outside.first - inside.first) * below / whole;
  };
  auto low = best, high = best;
  while (low != curve.begin() && std::prev(low)->second < level) --low;
  while (std::next(high) != curve.end() && std::next(high)->second < level) ++high;
  return {low == curve.begin() ? low->first : crossing(*low, *std::prev(low)),
          std::next(high) == curve.end() ? high->first : crossing(*high, *std::next(high))};
}

/// Moves the k-th parameter of the i-th effect until it stands: a load that began too early was
/// fitted too light.
void place_anew(SearchState& state, std::size_t i, std::size_t k) {
  Selection& found = state.found;
  const double row = gate::sampling_interval(state.problem->sources.front().drive.t);
  double before = std::numeric_limits<double>::infinity();
  while (true) {
    const Instant best =
        best_instant(state.options.whole->problem(), state.library, found.final.model, i, k);
    found.accepted[i].began = {best.low, best.high};
    double& at = found.final.model.effects[i].theta[k];
    const double moves = std::abs(best.at - at);
    if (moves < row || moves >= before) return;
    before = moves;
    state.say(fmt::format("{}: {} {:.4g} s [{:.4g}, {:.4g}], where it was {:.4g} s",
                          state.accepted(i).title(), state.accepted(i).parameters[k].name, best.at,
                          best.low, best.high, at));
    at = best.at;
    found.final = fit(*found.around, found.final.model, state.problem->settings.fitting.iterations);
    state.relinearise();
  }
}

/// d r / d instant [1/s], a column each; its coordinate in the fit, the seconds of one unit there.
struct InstantColumns {
  Eigen::MatrixXd columns;
  std::vector<Eigen::Index> coordinate;
  std::vector<double> typical;
};

InstantColumns derivatives_by_instants(const Surroundings& around, const FitResult& fit) {
  const double row = longest_row(*around.problem);
  InstantColumns out{Eigen::MatrixXd(fit.r.size(), 0), {}, {}};
  Eigen::Index coordinate = 0;
  for (std::size_t i = 0; i < fit.model.effects.size(); ++i) {
    const Candidate& c = (*around.library)[fit.model.effects[i]];
    for (std::size_t k = 0; k < c.parameters.size(); ++k, ++coordinate) {
      const CandidateParameter& p = c.parameters[k];
      const double at = fit.model.effects[i].theta[k];
      if (!is_instant(p) || at_null(p, at)) continue;
      const auto error_at = [&](double instant) {
        Model there = fit.model;
        there.effects[i].theta[k] = instant;
        return prediction_error_near(around.problem, *around.library, there, fit.r, c.joints);
      };
      const double before = std::max(p.low, at - row), after = std::min(p.high, at + row);
      if (after <= before) continue;
      const Eigen::VectorXd by = (error_at(after) - error_at(before)) / (after - before);
      if (by.isZero()) continue;
      out.columns.conservativeResize(Eigen::NoChange, out.columns.cols() + 1);
      out.columns.rightCols(1) = by;
      out.coordinate.push_back(coordinate);
      out.typical.push_back(p.typical);
    }
  }
  return out;
}

}  // namespace

bool is_instant(const CandidateParameter& p) {
  return p.structural &&
         (p.role == Role::event || p.role == Role::instant || p.role == Role::duration);
}

double longest_row(const Comparison& comparison) {
  double out = 0.0;
  for (const Source& s : comparison.sources)
    out = std::max(out, gate::sampling_interval(s.drive.t));
  return out;
}

Eigen::MatrixXd spread_of_instants(const Surroundings& around, const FitResult& fit,
                                   double inflation) {
  const Eigen::Index n = fit.J.cols();
  const InstantColumns by = derivatives_by_instants(around, fit);
  const auto m = static_cast<Eigen::Index>(by.coordinate.size());
  if (m == 0) return Eigen::MatrixXd::Zero(n, n);
  Eigen::MatrixXd all(fit.J.rows(), n + m);
  all << fit.J, by.columns;
  const Eigen::VectorXd weights = around.weights(around.starts.energy_by_shot(fit.r));
  const Eigen::MatrixXd gram = around.starts.gram(all, weights) / std::max(1.0, inflation);
  Eigen::MatrixXd H = gram.topLeftCorner(n, n);
  for (Eigen::Index i = 0; i < n; ++i) H(i, i) += prior(around, fit.parameters, i);
  const auto across = gram.topRightCorner(n, m);
  Eigen::MatrixXd K = -H.ldlt().solve(across);
  Eigen::MatrixXd precision = gram.bottomRightCorner(m, m) + across.transpose() * K;
  precision.diagonal().array() += std::pow(around.settings().data.shot_seconds, -2.0);
  for (Eigen::Index i = 0; i < m; ++i) {
    K.row(by.coordinate[i]).setZero();
    K(by.coordinate[i], i) = 1.0 / by.typical[i];
  }
  return K * precision.ldlt().solve(K.transpose());
}

Instant best_instant(const Problem& everything, const Library& library, const Model& model,
                     std::size_t effect, std::size_t parameter) {
  const Comparison& c = *everything;
  ByInstant left(everything, library, model, effect, parameter);
  const Eigen::VectorXd with = left.energy(0.0), without = left.energy(2.0 * longest_recording(c));
  const Eigen::VectorXd lesser = with.cwiseMin(without);
  const double unit = typical_energy(lesser);
  Curve coarse = at_ends(c, without, with, unit);
  const double around = least(coarse).first, shot = longest_shot(c),
               row = gate::sampling_interval(c.sources.front().drive.t);
  const double from = std::max(0.0, around - 1.5 * shot), until = around + 1.5 * shot;
  const std::vector<std::size_t> near = shots_in(c, from, until);
  Curve fine;
  const auto look = [&](double t) { fine.emplace_back(t, bounded(left.energy(near, t), unit)); };
  const double step = shot / c.settings.data.instant_steps;
  for (double t = from; t <= until; t += step) look(t);
  for (double h = 0.5 * step; h >= row; h *= 0.5) {
    const double t = least(fine).first;
    look(std::max(0.0, t - h)), look(t + h);
  }
  // errors of one shot go together: what a typical shot leaves, over its rows, is one noise
  double rows = 0.0;
  for (const Shot& s : c.shots) rows += static_cast<double>(s.rows);
  const double noise = std::max(1.0, unit * static_cast<double>(c.shots.size()) / rows);
  const double chance = kNormal95 * kNormal95 * noise;
  auto [low, high] = piece_below(fine, least(fine).second + chance);
  const auto [wide_low, wide_high] = piece_below(coarse, least(coarse).second + chance);
  if (low < from + step) low = std::min(low, wide_low);
  if (high > until - step) high = std::max(high, wide_high);
  const double at = least(fine).first;
  return {at < row ? 0.0 : at, std::max(0.0, low - row), high + row};
}

void place_instants_anew(SearchState& state) {
  Selection& found = state.found;
  if (state.options.whole == nullptr) return;
  for (std::size_t i = 0; i < found.accepted.size(); ++i) {
    const Candidate& c = state.accepted(i);
    for (std::size_t k = 0; k < c.parameters.size(); ++k) {
      if (c.parameters[k].role != Role::instant) continue;
      place_anew(state, i, k);
    }
  }
}

}  // namespace sanso::diagnose
