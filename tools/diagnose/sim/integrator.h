// One time step of the whole robot, shared by simulation (the tree moves) and replay (the tree
// follows the recording): free motion by the implicit equation of each branch, then dry friction by
// projected Gauss-Seidel on the same inertia.
#pragma once

#include "tools/diagnose/sim/block_inverse.h"
#include "tools/diagnose/sim/sim_figures.h"
#include "tools/diagnose/sim/transmission_step.h"
#include "tools/diagnose/sim/tree.h"

namespace sanso::diagnose::SANSO_ISA {

template <class T>
struct RobotStateOf {
  T q[kMaxJoints], dq[kMaxJoints];  // link side, rad, rad/s
  InnerStateOf<T> inner[kMaxJoints];
};

/// Torques of the step just taken, by joint.
template <class T>
struct StepTorquesOf {
  ServoOutputOf<T> servo[kMaxJoints];
  T friction[kMaxJoints], passive[kMaxJoints];  // N m, mean over the step
};

template <class T>
class Integrator {
 public:
  explicit Integrator(const SimFigures& figures)
      : f_(figures), settings_(figures.params->settings), tree_(figures.tree) {
    late_payloads_ = f_.late_payloads;
    for (std::size_t lane = 0; lane < kLanes; ++lane) weighs_[lane] = &f_;
    for (std::size_t i = 0; i < f_.joint_count; ++i) {
      const std::size_t k = f_.simulated[i];
      shares_[k] = slip_shares(f_.joints[k]);
      for (std::size_t lane = 0; lane < kLanes; ++lane) set_gains(lane, k, f_.joints[k]);
    }
  }

  /// One lane's servo at joint k has the gains of this joint: all have an integral, or none.
  void set_gains(std::size_t lane, std::size_t k, const JointParams& joint) {
    const GainsOf<double> own = servo_gains(joint);
    GainsOf<T>& to = gains_[k];
    set_lane(to.p, lane, own.p);
    set_lane(to.d, lane, own.d);
    set_lane(to.i, lane, own.i);
    set_lane(to.goal, lane, own.goal);
  }

  /// One lane's links weigh what these figures say; settle_bodies() when all are set.
  void set_bodies(std::size_t lane, const SimFigures& own) {
    weighs_[lane] = &own;
    late_payloads_ = late_payloads_ || own.late_payloads;
    for (std::size_t j = 0; j < f_.n; ++j) tree_.set_body(lane, j, own.tree.body[j]);
  }
  void settle_bodies() { tree_.settle_bodies(); }

  /// Starts anew at any instant (payloads that come late are looked up for it).
  void restart(T t) {
    double at[kLanes];
    store(t, at);
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      payloads_on_[lane] = kUnknown;
      next_change_[lane] = -kNone;
      for (std::size_t j = 0; j < f_.n; ++j) warm_row_[lane][j] = row_at(f_, at[lane]);
    }
    for (std::size_t j = 0; j < f_.n; ++j) change_[j] = 0.0;
    supply_current_ = 0.0;
    tree_time_ = T(-kNone);
    update_bodies(t);
  }

  /// Gravity's torques at a posture at rest, by joint: what servos hold before t.
  const T* held(T t, RobotStateOf<T>& state) {
    move_tree(t, 0.0, state);
    return bias_;
  }

  /// Advances from t by h with these commands, by joint. No: the lane's motion diverged, and its
  /// state is no longer one.
  MaskOf<T> step(T t, T h, const CommandOf<T>* commands, RobotStateOf<T>& state,
                 StepTorquesOf<T>& out) {
    move_tree(t, h, state);
    prepare(t, h, commands, f_.simulated, f_.joint_count, true, state, out);
    solve_free(h, state);
    solve_friction();
    MaskOf<T> sound = no_more(T(0.0), T(0.0));
    for (std::size_t k = 0; k < f_.joint_count; ++k)
      sound = both(sound, less(abs_of(dq_end_[f_.simulated[k]]), T(settings_.diverged)));
    finish(h, dq_end_, f_.simulated, f_.joint_count, true, state, out);
    return sound;
  }

