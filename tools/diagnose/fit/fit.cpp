// Gauss-Newton on whitened errors with starts eliminated: (J' M J + prior) delta = J' M r, damped
// until the bounded objective falls, inside the bounds of the library.
#include "tools/diagnose/fit/fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/fit/normal_equations.h"
#include "tools/diagnose/fit/quick_fit.h"

namespace sanso::diagnose {

namespace {

/// A model's free numbers in the fit's coordinates: effect parameters / typical, then nuisances /
/// tolerance.
class Coordinates {
 public:
  Coordinates(const Surroundings& around, const Model& shape)
      : library_(around.library), reach_(around.settings().tolerances.reach), shape_(shape) {
    const Library& library = *library_;
    shape_.nuisance.resize(library.nuisances.size(), 0.0);
    for (const Chosen& c : shape_.effects) {
      for (const CandidateParameter& p : library[c].parameters) {
        parameters_.push_back(p);
        joints_.push_back(&library[c].joints);
      }
    }
  }
  Eigen::Index effects() const { return parameters_.size(); }
  Eigen::Index size() const { return effects() + library_->nuisances.size(); }
  const CandidateParameter& parameter(Eigen::Index i) const { return parameters_[i]; }
  /// The joints that effect parameter i acts on; empty: the whole robot.
  const std::vector<std::size_t>& joints(Eigen::Index i) const { return *joints_[i]; }

  Eigen::VectorXd of(const Model& model) const {
    Eigen::VectorXd x = Eigen::VectorXd::Zero(size());
    Eigen::Index i = 0;
    for (const Chosen& c : model.effects) {
      for (double v : c.theta) x[i] = v / parameter(i).typical, ++i;
    }
    for (std::size_t k = 0; k < model.nuisance.size(); ++k)
      x[i++] = model.nuisance[k] / library_->nuisances[k].tolerance;
    return x;
  }
  Model model(const Eigen::VectorXd& x) const {
    Model m = shape_;
    Eigen::Index i = 0;
    for (Chosen& c : m.effects) {
      for (double& v : c.theta) v = x[i] * parameter(i).typical, ++i;
    }
    for (std::size_t k = 0; k < m.nuisance.size(); ++k)
      m.nuisance[k] = x[i++] * library_->nuisances[k].tolerance;
    return m;
  }
  double low(Eigen::Index i) const {
    if (i < effects()) return parameter(i).low / parameter(i).typical;
    return -reach_;
  }
  double high(Eigen::Index i) const {
    return i < effects() ? parameter(i).high / parameter(i).typical : reach_;
  }
  Eigen::VectorXd inside(Eigen::VectorXd x) const {
    for (Eigen::Index i = 0; i < x.size(); ++i) x[i] = std::clamp(x[i], low(i), high(i));
    return x;
  }

