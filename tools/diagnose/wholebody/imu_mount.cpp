// The rotation first, from all pairs of vectors at once (Wahba's problem), then rotation and biases
// together.
#include "tools/diagnose/wholebody/imu_mount.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "shared/math/so3.h"
#include "tools/diagnose/stats/robust.h"

namespace sanso::diagnose {
namespace {

/// The rotation that turns the predicted vectors into the read ones best (Kabsch 1976).
M3 wahba(const std::vector<ImuWindow>& windows) {
  double acc = 0.0, gyro = 0.0;
  for (const ImuWindow& w : windows) {
    acc += w.acc_predicted.squaredNorm();
    if (w.with_gyro) gyro += w.gyro_predicted.squaredNorm();
  }
  M3 H = M3::Zero();
  for (const ImuWindow& w : windows) {
    H += w.acc * w.acc_predicted.transpose() / std::max(acc, 1e-12);
    if (w.with_gyro) H += w.gyro * w.gyro_predicted.transpose() / std::max(gyro, 1e-12);
  }
  const Eigen::JacobiSVD<M3> svd(H, Eigen::ComputeFullU | Eigen::ComputeFullV);
  M3 D = M3::Identity();
  D(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  return svd.matrixU() * D * svd.matrixV().transpose();
}

V3 acc_left(const ImuWindow& w, const ImuMount& m) {
  return w.acc - m.turn * w.acc_predicted - m.acc_bias;
}
V3 gyro_left(const ImuWindow& w, const ImuMount& m) {
  return w.gyro - m.turn * w.gyro_predicted - m.gyro_bias;
}

/// Standard deviation of values around zero that a few outliers do not decide.
double spread_around_zero(std::vector<double> x, double least) {
  for (double& v : x) v = std::abs(v);
  return x.empty() ? 1.0 : std::max(kSigmaOfMedian * median(x), least);
}

using Matrix9 = Eigen::Matrix<double, 9, 9>;
using Vector9 = Eigen::Matrix<double, 9, 1>;

/// One vector equation: left = -[turned]x delta + bias, the bias at its place in the unknowns.
struct Row {
  V3 left, turned;
  int bias_at;
};

void add_rows(const Row& row, double sigma, double outlier, Matrix9& N, Vector9& c) {
  const double size = row.left.norm() / sigma;
  const double weight = (size > outlier ? outlier / size : 1.0) / (sigma * sigma);
  Eigen::Matrix<double, 3, 9> J = Eigen::Matrix<double, 3, 9>::Zero();
  J.leftCols<3>() = -math::skew(row.turned);
  J.block<3, 3>(0, row.bias_at) = M3::Identity();
  N += weight * J.transpose() * J, c += weight * J.transpose() * row.left;
}

/// Keeps three of the unknowns where they are.
void hold(int first, Matrix9& N, Vector9& c) {
  N.middleRows<3>(first).setZero(), N.middleCols<3>(first).setZero();
  N.block<3, 3>(first, first) = M3::Identity();
  c.segment<3>(first).setZero();
}

double huber(double size, double outlier) {
  return size <= outlier ? size * size : outlier * (2.0 * size - outlier);
}

}  // namespace

ImuNoise noise_of(const std::vector<ImuWindow>& windows, const ImuMount& m) {
  std::vector<double> acc, gyro;
  for (const ImuWindow& w : windows) {
    for (const double x : acc_left(w, m)) acc.push_back(x);
    if (!w.with_gyro) continue;
    for (const double x : gyro_left(w, m)) gyro.push_back(x);
  }
  return {spread_around_zero(acc, 1e-6), spread_around_zero(gyro, 1e-7)};
}

double loss_of(const ImuWindow& w, const ImuMount& m, const ImuNoise& noise, double outlier) {
  const double acc = huber(acc_left(w, m).norm() / noise.acc, outlier);
  return w.with_gyro ? acc + huber(gyro_left(w, m).norm() / noise.gyro, outlier) : acc;
}

ImuMount fit_mount(const std::vector<ImuWindow>& windows, const WholeSettings& settings,
                   const ImuParts& parts) {
  const double acc_bias = settings.acc_bias, gyro_bias = settings.gyro_bias;
  const double outlier = settings.imu_outlier;
  ImuMount m;
  if (windows.empty()) return m;
  if (parts.turn) m.turn = wahba(windows);
  for (int step = 0; step < 8; ++step) {
    const ImuNoise noise = noise_of(windows, m);
    Matrix9 N = Matrix9::Zero();
    Vector9 c = Vector9::Zero();
    for (const ImuWindow& w : windows) {
      add_rows({acc_left(w, m), m.turn * w.acc_predicted, 3}, noise.acc, outlier, N, c);
      if (!w.with_gyro) continue;
      add_rows({gyro_left(w, m), m.turn * w.gyro_predicted, 6}, noise.gyro, outlier, N, c);
    }
    N.diagonal().head<3>().array() += 1e-9 * N.diagonal().head<3>().maxCoeff() + 1e-12;
    N.diagonal().segment<3>(3).array() += 1.0 / (acc_bias * acc_bias);
    N.diagonal().tail<3>().array() += 1.0 / (gyro_bias * gyro_bias);
    c.segment<3>(3) -= m.acc_bias / (acc_bias * acc_bias);
    c.tail<3>() -= m.gyro_bias / (gyro_bias * gyro_bias);
    if (!parts.turn) hold(0, N, c);
    if (!parts.acc_bias) hold(3, N, c);
    const Vector9 x = N.ldlt().solve(c);
    m.turn = math::rotation_matrix(math::quat_exp(V3(x.head<3>()))) * m.turn;
    m.acc_bias += x.segment<3>(3), m.gyro_bias += x.tail<3>();
  }
  m.acc_rms = acc_error(windows, m);
  double sum = 0.0, n = 0.0;
  for (const ImuWindow& w : windows) {
    if (w.with_gyro) sum += gyro_left(w, m).squaredNorm(), n += 3.0;
  }
  m.gyro_rms = n > 0.0 ? std::sqrt(sum / n) : 0.0;
  return m;
}

double acc_error(const std::vector<ImuWindow>& windows, const ImuMount& mount) {
  double sum = 0.0;
  for (const ImuWindow& w : windows) sum += acc_left(w, mount).squaredNorm();
  return windows.empty() ? 0.0 : std::sqrt(sum / (3.0 * static_cast<double>(windows.size())));
}

}  // namespace sanso::diagnose