  /// The same with prescribed motion: velocities reach dq_end; only inner states and torques are
  /// computed. The tree's inertia and bias are taken anew every `tree_refresh` only.
  /// `serves`: the joints whose servo and transmission are wanted; not `gears`: the servo alone.
  /// `ddq`: of all joints that are simulated, over the step.
  void follow(T t, T h, const CommandOf<T>* commands, const T* dq_end, const T* ddq,
              const std::size_t* serves, std::size_t count, bool gears, RobotStateOf<T>& state,
              StepTorquesOf<T>& out) {
    if (gears) refresh_tree(t, h, state);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t k = serves[i];
      q_half_[k] = state.q[k] + 0.5 * h * state.dq[k];
      dq_mid_[k] = state.dq[k] + 0.5 * change_[k];
    }
    prepare(t, h, commands, serves, count, gears, state, out);
    for (std::size_t i = 0; gears && i < count; ++i) {
      const std::size_t k = serves[i];
      const JointPartOf<T>& p = part_[k];
      if (p.two_mass) {  // the motor still chooses its own velocity
        const T y = p.y0 + p.coupling * dq_end[k];
        friction_[k] = clamped(-y / (p.mobility + p.slack), p.f_min, p.f_max);
      } else {  // what friction gives against the motion that was seen
        const T y = 0.5 * (state.dq[k] + dq_end[k]);
        const T inertia = M_[k * kMaxJoints + k] + p.added;
        const T pushed = p.creeps ? -y / (1.0 / inertia + p.slack) : -y * inertia;
        friction_[k] = clamped(pushed, p.f_min, p.f_max);
      }
    }
    finish(h, dq_end, serves, count, gears, state, out);
    for (std::size_t i = 0; gears && i < count; ++i) press(serves[i], ddq, state.inner[serves[i]]);
  }

 private:
  static constexpr std::size_t kLanes = Kind<T>::kLanes;
  static constexpr std::size_t kUnknown = static_cast<std::size_t>(-1);

  static void set_lane(T& x, std::size_t lane, double value) {
    double all[kLanes];
    store(x, all);
    all[lane] = value;
    load(all, x);
  }

  void update_bodies(T t) {
    if (!late_payloads_ && !f_.forces) return;
    T next;
    load(next_change_, next);
    if (!any(no_more(next, t))) return;
    double at[kLanes];
    store(t, at);
    bool changed = false;
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      if (at[lane] < next_change_[lane]) continue;
      const SimFigures& own = *weighs_[lane];
      next_change_[lane] = sanso::diagnose::next_change(own, at[lane]);
      if (late_payloads_) {
        const std::size_t on = payloads_on(own, at[lane]);
        if (on != payloads_on_[lane]) {
          BodyFigures bodies[kMaxJoints];
          bodies_at(own, at[lane], bodies);
          for (std::size_t j = 0; j < f_.n; ++j) tree_.set_body(lane, j, bodies[j]);
          payloads_on_[lane] = on;
          changed = true;
        }
      }
      if (f_.forces) {
        double forces[kMaxJoints][3];
        forces_at(f_, at[lane], forces);
        for (std::size_t j = 0; j < f_.n; ++j) tree_.set_force(lane, j, forces[j]);
      }
    }
    if (changed) tree_.settle_bodies();
  }

  /// K above the recording's first temperature; where none was recorded, above the start.
  T warming_of(std::size_t j, T t, const InnerStateOf<T>& inner) {
    if (!f_.heats) return 0.0;
    const double first = f_.first_temperature[j];
    if (!(first == first)) return inner.heat;
    double at[kLanes], out[kLanes];
    store(t, at);
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      std::size_t& k = warm_row_[lane][j];
      while (k + 1 < f_.rows && f_.t[k + 1] <= at[lane]) ++k;
      const double above = f_.temperature[j][k] - first;
      out[lane] = above - above == 0.0 ? above : 0.0;  // not sampled: no warmer
    }
    T warming;
    load(out, warming);
    return warming;
  }

  void move_tree(T t, T h, const RobotStateOf<T>& state) {
    for (std::size_t i = 0; i < f_.joint_count; ++i) {
      const std::size_t k = f_.simulated[i];
      q_half_[k] = state.q[k] + 0.5 * h * state.dq[k];
      // the last change, extrapolated: centrifugal terms at mid-step
      dq_mid_[k] = state.dq[k] + 0.5 * change_[k];
    }
    update_bodies(t);
    for (std::size_t i = 0; i < f_.branch_count; ++i) {
      const std::size_t b = f_.branch[i];
      tree_.set_positions(q_half_, b);
      tree_.mass_matrix(M_, b);
      tree_.bias(dq_mid_, bias_, b);
    }
  }

  /// Inertia and bias anew in the lanes whose last ones are `tree_refresh` old.
  void refresh_tree(T t, T h, const RobotStateOf<T>& state) {
    const MaskOf<T> due = no_more(tree_time_ + settings_.tree_refresh, t);
    if (!any(due)) return;
    const bool all_due = !any(negated(due));
    if (!all_due) each_entry([](T& kept, T& now) { kept = now; });
    move_tree(t, h, state);
    if (!all_due) each_entry([due](T& kept, T& now) { now = choose(due, now, kept); });
    tree_time_ = choose(due, t, tree_time_);
  }
  /// f(as it was, as it is) for inertia and bias of the simulated branches.
  template <class Function>
  void each_entry(const Function& f) {
    for (std::size_t n = 0; n < f_.branch_count; ++n) {
      const std::size_t b = tree_.branch_begin(f_.branch[n]),
                        e = tree_.branch_begin(f_.branch[n] + 1);
      for (std::size_t i = b; i < e; ++i) {
        f(bias_before_[i], bias_[i]);
        for (std::size_t j = b; j < e; ++j)
          f(M_before_[i * kMaxJoints + j], M_[i * kMaxJoints + j]);
      }
    }
  }

  /// Servo and, where `gears`, transmission of `count` joints.
  void prepare(T t, T h, const CommandOf<T>* commands, const std::size_t* serves, std::size_t count,
               bool gears, RobotStateOf<T>& state, StepTorquesOf<T>& out) {
    const SimParams& params = *f_.params;
    const T supply = 1.0 + params.supply_level + params.supply_slope * (t - f_.t[0]) / 60.0;
    T drop = 0.0, drawn = 0.0;
    if (f_.sags) drop = params.supply_resistance * supply_current_;
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t k = serves[i];
      const JointParams& joint = f_.joints[k];
      InnerStateOf<T>& inner = state.inner[k];
      const T warming = warming_of(k, t, inner);
      const T motor_half = q_half_[k] + inner.motor_offset + 0.5 * h * inner.motor_speed_offset;
      const T motor_velocity = state.dq[k] + inner.motor_speed_offset;
      const bool at_motor = joint.encoder_at_motor;
      const T side = at_motor ? motor_half : q_half_[k];
      // feedback that crosses from link to motor is explicit: at mid-step, extrapolated, it stays
      // second order
      const T link_velocity = has_two_masses(joint) ? dq_mid_[k] : state.dq[k];
      const ServoInputOf<T> input{commands[k],
                                  h,
                                  servo_reading(joint, side),
                                  at_motor ? motor_velocity : link_velocity,
                                  motor_velocity,
                                  supply,
                                  drop,
                                  warming,
                                  gains_[k]};
      const ServoOutputOf<T> servo = servo_step(joint, input, inner);
      out.servo[k] = servo;
      drawn += abs_of(servo.current * servo.duty);
      if (f_.heats) {
        inner.heat += h *
                      (settings_.thermal_resistance * joint.nominal.resistance * servo.current *
                           servo.current -
                       inner.heat) /
                      settings_.thermal_time;
      }
      if (!gears) continue;
      const T M_kk = M_[k * kMaxJoints + k];
      const T inertia = max_of(M_kk, T(settings_.least_inertia));
      instant_[k] = {h, q_half_[k], state.dq[k], inertia, -bias_[k], warming};
      part_[k] = transmission_step(joint, shares_[k], servo, instant_[k], inner, settings_);
    }
    supply_current_ = drawn;
  }

  void solve_free(T h, const RobotStateOf<T>& state) {
    for (std::size_t i = 0; i < f_.joint_count; ++i) {
      const std::size_t k = f_.simulated[i];
      M_[k * kMaxJoints + k] += part_[k].added;
    }
    const T least = settings_.least_inertia;
    for (std::size_t n = 0; n < f_.branch_count; ++n) {
      const std::size_t b = tree_.branch_begin(f_.branch[n]),
                        e = tree_.branch_begin(f_.branch[n] + 1);
      invert_block(M_, inverse_, b, e, least);
      for (std::size_t i = b; i < e; ++i) {
        T sum = 0.0;
        for (std::size_t k = b; k < e; ++k)
          sum += inverse_[i * kMaxJoints + k] * (part_[k].impulse - h * bias_[k]);
        dq_end_[i] = state.dq[i] + sum;
      }
    }
  }

  /// Friction impulses f stop the coordinate they act on, or give all they can: a box-constrained
  /// linear complementarity problem in y = y0 + mobility f + coupling dq', solved by projected
  /// Gauss-Seidel. Every lane stops sweeping where it would alone.
  void solve_friction() {
    const T still = settings_.friction_settled;
    const int sweeps = settings_.friction_sweeps;
    for (std::size_t i = 0; i < f_.joint_count; ++i) friction_[f_.simulated[i]] = 0.0;
    for (std::size_t n = 0; n < f_.branch_count; ++n) {
      const std::size_t b = tree_.branch_begin(f_.branch[n]),
                        e = tree_.branch_begin(f_.branch[n] + 1);
      MaskOf<T> moving = no_more(T(0.0), T(0.0));
      for (int sweep = 0; sweep < sweeps; ++sweep) {
        T largest = 0.0;
        for (std::size_t j = b; j < e; ++j) {
          if (part_[j].rubs) largest = max_of(largest, rub(j, b, e, sweep == 0, moving));
        }
        moving = both(moving, negated(less(largest, still)));
        if (e - b == 1 || !any(moving)) break;
      }
    }
  }

  /// Across its play a link has no torque: one that moves, or hangs, as only a torque makes it
  /// leans on the motor's teeth, whatever friction holds the motor.
  void press(std::size_t k, const T* ddq, InnerStateOf<T>& inner) const {
    const double half = 0.5 * f_.joints[k].backlash;
    if (!(half > 0.0)) return;
    T torque = bias_[k];
    for (std::size_t n = 0; n < f_.branch_count; ++n) {
      const std::size_t b = tree_.branch_begin(f_.branch[n]),
                        e = tree_.branch_begin(f_.branch[n] + 1);
      if (k < b || k >= e) continue;
      for (std::size_t i = b; i < e; ++i) torque += M_[in_lower(k, i)] * ddq[i];
    }
    const T side = with_sign(T(1.0), torque);
    const T least = settings_.leaning * M_[k * kMaxJoints + k];
    const MaskOf<T> leans =
        both(less(least, abs_of(torque)), less(side * inner.motor_offset, T(half)));
    inner.motor_offset = choose(leans, side * half, inner.motor_offset);
    inner.motor_speed_offset = choose(leans, T(0.0), inner.motor_speed_offset);
  }

  /// One joint's turn in a sweep of branch [b, e), in `moving` lanes: the change of its speed.
  T rub(std::size_t j, std::size_t b, std::size_t e, bool all, MaskOf<T> moving) {
    const JointPartOf<T>& p = part_[j];
    const T response = p.mobility + p.coupling * p.coupling * inverse_[j * kMaxJoints + j];
    const T y = p.y0 + p.mobility * friction_[j] + p.coupling * dq_end_[j];
    T wanted = friction_[j] - y / response;
    // with slack s friction ends where y' + s f = 0
    if (p.creeps) wanted = wanted * (response / (response + p.slack));
    wanted = clamped(wanted, p.f_min, p.f_max);
    if (!all) wanted = choose(moving, wanted, friction_[j]);
    const T change = wanted - friction_[j];
    friction_[j] = wanted;
    for (std::size_t i = b; i < e; ++i)
      dq_end_[i] += inverse_[i * kMaxJoints + j] * p.coupling * change;
    return abs_of(change) * response;
  }

  void finish(T h, const T* dq_end, const std::size_t* serves, std::size_t count, bool gears,
              RobotStateOf<T>& state, StepTorquesOf<T>& out) {
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t k = serves[i];
      const JointParams& joint = f_.joints[k];
      InnerStateOf<T>& inner = state.inner[k];
      if (gears) {
        finish_transmission(joint, shares_[k], instant_[k], part_[k], dq_end[k], friction_[k],
                            settings_, inner);
        out.friction[k] = friction_[k] / h;
        out.passive[k] = part_[k].passive_torque;
      }
      change_[k] = dq_end[k] - state.dq[k];
      state.q[k] += 0.5 * h * (state.dq[k] + dq_end[k]);
      state.dq[k] = dq_end[k];
      // the velocity channel follows the encoder's side through its filter
      T shown = dq_end[k];
      if (joint.encoder_at_motor) shown += inner.motor_speed_offset;
      if (joint.velocity_filter > 0.0) {
        inner.velocity_channel +=
            h / (joint.velocity_filter + h) * (shown - inner.velocity_channel);
      } else {
        inner.velocity_channel = shown;
      }
    }
  }

  const SimFigures& f_;
  const SimulationSettings settings_;  // a copy: nothing that a step writes can change it
  Tree<T> tree_;
  GainsOf<T> gains_[kMaxJoints];
  const SimFigures* weighs_[kLanes];  // whose bodies and late payloads the lane has
  bool late_payloads_ = false;        // some lane has
  std::size_t payloads_on_[kLanes];
  double next_change_[kLanes];  // s, of payloads and forces
  std::size_t warm_row_[kLanes][kMaxJoints];

  // scratch of the step
  T M_[kMaxJoints * kMaxJoints], inverse_[kMaxJoints * kMaxJoints];
  T bias_[kMaxJoints], q_half_[kMaxJoints], dq_mid_[kMaxJoints], dq_end_[kMaxJoints],
      change_[kMaxJoints], friction_[kMaxJoints];
  SlipShares shares_[kMaxJoints];
  JointPartOf<T> part_[kMaxJoints];
  JointInstantOf<T> instant_[kMaxJoints];
  T supply_current_ = 0.0;  // A, of the step before
  // while following: instant [s] of the tree's inertia and bias, and what they were before
  T tree_time_ = T(-kNone);
  T M_before_[kMaxJoints * kMaxJoints], bias_before_[kMaxJoints];
};

}  // namespace sanso::diagnose::SANSO_ISA
