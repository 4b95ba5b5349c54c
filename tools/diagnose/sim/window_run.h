// Runs several windows of one recording in step, one a lane, and writes each joint's channels at
// the instants its sensor samples.
#pragma once

#include "tools/diagnose/sim/integrator.h"
#include "tools/diagnose/sim/lane_clocks.h"

namespace sanso::diagnose::SANSO_ISA {

template <class T>
class WindowRun {
 public:
  explicit WindowRun(const SimFigures& figures)
      : f_(figures), integrator_(figures), clocks_(figures) {}

  /// Lanes beyond `count` (at least 1) repeat the last window and write nothing.
  void run(const WindowFigures* windows, std::size_t count) {
    place(windows, count);
    if (f_.longest_sensor_delay == 0.0) emit_start();  // row `first` is the start itself
    while (clocks_.schedule()) advance();
  }

 private:
  static constexpr std::size_t kLanes = Kind<T>::kLanes;

  /// What a reading inside a step needs of the step's start.
  struct Before {
    T q, dq, motor_offset, motor_speed_offset, velocity_channel;
  };
  struct Efforts {
    T torque, current, duty, volt;
  };
  static MaskOf<T> all() { return no_more(T(0.0), T(0.0)); }
  double delay(std::size_t k) const { return f_.sensor_delay[k]; }

  /// Starts of the windows: the joints `delay` seconds before the first row.
  void place(const WindowFigures* windows, std::size_t count) {
    double x[kLanes];
    for (std::size_t i = 0; i < kLanes; ++i) {
      const WindowFigures& w = window_[i] = windows[i < count ? i : count - 1];
      rows_[i] = w.last - w.first + 1;
      clocks_.place(i, f_.t[w.first] - f_.longest_sensor_delay, f_.t[w.last]);
    }
    clocks_.begin();
    const auto gather = [&](auto&& of) {
      for (std::size_t i = 0; i < kLanes; ++i) x[i] = of(window_[i]);
      T out;
      load(x, out);
      return out;
    };
    for (std::size_t n = 0; n < f_.joint_count; ++n) {
      const std::size_t k = f_.simulated[n];
      state_.q[k] = gather([k](const WindowFigures& w) { return w.q[k]; });
      state_.dq[k] = gather([k](const WindowFigures& w) { return w.dq[k]; });
      place_inner(k, gather, state_.inner[k]);
      torques_.servo[k] = {};
      for (std::size_t i = 0; i < kLanes; ++i)
        next_[k][i] = next_effort_[k][i] = i < count ? 0 : kAll;
      set_instants(k, next_, instant_[k]);
      set_instants(k, next_effort_, effort_instant_[k]);
    }
    alive_ = all();
    keep_state();
    integrator_.restart(clocks_.now());
  }

  template <class Gather>
  void place_inner(std::size_t k, const Gather& gather, InnerStateOf<T>& to) {
    const auto of = [&](auto member) {
      return gather(
          [k, member](const WindowFigures& w) { return static_cast<double>(w.inner[k].*member); });
    };
    using Inner = InnerStateOf<double>;
    to.motor_offset = of(&Inner::motor_offset);
    to.motor_speed_offset = of(&Inner::motor_speed_offset);
    to.bristle = of(&Inner::bristle);
    for (std::size_t s = 0; s < kSlipElements; ++s)
      to.slip[s] = gather([k, s](const WindowFigures& w) { return w.inner[k].slip[s]; });
    to.integral = of(&Inner::integral);
    to.filtered = of(&Inner::filtered);
    to.profile = of(&Inner::profile);
    to.profile_speed = of(&Inner::profile_speed);
    to.profile_set = FlagOf<T>(of(&Inner::profile_set));
    to.rest_time = of(&Inner::rest_time);
    to.heat = of(&Inner::heat);
    to.velocity_channel = of(&Inner::velocity_channel);
  }

  void keep_state() {
    for (std::size_t n = 0; n < f_.joint_count; ++n) {
      const std::size_t k = f_.simulated[n];
      const InnerStateOf<T>& in = state_.inner[k];
      before_[k] = {state_.q[k], state_.dq[k], in.motor_offset, in.motor_speed_offset,
                    in.velocity_channel};
    }
  }

  void advance() {
    keep_state();  // old readings lie inside a step
    clocks_.start_step();
    hold_diverged(
        integrator_.step(clocks_.before(), clocks_.h(), clocks_.commands(), state_, torques_));
    emit_until(clocks_.read_until());
    if (f_.longest_sensor_delay > 0.0) emit_efforts();
    clocks_.end_step();
  }

