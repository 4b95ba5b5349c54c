// One linear solve a fit. play() runs a set through the very player that the controller uses.
#include "host/motion/dmp_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace sanso::motion {
namespace {

using policy::kAlphaZ;
using policy::kNumScalarPrimitives;
using policy::PrimitiveForm;
using policy::PrimitiveSet;

constexpr double kBetaZ = kAlphaZ / 4.0;
constexpr double kRidge = 1e-6;

void require_ticks(const Trajectory& trajectory) {
  if (std::abs(trajectory.dt_s - policy::kPrimitiveStep_s) > 1e-9) {
    throw std::invalid_argument("primitives are fitted to samples at 0.01 s, got " +
                                std::to_string(trajectory.dt_s) +
                                " s; resample the trajectory first");
  }
  if (trajectory.duration_s() < 0.1)
    throw std::invalid_argument("a trajectory for primitives lasts at least 0.1 s");
}

/// Index of scalar primitive i in the configuration part of the state.
int state_index(int i) { return i < 3 ? model::kXPos + i : model::kXJoint + i - 3; }

/// First and second derivative of row samples, central inside; `periodic` joins the ends up to the
/// drift.
struct Derivatives {
  Eigen::MatrixXd first, second;
};
Derivatives differentiate(const Eigen::MatrixXd& y, double dt, bool periodic) {
  const Eigen::Index last = y.rows() - 1;
  Derivatives d{Eigen::MatrixXd::Zero(y.rows(), y.cols()),
                Eigen::MatrixXd::Zero(y.rows(), y.cols())};
  for (Eigen::Index k = 1; k < last; ++k) {
    d.first.row(k) = (y.row(k + 1) - y.row(k - 1)) / (2 * dt);
    d.second.row(k) = (y.row(k + 1) - 2 * y.row(k) + y.row(k - 1)) / (dt * dt);
  }
  if (periodic) {
    d.first.row(0) = (y.row(1) - y.row(0) + y.row(last) - y.row(last - 1)) / (2 * dt);
    d.second.row(0) = ((y.row(1) - y.row(0)) - (y.row(last) - y.row(last - 1))) / (dt * dt);
    d.first.row(last) = d.first.row(0);
    d.second.row(last) = d.second.row(0);
  } else {
    d.first.row(0) = (y.row(1) - y.row(0)) / dt;
    d.first.row(last) = (y.row(last) - y.row(last - 1)) / dt;
  }
  return d;
}

/// Activations of every basis function at every sample (samples x N).
Eigen::MatrixXd basis_matrix(const PrimitiveSet& set, Eigen::Index samples) {
  Eigen::MatrixXd psi = Eigen::MatrixXd::Zero(samples, set.num_basis);
  for (Eigen::Index k = 0; k < samples; ++k) {
    const policy::BasisWindow window =
        policy::active_basis(set, static_cast<double>(k) * policy::kPrimitiveStep_s);
    for (int i = 0; i < window.count; ++i) psi(k, window.index[i]) = window.activation[i];
  }
  return psi;
}

Eigen::MatrixXd solve_weights(const Eigen::MatrixXd& psi, const Eigen::MatrixXd& forcing) {
  Eigen::MatrixXd normal = psi.transpose() * psi;
  normal.diagonal().array() += kRidge;
  return normal.ldlt().solve(psi.transpose() * forcing);
}

Eigen::MatrixXd scalar_samples(const Trajectory& trajectory) {
  Eigen::MatrixXd y(static_cast<Eigen::Index>(trajectory.x.size()), kNumScalarPrimitives);
  for (Eigen::Index k = 0; k < y.rows(); ++k) {
    for (int i = 0; i < kNumScalarPrimitives; ++i)
      y(k, i) = trajectory.x[static_cast<std::size_t>(k)][state_index(i)];
  }
  return y;
}

/// tau^2 y'' - alpha (beta (g - y) - tau y'), the forcing that makes the primitive follow y
/// exactly.
Eigen::MatrixXd scalar_forcing(const Eigen::MatrixXd& y, const Derivatives& d,
                               const Eigen::RowVectorXd& goal, double tau) {
  return tau * tau * d.second - kAlphaZ * kBetaZ * ((-y).rowwise() + goal) +
         kAlphaZ * tau * d.first;
}

/// The same for the orientation; error and rate in world axes (samples x 3). [Ude 2014]
struct OrientationSamples {
  Eigen::MatrixXd rate, forcing;
};
OrientationSamples orientation_forcing(const Trajectory& trajectory, const math::Quat& goal,
                                       double tau, bool periodic) {
  const auto& x = trajectory.x;
  const auto n = static_cast<Eigen::Index>(x.size());
  const auto quat = [&](Eigen::Index k) {
    return model::base_quat(x[static_cast<std::size_t>(k)]);
  };
  // rotation over one sample in world axes; the rate at sample k is the mean of its two neighbours
  Eigen::MatrixXd step(n - 1, 3);
  for (Eigen::Index k = 0; k + 1 < n; ++k) {
    step.row(k) = math::quat_log(math::quat_multiply(quat(k + 1), math::quat_conjugate(quat(k))))
                      .transpose() /
                  trajectory.dt_s;
  }
  OrientationSamples samples{Eigen::MatrixXd::Zero(n, 3), Eigen::MatrixXd::Zero(n, 3)};
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::Index before = k > 0 ? k - 1 : (periodic ? n - 2 : 0);
    const Eigen::Index after = k + 1 < n ? k : (periodic ? 0 : n - 2);
    samples.rate.row(k) = 0.5 * (step.row(before) + step.row(after));
    const Eigen::RowVector3d acceleration = (step.row(after) - step.row(before)) / trajectory.dt_s;
    const math::Vec3 error =
        math::quat_log(math::quat_multiply(goal, math::quat_conjugate(quat(k))));
    samples.forcing.row(k) = tau * tau * acceleration - kAlphaZ * kBetaZ * error.transpose() +
                             kAlphaZ * tau * samples.rate.row(k);
  }
  return samples;
}

