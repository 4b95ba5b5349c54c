// Follows recordings of one robot in step, one a lane: servos and transmissions move as the joints
// were measured, so that what they remember is known at any row.
#pragma once

#include "tools/diagnose/sim/actuator.h"
#include "tools/diagnose/sim/integrator.h"

namespace sanso::diagnose::SANSO_ISA {

template <class T>
class FollowRun {
 public:
  static constexpr std::size_t kLanes = Kind<T>::kLanes;

  /// Lanes beyond `count` (at least 1) repeat the last recording and write nothing.
  FollowRun(const FollowFigures* recordings, std::size_t count, const FollowedJoints& serves)
      : f_(*recordings->figures), serves_(serves), count_(count), integrator_(f_) {
    for (std::size_t i = 0; i < kLanes; ++i) {
      lane_[i].recording = recordings + (i < count ? i : count - 1);
      lane_[i].row = lane_[i].recording->first;
      for (std::size_t k = 0; k < kMaxJoints; ++k) lane_[i].cursor[k] = CommandPath::kUnset;
      for (std::size_t n = 0; n < f_.joint_count; ++n) {
        const std::size_t k = f_.simulated[n];
        integrator_.set_gains(i, k, lane_[i].joints()[k]);
      }
      integrator_.set_bodies(i, *lane_[i].recording->figures);
    }
    integrator_.settle_bodies();
  }

  /// Inner states at the wanted rows of every recording, to where they go.
  void write_wanted() {
    run([this](std::size_t i, std::size_t row) {
      Lane& lane = lane_[i];
      const FollowFigures& r = *lane.recording;
      for (; lane.written < r.wanted_count && r.wanted[lane.written] == row; ++lane.written) {
        for (std::size_t n = 0; n < f_.joint_count; ++n) {
          const std::size_t k = f_.simulated[n];
          copy_inner(i, k, r.out[lane.written * f_.n + k]);
        }
      }
    });
  }

  /// Torques of every step that ends at a row, and nothing at the first.
  void write_torques() {
    run([this](std::size_t i, std::size_t row) {
      const FollowFigures& r = *lane_[i].recording;
      for (std::size_t n = 0; n < f_.joint_count; ++n) {
        const std::size_t k = f_.simulated[n], at = k * r.figures->rows + row;
        r.torques.motor[at] = of_lane(i, torques_.servo[k].torque);
        r.torques.friction[at] = of_lane(i, torques_.friction[k]);
        r.torques.passive[at] = of_lane(i, torques_.passive[k]);
        r.torques.current[at] = of_lane(i, torques_.servo[k].current);
        r.torques.duty[at] = of_lane(i, torques_.servo[k].duty);
      }
    });
  }

 private:
  static double of_lane(std::size_t i, T x) {
    double all[kLanes];
    store(x, all);
    return all[i];
  }

  /// Calls at_row(lane, row) at every row that is followed, of every recording.
  template <class AtRow>
  void run(const AtRow& at_row) {
    begin();
    for (std::size_t i = 0; i < count_; ++i) at_row(i, lane_[i].row);
    while (schedule()) {
      step();
      for (std::size_t i = 0; i < count_; ++i) {
        if (lane_[i].at_row) at_row(i, lane_[i].row);
      }
    }
  }
  /// One recording on its own clock.
  struct Lane {
    const FollowFigures* recording = nullptr;
    std::size_t row = 0, written = 0;
    double s = 0.0, steps = 0.0, h = 0.0;  // step of the row, how many it has, s
    bool at_row = true, ended = false;
    std::size_t cursor[kMaxJoints];
    const double* t() const { return recording->figures->t; }
    const JointParams* joints() const { return recording->figures->joints; }
  };

  void begin() {
    double start[kLanes];
    for (std::size_t i = 0; i < kLanes; ++i) start[i] = lane_[i].t()[lane_[i].row];
    T t;
    load(start, t);
    integrator_.restart(t);
    snap();
    for (std::size_t n = 0; n < f_.joint_count; ++n) {
      const std::size_t k = f_.simulated[n];
      state_.inner[k].velocity_channel = state_.dq[k];
    }
    settle(t);
  }

  /// Inner states of servos that held this posture before (their integral).
  void settle(T t) {
    const double supply = 1.0 + f_.params->supply_level;
    const T* held = integrator_.held(t, state_);
    for (std::size_t n = 0; n < serves_.count; ++n) {
      const std::size_t k = serves_.joint[n];
      double x[kLanes];
      store(held[k], x);
      for (std::size_t i = 0; i < kLanes; ++i)
        x[i] = settled_integral(lane_[i].joints()[k], x[i], supply, f_.params->settings.held);
      load(x, state_.inner[k].integral);
    }
  }

  /// On to the next step of every lane. False: every recording has ended.
  bool schedule() {
    bool runs = false;
    for (std::size_t i = 0; i < kLanes; ++i) {
      Lane& lane = lane_[i];
      if (lane.at_row && !lane.ended) {
        lane.ended = lane.row >= lane.recording->last;
        if (!lane.ended) {
          const double span = lane.t()[lane.row + 1] - lane.t()[lane.row];
          lane.steps = __builtin_ceil(span / f_.max_step - 1e-9);
          if (lane.steps < 1.0) lane.steps = 1.0;
          lane.h = span / lane.steps;
          lane.s = 0.0;
        }
      }
      lane.at_row = false;
      runs = runs || !lane.ended;
    }
    return runs;
  }