  /// A motion that diverges is held at its last finite value, and so are its efforts.
  void hold_diverged(MaskOf<T> sound) {
    const MaskOf<T> was_alive = alive_;
    alive_ = both(alive_, sound);
    if (!any(negated(alive_))) return;
    for (std::size_t n = 0; n < f_.joint_count; ++n) {
      const std::size_t k = f_.simulated[n];
      InnerStateOf<T>& in = state_.inner[k];
      const Before& b = before_[k];
      state_.q[k] = choose(alive_, state_.q[k], b.q);
      state_.dq[k] = choose(alive_, state_.dq[k], b.dq);
      in.motor_offset = choose(alive_, in.motor_offset, b.motor_offset);
      in.motor_speed_offset = choose(alive_, in.motor_speed_offset, b.motor_speed_offset);
      in.velocity_channel = choose(alive_, in.velocity_channel, b.velocity_channel);
      ServoOutputOf<T>& servo = torques_.servo[k];
      Efforts& held = held_[k];
      held = {choose(was_alive, servo.torque, held.torque),
              choose(was_alive, servo.current, held.current),
              choose(was_alive, servo.duty, held.duty), choose(was_alive, servo.volt, held.volt)};
      servo.torque = held.torque, servo.current = held.current;
      servo.duty = held.duty, servo.volt = held.volt;
    }
  }

  /// First row without any sensor delay: the given state, and what the servo does in the first
  /// instant: a probing step for the torques; the state stays.
  void emit_start() {
    double h[kLanes];
    for (std::size_t i = 0; i < kLanes; ++i) {
      const std::size_t first = window_[i].first;
      const double row = first + 1 < f_.rows ? f_.t[first + 1] - f_.t[first] : f_.max_step;
      h[i] = row < f_.max_step ? row : f_.max_step;
    }
    for (std::size_t n = 0; n < f_.joint_count; ++n) {
      const std::size_t k = f_.simulated[n];
      probe_.q[k] = state_.q[k], probe_.dq[k] = state_.dq[k];
      probe_.inner[k] = state_.inner[k];
    }
    T span;
    load(h, span);
    clocks_.commands_over(clocks_.now(), span, true);
    integrator_.step(clocks_.now(), span, clocks_.commands(), probe_, torques_);
    integrator_.restart(clocks_.now());
    emit_until(clocks_.now());
  }

  /// When the next sample of joint k is read, by lane.
  void set_instants(std::size_t k, const std::size_t (*next)[kLanes], T& instants) {
    double at[kLanes];
    for (std::size_t i = 0; i < kLanes; ++i) {
      at[i] = next[k][i] < rows_[i] ? f_.t[window_[i].first + next[k][i]] - delay(k) : kNone;
    }
    load(at, instants);
  }

  /// Writes every sample whose instant (its time stamp minus the sensor's delay) has been reached,
  /// by cubic interpolation.
  void emit_until(T limit) {
    for (std::size_t n = 0; n < f_.joint_count; ++n) {
      const std::size_t k = f_.simulated[n];
      for (MaskOf<T> now = no_more(instant_[k], limit); any(now);
           now = no_more(instant_[k], limit)) {
        emit(k, now);
        set_instants(k, next_, instant_[k]);
      }
    }
  }

  void emit(std::size_t k, MaskOf<T> now) {
    const JointParams& joint = f_.joints[k];
    const InnerStateOf<T>& inner = state_.inner[k];
    const Before& before = before_[k];
    const T h = clocks_.now() - clocks_.before();
    const T s = choose(less(T(0.0), h),
                       clamped((instant_[k] - clocks_.before()) / h, T(0.0), T(1.0)), T(1.0));
    T side0 = before.q, side1 = state_.q[k], dq0 = before.dq, dq1 = state_.dq[k];
    if (joint.encoder_at_motor) {
      side0 += before.motor_offset, side1 += inner.motor_offset;
      dq0 += before.motor_speed_offset, dq1 += inner.motor_speed_offset;
    }
    // the step is a parabola in position and a line in velocity
    const MaskOf<T> inside = less(s, T(1.0));
    const T position = choose(inside, side0 + h * s * (dq0 + 0.5 * s * (dq1 - dq0)), side1);
    const T velocity =
        choose(inside, (1.0 - s) * before.velocity_channel + s * inner.velocity_channel,
               inner.velocity_channel);
    double q[kLanes], dq[kLanes], writes[kLanes];
    store(encoder_reading(joint, position), q);
    store(velocity * (1.0 + joint.encoder_scale), dq);
    store(choose(now, T(1.0), T(0.0)), writes);
    double efforts[4][kLanes];
    const bool at_once = delay(k) == 0.0;
    if (at_once) {
      const ServoOutputOf<T>& servo = torques_.servo[k];
      store(servo.torque, efforts[0]), store(servo.current, efforts[1]);
      store(servo.duty, efforts[2]), store(servo.volt, efforts[3]);
    }
    for (std::size_t i = 0; i < kLanes; ++i) {
      if (writes[i] == 0.0) continue;
      const std::size_t row = next_[k][i]++, at = k * rows_[i] + row;
      window_[i].out_q[at] = q[i];
      window_[i].out_dq[at] = dq[i];
      if (at_once)
        write_efforts(k, i, row, efforts[0][i], efforts[1][i], efforts[2][i], efforts[3][i]);
    }
  }