void store_scalars(PrimitiveSet& set, const Eigen::MatrixXd& y, const Derivatives& d,
                   const Eigen::MatrixXd& weights) {
  for (int i = 0; i < kNumScalarPrimitives; ++i) {
    set.scalar[i].start = y(0, i);
    set.scalar[i].start_rate = d.first(0, i);
    for (int b = 0; b < set.num_basis; ++b)
      set.scalar[i].weights[b] = static_cast<float>(weights(b, i));
  }
}

void store_orientation(PrimitiveSet& set, const OrientationSamples& samples,
                       const Eigen::MatrixXd& weights) {
  set.orientation.start_rate = samples.rate.row(0).transpose();
  for (int b = 0; b < set.num_basis; ++b) {
    for (int k = 0; k < 3; ++k) set.orientation.weights[b][k] = static_cast<float>(weights(b, k));
  }
}

/// Orientation in the middle of all samples: mean of the logarithms about the first one.
math::Quat mean_orientation(const Trajectory& trajectory) {
  const math::Quat first = model::base_quat(trajectory.x.front());
  math::Vec3 sum = math::Vec3::Zero();
  for (const auto& x : trajectory.x) sum += math::quat_minus(model::base_quat(x), first);
  return math::quat_plus(first, sum / static_cast<double>(trajectory.x.size()));
}

}  // namespace

PrimitiveSet fit_discrete(const Trajectory& trajectory, const DiscreteFit& options) {
  require_ticks(trajectory);
  PrimitiveSet set;
  set.form = PrimitiveForm::discrete;
  set.duration_s = trajectory.duration_s();
  set.fade_start = options.fade_start;
  set.num_basis =
      std::max(25, static_cast<int>(std::lround(options.basis_per_second * set.duration_s)));
  if (set.num_basis > policy::kMaxBasis) {
    throw std::invalid_argument(std::to_string(set.num_basis) +
                                " basis functions asked for, at most " +
                                std::to_string(policy::kMaxBasis) + " fit; lower basis_per_second");
  }
  const Eigen::MatrixXd psi = basis_matrix(set, static_cast<Eigen::Index>(trajectory.x.size()));

  const Eigen::MatrixXd y = scalar_samples(trajectory);
  const Derivatives d = differentiate(y, trajectory.dt_s, false);
  const Eigen::RowVectorXd goal = y.row(y.rows() - 1);
  store_scalars(set, y, d, solve_weights(psi, scalar_forcing(y, d, goal, set.tau())));
  for (int i = 0; i < kNumScalarPrimitives; ++i) set.scalar[i].goal = goal[i];

  set.orientation.start = model::base_quat(trajectory.x.front());
  set.orientation.goal = model::base_quat(trajectory.x.back());
  const OrientationSamples o =
      orientation_forcing(trajectory, set.orientation.goal, set.tau(), false);
  store_orientation(set, o, solve_weights(psi, o.forcing));
  return set;
}

PrimitiveSet fit_rhythmic(const Trajectory& one_period, int num_basis, double duration_s) {
  require_ticks(one_period);
  if (num_basis < 5 || num_basis > policy::kMaxBasis) {
    throw std::invalid_argument("a rhythmic primitive has 5 to " +
                                std::to_string(policy::kMaxBasis) + " basis functions, got " +
                                std::to_string(num_basis));
  }
  PrimitiveSet set;
  set.form = PrimitiveForm::rhythmic;
  set.period_s = one_period.duration_s();
  set.duration_s = duration_s;
  set.num_basis = num_basis;
  const Eigen::MatrixXd psi = basis_matrix(set, static_cast<Eigen::Index>(one_period.x.size()));

  Eigen::MatrixXd y = scalar_samples(one_period);
  const Eigen::Index last = y.rows() - 1;
  const Eigen::RowVectorXd drift = (y.row(last) - y.row(0)) / set.period_s;
  for (Eigen::Index k = 0; k <= last; ++k)
    y.row(k) -= drift * (static_cast<double>(k) * one_period.dt_s);
  const Derivatives d = differentiate(y, one_period.dt_s, true);
  const Eigen::RowVectorXd goal = y.topRows(last).colwise().mean();
  store_scalars(set, y, d, solve_weights(psi, scalar_forcing(y, d, goal, set.tau())));
  for (int i = 0; i < kNumScalarPrimitives; ++i) {
    set.scalar[i].goal = goal[i];
    set.scalar[i].drift = drift[i];
  }

  set.orientation.start = model::base_quat(one_period.x.front());
  set.orientation.goal = mean_orientation(one_period);
  const OrientationSamples o =
      orientation_forcing(one_period, set.orientation.goal, set.tau(), true);
  store_orientation(set, o, solve_weights(psi, o.forcing));
  return set;
}

Trajectory play(const PrimitiveSet& set) {
  Trajectory trajectory{policy::kPrimitiveStep_s, {}};
  trajectory.x.reserve(static_cast<std::size_t>(set.duration_ticks()) + 1);
  policy::PrimitivePlayer player;
  player.reset(set);
  trajectory.x.push_back(player.state());
  while (!player.finished()) {
    player.step();
    trajectory.x.push_back(player.state());
  }
  return trajectory;
}

}  // namespace sanso::motion