  void step() {
    double t[kLanes], h[kLanes];
    for (std::size_t i = 0; i < kLanes; ++i) {
      const Lane& lane = lane_[i];
      t[i] = lane.t()[lane.row] + (lane.ended ? 0.0 : lane.s * lane.h);
      h[i] = lane.ended ? f_.max_step : lane.h;  // goes on unseen as long as others run
    }
    for (std::size_t n = 0; n < serves_.count; ++n) take_row(serves_.joint[n], t, h);
    for (std::size_t n = 0; serves_.gears && n < f_.joint_count; ++n) accelerate(f_.simulated[n]);
    T from, span;
    load(t, from), load(h, span);
    integrator_.follow(from, span, command_, end_, ddq_, serves_.joint, serves_.count,
                       serves_.gears, state_, torques_);
    for (std::size_t i = 0; i < kLanes; ++i) {
      Lane& lane = lane_[i];
      if (lane.ended) continue;
      lane.s += 1.0;
      lane.at_row = lane.s == lane.steps;
      if (lane.at_row) ++lane.row;
    }
    snap();
  }

  /// Joint k's command over the step from t [s] on, h [s] long, and the speed at its end.
  void take_row(std::size_t k, const double* t, const double* h) {
    double end[kLanes], value[kLanes], rate[kLanes], off[kLanes];
    for (std::size_t i = 0; i < kLanes; ++i) {
      Lane& lane = lane_[i];
      const double* dq = lane.recording->dq[k];
      if (lane.ended) {
        end[i] = dq[lane.row];
        value[i] = rate[i] = 0.0;
        off[i] = 1.0;
        continue;
      }
      const double share = (lane.s + 1.0) / lane.steps;
      end[i] = (1.0 - share) * dq[lane.row] + share * dq[lane.row + 1];
      const CommandOf<double> c =
          command_over(*lane.recording->figures, k, t[i], t[i] + h[i], lane.cursor[k]);
      value[i] = c.off ? 0.0 : c.value;
      rate[i] = c.off ? 0.0 : c.rate;
      off[i] = c.off ? 1.0 : 0.0;
    }
    T is_off;
    load(end, end_[k]);
    load(value, command_[k].value);
    load(rate, command_[k].rate);
    load(off, is_off);
    command_[k].off = FlagOf<T>(is_off);
  }

  /// Joint k's acceleration between the rows around the step.
  void accelerate(std::size_t k) {
    double ddq[kLanes];
    for (std::size_t i = 0; i < kLanes; ++i) {
      const Lane& lane = lane_[i];
      const double* dq = lane.recording->dq[k];
      ddq[i] = lane.ended ? 0.0 : (dq[lane.row + 1] - dq[lane.row]) / (lane.steps * lane.h);
    }
    load(ddq, ddq_[k]);
  }

  /// Lanes at a row: their joints as they were measured there, on the link's side.
  void snap() {
    for (std::size_t n = 0; n < f_.joint_count; ++n) {
      const std::size_t k = f_.simulated[n];
      const JointParams& joint = f_.joints[k];
      double q[kLanes], dq[kLanes], offset[kLanes], speed_offset[kLanes];
      store(state_.q[k], q), store(state_.dq[k], dq);
      store(state_.inner[k].motor_offset, offset);
      store(state_.inner[k].motor_speed_offset, speed_offset);
      for (std::size_t i = 0; i < kLanes; ++i) {
        const Lane& lane = lane_[i];
        if (!lane.at_row) continue;
        q[i] = position_for_reading(joint, lane.recording->q[k][lane.row]);
        dq[i] = lane.recording->dq[k][lane.row] / encoder_slope(joint, q[i]);
        if (joint.encoder_at_motor) q[i] -= offset[i], dq[i] -= speed_offset[i];
      }
      load(q, state_.q[k]), load(dq, state_.dq[k]);
    }
  }

  void copy_inner(std::size_t i, std::size_t k, InnerStateOf<double>& to) const {
    const InnerStateOf<T>& in = state_.inner[k];
    const auto of = [i](T x) { return of_lane(i, x); };
    to.motor_offset = of(in.motor_offset);
    to.motor_speed_offset = of(in.motor_speed_offset);
    to.bristle = of(in.bristle);
    for (std::size_t s = 0; s < kSlipElements; ++s) to.slip[s] = of(in.slip[s]);
    to.integral = of(in.integral);
    to.filtered = of(in.filtered);
    to.profile = of(in.profile);
    to.profile_speed = of(in.profile_speed);
    to.profile_set = of(T(in.profile_set)) != 0.0;
    to.rest_time = of(in.rest_time);
    to.heat = of(in.heat);
    to.velocity_channel = of(in.velocity_channel);
  }

  // of the first; all are alike but for time, motion, commands, gains and bodies
  const SimFigures& f_;
  const FollowedJoints serves_;
  const std::size_t count_;
  Integrator<T> integrator_;
  Lane lane_[kLanes];
  RobotStateOf<T> state_{};
  StepTorquesOf<T> torques_{};
  CommandOf<T> command_[kMaxJoints];
  T end_[kMaxJoints];  // rad/s
  T ddq_[kMaxJoints];  // rad/s^2
};

}  // namespace sanso::diagnose::SANSO_ISA