 private:
  const Library* library_;
  double reach_;
  Model shape_;
  std::vector<CandidateParameter> parameters_;
  std::vector<const std::vector<std::size_t>*> joints_;
};

/// By shot, not 0: the fit sees it (or, not `seen`, does not); empty: none is left out.
std::vector<char> shots_of(const Surroundings& around, bool seen) {
  std::vector<char> out;
  if (!around.left_out && !around.left_out_condition) return out;
  for (const Shot& shot : around.problem->shots) out.push_back(around.leaves_out(shot) != seen);
  return out;
}

/// What the model at x remembers, where some of the models that it is compared with remember the
/// same.
template <class Moved>
std::optional<Remembered> remembered(const Surroundings& around, const Coordinates& coordinates,
                                     const Eigen::VectorXd& x, const Moved& moved,
                                     const std::vector<char>& shots) {
  const Model here = coordinates.model(x);
  for (Eigen::Index i = 0; i < coordinates.effects(); ++i) {
    if (!coordinates.parameter(i).structural &&
        remember_alike(around.problem, *around.library, here, moved(i)))
      return std::optional<Remembered>(std::in_place, around.problem, *around.library, here, shots);
  }
  return std::nullopt;
}

/// d r / d x at x: effects by differences inside the box, nuisances from the surroundings. `shots`:
/// the only ones that are wanted, all others are 0; empty: all.
Eigen::MatrixXd jacobian(const Surroundings& around, const Coordinates& coordinates,
                         const Eigen::VectorXd& x, const Eigen::VectorXd& r,
                         const std::vector<char>& shots = {}) {
  Eigen::MatrixXd J(r.size(), coordinates.size());
  J.rightCols(around.A.cols()) = around.A;
  const double length = around.settings().fitting.derivative_step;
  const auto step_of = [&](Eigen::Index i) {
    return x[i] + length <= coordinates.high(i) ? length : -length;
  };
  const auto moved = [&](Eigen::Index i) {
    Eigen::VectorXd there = x;
    there[i] += step_of(i);
    return coordinates.model(there);
  };
  const std::optional<Remembered> known = remembered(around, coordinates, x, moved, shots);
  parallel_for(coordinates.effects(), [&](std::size_t i) {
    if (coordinates.parameter(i).structural) {
      J.col(i).setZero();
      return;
    }
    J.col(i) = (prediction_error_near(around.problem, *around.library, moved(i), r,
                                      coordinates.joints(i), shots, known ? &*known : nullptr) -
                r) /
               step_of(i);
  });
  return J;
}

struct Normal {
  Eigen::MatrixXd H;  // J' M J + prior
  Eigen::VectorXd g;  // half gradient of the objective
  double objective;
};

/// `energy`: of every shot, at x.
double objective_of(const Surroundings& around, const Coordinates& c, const Eigen::VectorXd& x,
                    const Eigen::VectorXd& energy) {
  return around.bounded(energy).sum() +
         around.settings().tolerances.precision * x.tail(x.size() - c.effects()).squaredNorm();
}

/// Where a fit stands.
struct Point {
  Eigen::VectorXd x, r;
  Eigen::MatrixXd J = {};  // d r / d x there; empty: not known
  double damping = 1e-4;
  bool converged = false;
};

double objective_at(const Surroundings& around, const Coordinates& c, const Point& at) {
  return objective_of(around, c, at.x, around.starts.energy_by_shot(at.r));
}

/// The normal equations at a point whose derivative is known.
Normal assemble(const Surroundings& around, const Coordinates& c, const Point& at) {
  const Eigen::Index n = c.size();
  const Eigen::VectorXd energy = around.starts.energy_by_shot(at.r);
  const Eigen::MatrixXd gram = around.starts.gram(with_error(at.J, at.r), around.weights(energy));
  Normal out{gram.topLeftCorner(n, n), gram.topRightCorner(n, 1),
             objective_of(around, c, at.x, energy)};
  for (Eigen::Index i = 0; i < n; ++i) {
    out.H(i, i) += prior(around, c.effects(), i);
    if (i >= c.effects()) out.g[i] += around.settings().tolerances.precision * at.x[i];
  }
  return out;
}

/// Step of the damped normal equations with coordinates at an active bound held still.
Eigen::VectorXd step_inside(const Coordinates& c, const Normal& normal, const Eigen::VectorXd& x,
                            double damping) {
  Eigen::MatrixXd H = normal.H;
  H.diagonal() *= 1.0 + damping;
  Eigen::VectorXd g = normal.g;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const bool held = (x[i] <= c.low(i) && g[i] > 0.0) || (x[i] >= c.high(i) && g[i] < 0.0);
    if (!held) continue;
    H.row(i).setZero();
    H.col(i).setZero();
    H(i, i) = 1.0;
    g[i] = 0.0;
  }
  return -H.ldlt().solve(g);
}

/// One damped step from `at`, shorter until the objective falls; converged where it falls no more,
/// or where the derivatives promise next to nothing. Where friction sticks they promise anything:
/// the last attempts go a hundredth of the way.
/// `shots`: the only ones whose error is brought up to date; empty: all.
void take_step(const Surroundings& around, const Coordinates& c, const Normal& normal, Point& at,
               const std::vector<char>& shots = {}) {
  const double least = 0.01 * around.settings().fitting.converged * normal.objective;
  bool improved = false;
  for (int attempt = 0; attempt < around.settings().fitting.attempts && !improved; ++attempt) {
    const Eigen::VectorXd trial = c.inside(at.x + step_inside(c, normal, at.x, at.damping));
    const Eigen::VectorXd step = trial - at.x;
    const double promised = -step.dot(2.0 * normal.g + normal.H * step);
    if (attempt == 0 && promised >= 0.0 && promised < least) break;
    Eigen::VectorXd r =
        prediction_error_near(around.problem, *around.library, c.model(trial), at.r, {}, shots);
    const double objective = objective_of(around, c, trial, around.starts.energy_by_shot(r));
    if (objective < normal.objective) {
      improved = true;
      at.converged = normal.objective - objective < around.settings().fitting.converged * objective;
      at.x = trial;
      at.r = std::move(r);
      at.J.resize(0, 0);
      at.damping = std::max(at.damping * 0.2, 1e-6);
    } else {
      at.damping = at.damping * 10.0 + 1e-2;
    }
  }
  if (!improved) at.converged = true;
}

void derive(const Surroundings& around, const Coordinates& c, Point& at,
            const std::vector<char>& shots = {}) {
  if (at.J.cols() == 0) at.J = jacobian(around, c, at.x, at.r, shots);
}

void descend(const Surroundings& around, const Coordinates& c, Point& at, int iterations,
             const std::vector<char>& shots = {}) {
  for (int iteration = 0; iteration < iterations && !at.converged; ++iteration) {
    derive(around, c, at, shots);
    take_step(around, c, assemble(around, c, at), at, shots);
  }
}

Point begin(const Surroundings& around, const Coordinates& c, const Model& start) {
  Eigen::VectorXd x = c.inside(c.of(start));
  Eigen::VectorXd r = prediction_error(around.problem, *around.library, c.model(x));
  return {std::move(x), std::move(r)};
}

/// By coordinate: held at a bound, or structural.
std::vector<char> held_at(const Coordinates& c, const Eigen::VectorXd& x) {
  std::vector<char> out(static_cast<std::size_t>(c.size()), 0);
  for (Eigen::Index i = 0; i < c.size(); ++i) {
    // a limit that may be off reaches as far as kOff: what is near its lower end is said in units
    const double near = 1e-6 * std::min(1.0, c.high(i) - c.low(i));
    const bool structural = i < c.effects() && c.parameter(i).structural;
    const bool inside = x[i] > c.low(i) + near && x[i] < c.high(i) - near;
    out[static_cast<std::size_t>(i)] = structural || !inside;
  }
  return out;
}

FitResult rough_result(const Surroundings& around, const Coordinates& c, Point at) {
  FitResult out;
  out.parameters = static_cast<int>(c.effects());
  out.model = c.model(at.x);
  out.objective = objective_at(around, c, at);
  out.fixed = held_at(c, at.x);
  out.converged = at.converged;
  out.r = std::move(at.r);
  out.J = std::move(at.J);
  return out;
}

FitResult result_with_derivatives(const Surroundings& around, const Coordinates& c, Point at) {
  derive(around, c, at);
  const Eigen::MatrixXd H = assemble(around, c, at).H;
  FitResult out = rough_result(around, c, std::move(at));
  out.covariance = H.ldlt().solve(Eigen::MatrixXd::Identity(H.rows(), H.cols()));
  return out;
}

}  // namespace

