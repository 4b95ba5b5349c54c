// Plays a primitive set: phase, basis activations, and the spring-damper systems of joints and
// base, integrated in steps of 1 ms inside the 10 ms tick.
#include "shared/policy/primitives.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "shared/model/joints.h"

namespace sanso::policy {
namespace {

using model::kPi;
constexpr double kInnerStep_s = 0.001;
constexpr int kInnerSteps = 10;

/// 1 before `fade_start`, 0 from 1 on, half a cosine in between. `s` is the fraction of the
/// duration.
double fade(double s, double fade_start) {
  if (s <= fade_start) return 1.0;
  if (s >= 1.0) return 0.0;
  return 0.5 * (1.0 + std::cos(kPi * (s - fade_start) / (1.0 - fade_start)));
}

/// Makes the activations sum to `total`.
void normalize(BasisWindow& window, double total) {
  double sum = 0.0;
  for (int k = 0; k < window.count; ++k) sum += window.activation[k];
  for (int k = 0; k < window.count; ++k) window.activation[k] *= total / sum;
}

BasisWindow discrete_basis(const PrimitiveSet& set, double s) {
  BasisWindow window;
  const double gate = fade(s, set.fade_start);
  if (gate == 0.0) return window;
  // centres c_i = i / (N - 1), width = spacing: psi_i = exp(-(position - i)^2) with position = s (N
  // - 1)
  const double position = std::max(s, 0.0) * (set.num_basis - 1);
  const int centre = static_cast<int>(std::lround(position));
  for (int i = centre - BasisWindow::kHalfWidth; i <= centre + BasisWindow::kHalfWidth; ++i) {
    if (i < 0 || i >= set.num_basis) continue;
    const double distance = position - i;
    window.index[window.count] = static_cast<std::int16_t>(i);
    window.activation[window.count++] = std::exp(-distance * distance);
  }
  normalize(window, gate);
  return window;
}

BasisWindow rhythmic_basis(const PrimitiveSet& set, double t_s) {
  BasisWindow window;
  const int n = set.num_basis;
  const double cycles = t_s / set.period_s;
  const double position = (cycles - std::floor(cycles)) * n;  // centres c_i = 2 pi i / N
  const int centre = static_cast<int>(std::lround(position));
  const double sharpness = n * n / 20.0;
  const int half = std::min(BasisWindow::kHalfWidth, (n - 1) / 2);
  for (int i = centre - half; i <= centre + half; ++i) {
    const double angle = 2.0 * kPi * (position - i) / n;
    window.index[window.count] = static_cast<std::int16_t>((i + n) % n);
    window.activation[window.count++] = std::exp(sharpness * (std::cos(angle) - 1.0));
  }
  normalize(window, 1.0);
  return window;
}

}  // namespace

double PrimitiveSet::tau() const {
  return form == PrimitiveForm::discrete ? duration_s : period_s / (2.0 * kPi);
}

int PrimitiveSet::duration_ticks() const {
  return static_cast<int>(std::lround(duration_s / kPrimitiveStep_s));
}

model::State PrimitiveSet::start_state() const {
  model::State x = model::neutral_state();
  for (int i = 0; i < 3; ++i) {
    x[model::kXPos + i] = scalar[i].start;
    x[model::kXVel + i] = scalar[i].start_rate + scalar[i].drift;
  }
  for (int j = 0; j < model::kNumJoints; ++j) {
    x[model::kXJoint + j] = scalar[3 + j].start;
    x[model::kXJointRate + j] = scalar[3 + j].start_rate + scalar[3 + j].drift;
  }
  x.segment<4>(model::kXQuat) = orientation.start;
  x.segment<3>(model::kXOmega) =
      math::rotation_matrix(orientation.start).transpose() * orientation.start_rate;
  return x;
}

BasisWindow active_basis(const PrimitiveSet& set, double t_s) {
  return set.form == PrimitiveForm::discrete ? discrete_basis(set, t_s / set.duration_s)
                                             : rhythmic_basis(set, t_s);
}

void PrimitivePlayer::reset(const PrimitiveSet& set) {
  set_ = &set;
  tick_ = 0;
  lambda_ = kAlphaZ / (2.0 * set.tau());
  decay_ = std::exp(-lambda_ * kPrimitiveStep_s);
  for (int i = 0; i < kNumScalarPrimitives; ++i) {
    y_[i] = set.scalar[i].start;
    v_[i] = set.scalar[i].start_rate;
  }
  quat_world_base_ = set.orientation.start;
  w_base_in_world_ = set.orientation.start_rate;
  forcing_ = forcing_at(0.0);
  compose_state();
}

void PrimitivePlayer::step() {
  assert(set_ != nullptr);
  const Forcing next = forcing_at((tick_ + 1) * kPrimitiveStep_s);
  for (int i = 0; i < kNumScalarPrimitives; ++i) step_scalar(i, forcing_.scalar[i], next.scalar[i]);
  step_orientation(forcing_.orientation, next.orientation);
  forcing_ = next;
  ++tick_;
  compose_state();
}

PrimitivePlayer::Forcing PrimitivePlayer::forcing_at(double t_s) const {
  Forcing forcing;
  const BasisWindow window = active_basis(*set_, t_s);
  for (int k = 0; k < window.count; ++k) {
    const int i = window.index[k];
    for (int dof = 0; dof < kNumScalarPrimitives; ++dof) {
      forcing.scalar[dof] += window.activation[k] * set_->scalar[dof].weights[i];
    }
    const auto& w = set_->orientation.weights[i];
    forcing.orientation += window.activation[k] * math::Vec3(w[0], w[1], w[2]);
  }
  const double scale = 1.0 / (set_->tau() * set_->tau());
  for (double& f : forcing.scalar) f *= scale;
  forcing.orientation *= scale;
  return forcing;
}

/// e'' + 2 lambda e' + lambda^2 e = a0 + (a1 - a0) t / h with e = y - g, solved exactly over the
/// tick:
/// e(t) = (A + B t) exp(-lambda t) + c0 + c1 t.
void PrimitivePlayer::step_scalar(int i, double a0, double a1) {
  constexpr double h = kPrimitiveStep_s;
  const double slope = (a1 - a0) / h;
  const double c1 = slope / (lambda_ * lambda_);
  const double c0 = (a0 - 2.0 * slope / lambda_) / (lambda_ * lambda_);
  const double A = y_[i] - set_->scalar[i].goal - c0;
  const double B = v_[i] - c1 + lambda_ * A;
  y_[i] = set_->scalar[i].goal + (A + B * h) * decay_ + c0 + c1 * h;
  v_[i] = (B - lambda_ * (A + B * h)) * decay_ + c1;
}

void PrimitivePlayer::step_orientation(const math::Vec3& a0, const math::Vec3& a1) {
  for (int k = 0; k < kInnerSteps; ++k) {
    const math::Vec3 a = a0 + (a1 - a0) * ((k + 0.5) / kInnerSteps);
    const math::Vec3 error_in_world = math::quat_log(
        math::quat_multiply(set_->orientation.goal, math::quat_conjugate(quat_world_base_)));
    // implicit in the damping, so that short periods stay stable
    const math::Vec3 w = w_base_in_world_ + kInnerStep_s * (lambda_ * lambda_ * error_in_world + a);
    w_base_in_world_ = w / (1.0 + 2.0 * lambda_ * kInnerStep_s);
    quat_world_base_ = math::quat_normalized(
        math::quat_multiply(math::quat_exp(kInnerStep_s * w_base_in_world_), quat_world_base_));
  }
}

void PrimitivePlayer::compose_state() {
  const double t = time_s();
  for (int i = 0; i < 3; ++i) {
    x_[model::kXPos + i] = y_[i] + set_->scalar[i].drift * t;
    x_[model::kXVel + i] = v_[i] + set_->scalar[i].drift;
  }
  for (int j = 0; j < model::kNumJoints; ++j) {
    x_[model::kXJoint + j] = y_[3 + j] + set_->scalar[3 + j].drift * t;
    x_[model::kXJointRate + j] = v_[3 + j] + set_->scalar[3 + j].drift;
  }
  x_.segment<4>(model::kXQuat) = quat_world_base_;
  x_.segment<3>(model::kXOmega) =
      math::rotation_matrix(quat_world_base_).transpose() * w_base_in_world_;
}

}  // namespace sanso::policy
