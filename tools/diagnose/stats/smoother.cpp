// Kalman filter forwards, Rauch-Tung-Striebel smoother backwards; the density of the
// acceleration is that of the largest likelihood.
#include "tools/diagnose/stats/smoother.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>
#include <limits>

namespace sanso::diagnose {
namespace {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;

/// Transition over h with acceleration as a random walk of density s (van Loan's integral, closed
/// form).
Mat3 transition(double h) {
  Mat3 F;
  F << 1, h, h * h / 2, 0, 1, h, 0, 0, 1;
  return F;
}

Mat3 process_noise(double h, double density) {
  const double h2 = h * h, h3 = h2 * h, h4 = h3 * h, h5 = h4 * h;
  Mat3 Q;
  Q << h5 / 20, h4 / 8, h3 / 6, h4 / 8, h3 / 3, h2 / 2, h3 / 6, h2 / 2, h;
  return density * Q;
}

struct Filtered {
  std::vector<Vec3> x_prior, x;
  std::vector<Mat3> P_prior, P;
  double log_likelihood = 0.0;
};

/// Kalman filter over the rows [0, rows); keeps what the backward pass needs when `keep`.
Filtered filter(std::span<const double> t, std::span<const double> q, std::span<const double> sigma,
                const SmootherSettings& before, double density, std::size_t rows, bool keep) {
  Filtered f;
  std::size_t first = 0;
  while (first < rows && !std::isfinite(q[first])) ++first;
  Vec3 x(first < rows ? q[first] : 0.0, 0.0, 0.0);
  // where the joint is, the first reading says, once
  const double at_first = first < rows ? sigma[first] : 1.0;
  const double position = before.position * before.position * at_first * at_first;
  Mat3 P =
      Vec3(position + 1e-12, before.speed * before.speed, before.acceleration * before.acceleration)
          .asDiagonal();
  for (std::size_t k = 0; k < rows; ++k) {
    if (k > 0) {
      const double h = t[k] - t[k - 1];
      const Mat3 F = transition(h);
      x = F * x;
      P = F * P * F.transpose() + process_noise(h, density);
    }
    if (keep) f.x_prior.push_back(x), f.P_prior.push_back(P);
    if (std::isfinite(q[k])) {
      const double variance = sigma[k] * sigma[k], S = P(0, 0) + variance, e = q[k] - x[0];
      const Vec3 gain = P.col(0) / S;
      x += gain * e;
      Mat3 A = Mat3::Identity();
      A.col(0) -= gain;
      // Joseph form: stays symmetric, positive
      P = A * P * A.transpose() + variance * gain * gain.transpose();
      if (k > first + 3) f.log_likelihood -= 0.5 * (std::log(S) + e * e / S);
    }
    if (keep) f.x.push_back(x), f.P.push_back(P);
  }
  return f;
}

/// Largest likelihood over two decades a step; the first rows suffice (the density is a property of
/// the whole motion).
double choose_density(std::span<const double> t, std::span<const double> q,
                      std::span<const double> sigma, const SmootherSettings& before,
                      int likelihood_rows) {
  const std::size_t rows = std::min(t.size(), static_cast<std::size_t>(likelihood_rows));
  double best = -std::numeric_limits<double>::infinity(), density = 1.0;
  for (double exponent = -6.0; exponent <= 9.0; exponent += 1.0) {
    const double candidate = std::pow(10.0, exponent);
    const double value = filter(t, q, sigma, before, candidate, rows, false).log_likelihood;
    if (value > best) best = value, density = candidate;
  }
  return density;
}

}  // namespace

SmoothedState smooth_position(std::span<const double> t, std::span<const double> q, double sigma,
                              const SmootherSettings& before, int likelihood_rows) {
  return smooth_position(t, q, std::vector<double>(t.size(), sigma), before, likelihood_rows);
}

SmoothedState smooth_position(std::span<const double> t, std::span<const double> q,
                              std::span<const double> sigma, const SmootherSettings& before,
                              int likelihood_rows) {
  const std::size_t n = t.size();
  SmoothedState out;
  for (auto* v : {&out.q, &out.dq, &out.ddq, &out.q_sigma, &out.dq_sigma}) v->resize(n);
  if (n == 0) return out;
  out.jerk_density = choose_density(t, q, sigma, before, likelihood_rows);
  const Filtered f = filter(t, q, sigma, before, out.jerk_density, n, true);
  Vec3 x = f.x[n - 1];
  Mat3 P = f.P[n - 1];
  for (std::size_t k = n; k-- > 0;) {
    if (k + 1 < n) {
      // backward pass: gain C = P_k F' P_prior^-1
      const Mat3 F = transition(t[k + 1] - t[k]);
      const Mat3 C = f.P_prior[k + 1].ldlt().solve(F * f.P[k]).transpose();
      x = f.x[k] + C * (x - f.x_prior[k + 1]);
      P = f.P[k] + C * (P - f.P_prior[k + 1]) * C.transpose();
    }
    out.q[k] = x[0], out.dq[k] = x[1], out.ddq[k] = x[2];
    out.q_sigma[k] = std::sqrt(std::max(0.0, P(0, 0)));
    out.dq_sigma[k] = std::sqrt(std::max(0.0, P(1, 1)));
  }
  return out;
}

}  // namespace sanso::diagnose