FitResult fit(const Surroundings& around, const Model& start, int iterations) {
  const Coordinates c(around, start);
  Point at = begin(around, c, start);
  descend(around, c, at, iterations);
  return result_with_derivatives(around, c, std::move(at));
}

FitResult rough_fit(const Surroundings& around, const Model& start, int iterations) {
  const Coordinates c(around, start);
  Point at = begin(around, c, start);
  descend(around, c, at, iterations);
  return rough_result(around, c, std::move(at));
}

FitResult resume(const Surroundings& around, FitResult from, int iterations) {
  const Coordinates c(around, from.model);
  Point at{c.of(from.model), std::move(from.r), std::move(from.J)};
  at.converged = iterations == 0 && from.converged;
  descend(around, c, at, iterations);
  return result_with_derivatives(around, c, std::move(at));
}

QuickFit quick_fit(const Surroundings& around, const Model& start, int iterations) {
  const Coordinates c(around, start);
  // what is left out has no part in the fit, and is simulated once, where it ends
  const std::vector<char> seen = shots_of(around, true), unseen = shots_of(around, false);
  const auto error = [&](const Eigen::VectorXd& x, const Eigen::VectorXd& base,
                         const std::vector<char>& shots) {
    return prediction_error_near(around.problem, *around.library, c.model(x), base, {}, shots);
  };
  Point at{c.inside(c.of(start)), Eigen::VectorXd::Zero(around.problem->size)};
  at.r = error(at.x, at.r, seen);
  descend(around, c, at, iterations, seen);
  const double objective = objective_at(around, c, at);
  if (!unseen.empty()) at.r = error(at.x, at.r, unseen);
  return {c.model(at.x), objective, std::move(at.r)};
}

Model moved(const Surroundings& around, const Model& model, const Eigen::VectorXd& delta) {
  const Coordinates c(around, model);
  return c.model(c.inside(c.of(model) + delta));
}

Eigen::VectorXd displacement(const Surroundings& around, const Model& from, const Model& to) {
  const Coordinates c(around, from);
  return c.of(to) - c.of(from);
}

Eigen::MatrixXd room_to_move(const Surroundings& around, const Model& model) {
  const Coordinates c(around, model);
  const Eigen::VectorXd x = c.of(model);
  Eigen::MatrixXd out(c.size(), 2);
  for (Eigen::Index i = 0; i < c.size(); ++i) out.row(i) << c.low(i) - x[i], c.high(i) - x[i];
  return out;
}

double prior_energy(const Surroundings& around, const Model& model) {
  double sum = 0.0;
  for (std::size_t k = 0; k < model.nuisance.size(); ++k) {
    const double x = model.nuisance[k] / around.library->nuisances[k].tolerance;
    sum += around.settings().tolerances.precision * x * x;
  }
  return sum;
}

std::vector<double> parameter_sigmas(const FitResult& result, const Library& library) {
  std::vector<double> out;
  Eigen::Index i = 0;
  for (const Chosen& chosen : result.model.effects) {
    for (const CandidateParameter& p : library[chosen].parameters) {
      out.push_back(p.typical * std::sqrt(std::max(0.0, result.covariance(i, i))));
      ++i;
    }
  }
  return out;
}

}  // namespace sanso::diagnose
