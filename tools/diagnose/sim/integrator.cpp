// Free motion by the implicit equation of each branch, then dry friction by projected
// Gauss-Seidel on the same inertia.
#include "tools/diagnose/sim/integrator.h"

#include <algorithm>
#include <cmath>

namespace sanso::diagnose {
namespace {

// K/W, winding to case of a small servo; chosen, only scales `derating`
constexpr double kThermalResistance = 8.0;
constexpr double kThermalTime = 300.0;  // s
// projected Gauss-Seidel; joints couple weakly, 3 to 6 are typical
constexpr int kFrictionSweeps = 30;
constexpr double kInertiaFloor = 1e-9;  // kg m^2: links without inertia still move
constexpr double kFastest = 1e4;        // rad/s: beyond it the motion has diverged
// s; a joint at 5 rad/s turns 3 degrees, inertia and load change by percents
constexpr double kTreeRefresh = 0.01;

bool needs_heat(const SimParams& params) {
  return std::any_of(params.joints.begin(), params.joints.end(), [](const JointParams& j) {
    return j.derating != 0.0 || j.friction_temperature != 0.0;
  });
}

/// Inverse of the symmetric positive definite block [b, e) given by its lower triangle; in place
/// scratch L.
void invert_block(JointMatrix& L, JointMatrix& inverse, int b, int e) {
  const auto at = [](int i, int j) {
    return static_cast<std::size_t>(i) * kMaxJoints + static_cast<std::size_t>(j);
  };
  if (e - b == 1) {
    inverse[at(b, b)] = 1.0 / std::max(L[at(b, b)], kInertiaFloor);
    return;
  }
  for (int j = b; j < e; ++j) {  // Cholesky
    for (int i = j; i < e; ++i) {
      double sum = L[at(i, j)];
      for (int k = b; k < j; ++k) sum -= L[at(i, k)] * L[at(j, k)];
      // the diagonal holds reciprocals: one division a joint
      L[at(i, j)] = i == j ? 1.0 / std::sqrt(std::max(sum, kInertiaFloor)) : sum * L[at(j, j)];
    }
  }
  for (int j = b; j < e; ++j) {  // inverse of L, then L^-T L^-1
    for (int i = j + 1; i < e; ++i) {
      double sum = 0.0;
      for (int k = j; k < i; ++k) sum -= L[at(i, k)] * L[at(k, j)];
      L[at(i, j)] = sum * L[at(i, i)];
    }
  }
  for (int i = b; i < e; ++i) {
    for (int j = b; j <= i; ++j) {
      double sum = 0.0;
      for (int k = i; k < e; ++k) sum += L[at(k, i)] * L[at(k, j)];
      inverse[at(i, j)] = inverse[at(j, i)] = sum;
    }
  }
}

}  // namespace

Integrator::Integrator(const SimParams& params, const Drive& drive, std::uint64_t random_seed,
                       const std::vector<char>& wanted)
    : params_(params),
      drive_(drive),
      commands_(params, drive, random_seed),
      n_(params.size()),
      any_sag_(params.supply_resistance > 0.0),
      thermal_(needs_heat(params)) {
  temperature_cursor_.assign(static_cast<std::size_t>(n_), 0);
  for (int j = 0; j < n_; ++j) {
    const std::vector<double>& temp = drive.joints[static_cast<std::size_t>(j)].temp;
    const auto first =
        std::find_if(temp.begin(), temp.end(), [](double T) { return std::isfinite(T); });
    first_temperature_.push_back(first == temp.end() ? std::nan("") : *first);
  }
  update_bodies(drive.t.empty() ? 0.0 : drive.t.front());
  for (int b = 0; b < tree_->branches(); ++b) {
    const int begin = tree_->branch_begin(b), end = tree_->branch_begin(b + 1);
    const bool any =
        wanted.empty() || any_sag_ ||
        std::any_of(wanted.begin() + begin, wanted.begin() + end, [](char w) { return w != 0; });
    if (!any) continue;
    branches_.push_back(b);
    for (int j = begin; j < end; ++j) joints_.push_back(j);
  }
}

void Integrator::restart(double t) {
  commands_.rewind();
  const auto after = std::upper_bound(drive_.t.begin(), drive_.t.end(), t);
  const auto row =
      after == drive_.t.begin() ? 0 : static_cast<std::size_t>(after - drive_.t.begin()) - 1;
  temperature_cursor_.assign(temperature_cursor_.size(), row);
  change_.fill(0.0);
  supply_current_ = 0.0;
  tree_time_ = -kNone;
  update_bodies(t);
}

void Integrator::update_bodies(double t) {
  int on = 0;
  for (const LatePayload& p : params_.late_payloads) on += t >= p.from_s ? 1 : 0;
  if (on != payloads_on_) {
    RobotTree tree = params_.tree;
    for (const LatePayload& p : params_.late_payloads) {
      if (t >= p.from_s) add_body(tree.joints[static_cast<std::size_t>(p.joint)].body, p.body);
    }
    tree_ = std::make_unique<TreeDynamics>(tree, params_.gravity);
    payloads_on_ = on;
  }
  if (params_.forces.empty()) return;
  for (const WorldForce& f : params_.forces) tree_->set_world_force(f.joint, {0, 0, 0});
  for (const WorldForce& f : params_.forces) {
    if (t >= f.from_s && t < f.until_s) tree_->add_world_force(f.joint, f.force);
  }
}

double Integrator::warming_of(int joint, double t, const InnerState& inner) const {
  if (!thermal_) return 0.0;
  const auto j = static_cast<std::size_t>(joint);
  if (!std::isfinite(first_temperature_[j])) return inner.heat;
  const std::vector<double>& temp = drive_.joints[j].temp;
  std::size_t& k = temperature_cursor_[j];
  while (k + 1 < drive_.t.size() && drive_.t[k + 1] <= t) ++k;
  return std::isfinite(temp[k]) ? temp[k] - first_temperature_[j] : 0.0;
}

void Integrator::move_tree(double t, double h, const RobotState& state) {
  for (const int j : joints_) {
    const auto k = static_cast<std::size_t>(j);
    q_half_[k] = state.q[k] + 0.5 * h * state.dq[k];
    // the last change, extrapolated: centrifugal terms at mid-step
    dq_mid_[k] = state.dq[k] + 0.5 * change_[k];
  }
  if (!params_.late_payloads.empty() || !params_.forces.empty()) update_bodies(t);
  for (const int b : branches_) {
    tree_->set_positions(q_half_.data(), b);
    tree_->mass_matrix(M_, b);
    tree_->bias(dq_mid_.data(), bias_, b);
  }
}

void Integrator::prepare(double t, double h, const std::vector<int>& serves, RobotState& state,
                         StepTorques& out) {
  const double supply =
      1.0 + params_.supply_level + params_.supply_slope * (t - drive_.t.front()) / 60.0;
  const double drop = any_sag_ ? params_.supply_resistance * supply_current_ : 0.0;
  double drawn = 0.0;
  for (const int j : serves) {
    const auto k = static_cast<std::size_t>(j);
    const JointParams& joint = params_.joints[k];
    InnerState& inner = state.inner[k];
    const double warming = warming_of(j, t, inner);
    const double motor_half = q_half_[k] + inner.motor_offset + 0.5 * h * inner.motor_speed_offset;
    const double motor_velocity = state.dq[k] + inner.motor_speed_offset;
    const bool at_motor = joint.encoder_at_motor;
    const double side = at_motor ? motor_half : q_half_[k];
    // feedback that crosses from link to motor is explicit: at mid-step, extrapolated, it stays
    // second order
    const double link_velocity = is_two_mass(joint) ? dq_mid_[k] : state.dq[k];
    out.servo[k] = servo_step(
        joint,
        {commands_.over(j, t, t + h), h, encoder_reading(joint, side),
         at_motor ? motor_velocity : link_velocity, motor_velocity, supply, drop, warming},
        inner);
    drawn += std::abs(out.servo[k].current * out.servo[k].duty);
    if (thermal_) {
      const double i = out.servo[k].current;
      inner.heat +=
          h * (kThermalResistance * joint.nominal.resistance * i * i - inner.heat) / kThermalTime;
    }
    const double M_jj = M_[k * kMaxJoints + k];
    instant_[k] = {h, q_half_[k], state.dq[k], std::max(M_jj, kInertiaFloor), -bias_[k], warming};
    part_[k] = transmission_step(joint, out.servo[k], instant_[k], inner);
  }
  supply_current_ = drawn;
}

void Integrator::solve_free(double h, const RobotState& state) {
  for (const int j : joints_) {
    const auto k = static_cast<std::size_t>(j);
    M_[k * kMaxJoints + k] += part_[k].added;
  }
  for (const int branch : branches_) {
    const int b = tree_->branch_begin(branch), e = tree_->branch_begin(branch + 1);
    invert_block(M_, inverse_, b, e);
    for (int i = b; i < e; ++i) {
      double sum = 0.0;
      for (int j = b; j < e; ++j) {
        const auto k = static_cast<std::size_t>(j);
        sum += inverse_[static_cast<std::size_t>(i) * kMaxJoints + k] *
               (part_[k].impulse - h * bias_[k]);
      }
      dq_end_[static_cast<std::size_t>(i)] = state.dq[static_cast<std::size_t>(i)] + sum;
    }
  }
}

void Integrator::solve_friction() {
  // friction impulses f stop the coordinate they act on, or give all they can: a box-constrained
  // linear complementarity problem in y = y0 + mobility f + coupling dq', solved by projected
  // Gauss-Seidel
  friction_.fill(0.0);
  for (const int branch : branches_) {
    const int b = tree_->branch_begin(branch), e = tree_->branch_begin(branch + 1);
    for (int sweep = 0; sweep < kFrictionSweeps; ++sweep) {
      double largest = 0.0;
      for (int j = b; j < e; ++j) {
        const auto k = static_cast<std::size_t>(j);
        const JointPart& p = part_[k];
        if (p.f_max <= 0.0 && p.f_min >= 0.0) continue;
        const double response = p.mobility + p.coupling * p.coupling * inverse_[k * kMaxJoints + k];
        const double y = p.y0 + p.mobility * friction_[k] + p.coupling * dq_end_[k];
        const double wanted = std::clamp(friction_[k] - y / response, p.f_min, p.f_max);
        const double change = wanted - friction_[k];
        if (change == 0.0) continue;
        friction_[k] = wanted;
        largest = std::max(largest, std::abs(change) * response);
        for (int i = b; i < e; ++i) {
          dq_end_[static_cast<std::size_t>(i)] +=
              inverse_[static_cast<std::size_t>(i) * kMaxJoints + k] * p.coupling * change;
        }
      }
      if (largest < 1e-9 || e - b == 1) break;
    }
  }
}

void Integrator::finish(double h, const JointVector& dq_end, const std::vector<int>& serves,
                        RobotState& state, StepTorques& out) {
  for (const int j : serves) {
    const auto k = static_cast<std::size_t>(j);
    const JointPart& part = part_[k];
    finish_transmission(params_.joints[k], instant_[k], part, dq_end[k], friction_[k],
                        state.inner[k]);
    change_[k] = dq_end[k] - state.dq[k];
    state.q[k] += 0.5 * h * (state.dq[k] + dq_end[k]);
    state.dq[k] = dq_end[k];
    out.friction[k] = friction_[k] / h;
    out.passive[k] = part.passive_torque;
    // the velocity channel follows the encoder's side through its filter
    InnerState& inner = state.inner[k];
    const JointParams& joint = params_.joints[k];
    const double shown = dq_end[k] + (joint.encoder_at_motor ? inner.motor_speed_offset : 0.0);
    inner.velocity_channel = joint.velocity_filter > 0.0
                                 ? inner.velocity_channel + h / (joint.velocity_filter + h) *
                                                                (shown - inner.velocity_channel)
                                 : shown;
  }
}

bool Integrator::step(double t, double h, RobotState& state, StepTorques& out) {
  move_tree(t, h, state);
  prepare(t, h, joints_, state, out);
  solve_free(h, state);
  solve_friction();
  for (const int j : joints_) {
    if (!(std::abs(dq_end_[static_cast<std::size_t>(j)]) < kFastest)) return false;
  }
  finish(h, dq_end_, joints_, state, out);
  return true;
}

void Integrator::settle(double t, const std::vector<int>& serves, RobotState& state) {
  const double supply = 1.0 + params_.supply_level;
  move_tree(t, 0.0, state);
  for (const int j : serves) {
    const auto k = static_cast<std::size_t>(j);
    settle_integral(params_.joints[k], bias_[k], supply, state.inner[k]);
  }
}

void Integrator::follow(double t, double h, const double* dq_end, const std::vector<int>& serves,
                        RobotState& state, StepTorques& out) {
  if (t >= tree_time_ + kTreeRefresh) {
    move_tree(t, h, state);
    tree_time_ = t;
  }
  JointVector end;
  for (const int j : serves) {
    const auto k = static_cast<std::size_t>(j);
    q_half_[k] = state.q[k] + 0.5 * h * state.dq[k];
    dq_mid_[k] = state.dq[k] + 0.5 * change_[k];
  }
  prepare(t, h, serves, state, out);
  for (const int j : serves) {
    const auto k = static_cast<std::size_t>(j);
    end[k] = dq_end[k];
    const JointPart& p = part_[k];
    if (p.two_mass) {  // the motor still chooses its own velocity
      const double y = p.y0 + p.coupling * end[k];
      friction_[k] = std::clamp(-y / p.mobility, p.f_min, p.f_max);
    } else {  // what friction gives against the motion that was seen
      const double y = 0.5 * (state.dq[k] + end[k]);
      const double inertia = M_[k * kMaxJoints + k] + p.added;
      friction_[k] = std::clamp(-y * inertia, p.f_min, p.f_max);
    }
  }
  finish(h, end, serves, state, out);
}

}  // namespace sanso::diagnose
