// Slopes forward, one parameter a thread at a time; damping on the scale of each parameter.
#include "host/learn/model/refine.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "shared/files/parallel.h"

namespace sanso::learn {
namespace {

constexpr double kSlopeStep = 1e-3;  // of a prior deviation: contact makes smaller ones rough
constexpr double kFirstDamping = 1e-2, kLessDamping = 0.3, kMoreDamping = 5.0;
constexpr int kTries = 6;

Eigen::VectorXd errors_at(const RefineProblem& problem, const Eigen::VectorXd& z) {
  return n_step_errors(problem.windows, model::make_step_model(problem.map.parameters(z)),
                       problem.ground, problem.weights)
      .reshaped();
}

Eigen::MatrixXd slopes(const RefineProblem& problem, const Eigen::VectorXd& z,
                       const Eigen::VectorXd& errors, int threads) {
  Eigen::MatrixXd J(errors.size(), z.size());
  files::parallel_for(static_cast<std::size_t>(z.size()), threads, [&](std::size_t i) {
    const auto entry = static_cast<Eigen::Index>(i);
    Eigen::VectorXd ahead = z;
    ahead[entry] += kSlopeStep;
    J.col(entry) = (errors_at(problem, ahead) - errors) / kSlopeStep;
  });
  return J;
}

}  // namespace

Eigen::VectorXd refined(const RefineProblem& problem, double prior, Eigen::VectorXd z,
                        const RefineSettings& settings, int threads) {
  const auto cost_of = [prior](const Eigen::VectorXd& errors, const Eigen::VectorXd& at) {
    return errors.squaredNorm() + prior * at.squaredNorm();
  };
  Eigen::VectorXd errors = errors_at(problem, z);
  double cost = cost_of(errors, z), damping = kFirstDamping;
  for (int step = 0; step < settings.steps && std::isfinite(cost); ++step) {
    const Eigen::MatrixXd J = slopes(problem, z, errors, threads);
    if (!J.allFinite()) return z;
    Eigen::MatrixXd information = J.transpose() * J;
    information.diagonal().array() += prior;
    const Eigen::VectorXd downhill = -(J.transpose() * errors + prior * z);
    const double before = cost;
    for (int tried = 0; tried < kTries && cost == before; ++tried) {
      Eigen::MatrixXd damped = information;
      damped.diagonal() *= 1.0 + damping;
      const Eigen::VectorXd next = z + damped.llt().solve(downhill);
      const Eigen::VectorXd errors_next = errors_at(problem, next);
      const double cost_next = cost_of(errors_next, next);
      if (cost_next < cost) {
        z = next, errors = errors_next, cost = cost_next;
        damping *= kLessDamping;
      } else {
        damping *= kMoreDamping;
      }
    }
    if (before - cost <= settings.enough * before) break;
  }
  return z;
}

}  // namespace sanso::learn
