// Kalman filter of one world axis: base position and velocity, and where the two soles stand.
// Linear, fixed size, corrected by one number at a time. The three axes are independent because
// orientation comes from the IMU.
#pragma once

#include <Eigen/Core>

namespace sanso::firmware {

class AxisFilter {
 public:
  enum Index : int { kPosition = 0, kVelocity = 1, kRightSole = 2, kLeftSole = 3 };
  using Vec4 = Eigen::Vector4d;
  using Mat4 = Eigen::Matrix4d;

  /// Starts at `position` with the soles at `right`, `left`; spread sigma [m, m/s].
  void reset(double position, double right, double left, double sigma) {
    x_ << position, 0.0, right, left;
    P_ = Mat4::Identity() * (sigma * sigma);
  }

  /// x' = F x + B a over dt [s]: constant acceleration a [m/s^2]; soles walk at random.
  /// accel_noise [m/s^2] for this step, sole noises [m/s] (per square root of second would differ
  /// only by a constant).
  void predict(double a, double dt, double accel_noise, double right_noise, double left_noise) {
    x_[kPosition] += dt * x_[kVelocity] + 0.5 * dt * dt * a;
    x_[kVelocity] += dt * a;
    // P' = F P F' + Q with F = I + dt e_p e_v'
    P_.row(kPosition) += dt * P_.row(kVelocity);
    P_.col(kPosition) += dt * P_.col(kVelocity);
    const double q = accel_noise * accel_noise;
    P_(kPosition, kPosition) += 0.25 * dt * dt * dt * dt * q;
    P_(kPosition, kVelocity) += 0.5 * dt * dt * dt * q;
    P_(kVelocity, kPosition) += 0.5 * dt * dt * dt * q;
    P_(kVelocity, kVelocity) += dt * dt * q;
    P_(kRightSole, kRightSole) += dt * dt * right_noise * right_noise;
    P_(kLeftSole, kLeftSole) += dt * dt * left_noise * left_noise;
  }

  /// Corrects with innovation = measured - h'x of a quantity h'x, measurement noise sigma.
  void correct(const Vec4& h, double innovation, double sigma) {
    const Vec4 Ph = P_ * h;
    apply(Ph, innovation, h.dot(Ph) + sigma * sigma);
  }
  /// This axis' share in correcting a sum over several axes, of which it adds h'x; `S`: variance of
  /// the whole innovation. The axes stay independent.
  void correct_share(const Vec4& h, double innovation, double S) { apply(P_ * h, innovation, S); }
  /// Corrects with a measured value of h'x, noise sigma.
  void measure(const Vec4& h, double measured, double sigma) {
    correct(h, measured - h.dot(x_), sigma);
  }

  /// Of the base along this axis of the world [m], [m/s].
  double position() const { return x_[kPosition]; }
  double velocity() const { return x_[kVelocity]; }
  /// What h'x may be wrong by.
  double variance(const Vec4& h) const { return h.dot(P_ * h); }
  const Vec4& x() const { return x_; }
  const Mat4& P() const { return P_; }

 private:
  void apply(const Vec4& Ph, double innovation, double S) {
    const Vec4 K = Ph / S;
    x_ += K * innovation;
    P_ -= K * Ph.transpose();
    P_ = 0.5 * (P_ + P_.transpose()).eval();  // rounding must not make it lose symmetry
  }

  Vec4 x_ = Vec4::Zero();
  Mat4 P_ = Mat4::Identity();
};

}  // namespace sanso::firmware