  void write_efforts(std::size_t k, std::size_t i, std::size_t row, double torque, double current,
                     double duty, double volt) {
    const WindowFigures& w = window_[i];
    const std::size_t at = k * rows_[i] + row;
    w.out_tau[at] = torque;
    w.out_i[at] = current;
    w.out_pwm[at] = duty;
    if (k == 0) w.out_volt[row] = volt;
  }

  /// Efforts are means over steps: what a delayed sensor reads lies between the middles of two of
  /// them, where the command is the same in both. Where it changes efforts jump, and the reading is
  /// the one before or after; of the two at the same instant, the reading comes before the command.
  void emit_efforts() {
    const T middle = 0.5 * (clocks_.before() + clocks_.now());
    // what is left at a window's end is read there
    const T limit = choose(clocks_.ends_window(), clocks_.read_until(), middle);
    for (std::size_t n = 0; n < f_.joint_count; ++n) {
      const std::size_t k = f_.simulated[n];
      if (delay(k) == 0.0) continue;
      const ServoOutputOf<T>& servo = torques_.servo[k];
      const Efforts now{servo.torque, servo.current, servo.duty, servo.volt};
      if (clocks_.first_step()) efforts_before_[k] = now;
      while (any(no_more(effort_instant_[k], limit))) {
        emit_effort(k, no_more(effort_instant_[k], limit), middle, now);
        set_instants(k, next_effort_, effort_instant_[k]);
      }
      efforts_before_[k] = now;
    }
    middle_before_ = middle;
  }

  void emit_effort(std::size_t k, MaskOf<T> writes, T middle, const Efforts& now) {
    const Efforts& before = efforts_before_[k];
    T s = 1.0;
    if (!clocks_.first_step()) {
      s = (effort_instant_[k] - middle_before_) / (middle - middle_before_);
      const MaskOf<T> after = less(clocks_.before() + kRounding, effort_instant_[k]);
      s = choose(clocks_.changed(), choose(after, T(1.0), T(0.0)), s);
    }
    s = clamped(s, T(0.0), T(1.0));
    const MaskOf<T> between = less(s, T(1.0));
    double out[5][kLanes];
    store(choose(between, before.torque + s * (now.torque - before.torque), now.torque), out[0]);
    store(choose(between, before.current + s * (now.current - before.current), now.current),
          out[1]);
    store(choose(between, before.duty + s * (now.duty - before.duty), now.duty), out[2]);
    store(choose(between, before.volt + s * (now.volt - before.volt), now.volt), out[3]);
    store(choose(writes, T(1.0), T(0.0)), out[4]);
    for (std::size_t i = 0; i < kLanes; ++i) {
      if (out[4][i] == 0.0) continue;
      write_efforts(k, i, next_effort_[k][i]++, out[0][i], out[1][i], out[2][i], out[3][i]);
    }
  }

  static constexpr std::size_t kAll = static_cast<std::size_t>(-1);

  const SimFigures& f_;
  Integrator<T> integrator_;
  LaneClocks<T> clocks_;
  WindowFigures window_[kLanes];
  std::size_t rows_[kLanes];

  RobotStateOf<T> state_, probe_;
  Before before_[kMaxJoints];
  StepTorquesOf<T> torques_;
  Efforts efforts_before_[kMaxJoints], held_[kMaxJoints];
  // by joint and lane, the next row to write, and its instant
  std::size_t next_[kMaxJoints][kLanes], next_effort_[kMaxJoints][kLanes];
  T instant_[kMaxJoints], effort_instant_[kMaxJoints];
  MaskOf<T> alive_;
  T middle_before_;  // s, of the step before
};

}  // namespace sanso::diagnose::SANSO_ISA
