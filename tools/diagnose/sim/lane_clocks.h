// The clocks of several windows that run in step, and the commands that arrive meanwhile: every
// lane keeps its own time, so windows need neither begin nor end together, nor have the same steps.
#pragma once

#include "tools/diagnose/sim/lane_math.h"
#include "tools/diagnose/sim/sim_figures.h"

namespace sanso::diagnose::SANSO_ISA {

constexpr double kRounding = 1e-9;  // s: instants that are the same

/// Steps between changes of the command, in lanes.
template <class T>
class LaneClocks {
 public:
  static constexpr std::size_t kLanes = Kind<T>::kLanes;

  explicit LaneClocks(const SimFigures& figures) : f_(figures) {
    if (f_.joint_count > 0) command_delay_ = f_.command_delay[f_.simulated[0]];
  }

  /// Lane i runs from `start` to `end`, s.
  void place(std::size_t i, double start, double end) {
    Lane& lane = lane_[i];
    lane.t = start_[i] = start;
    lane.end = end;
    const double arrived = start - command_delay_ + kRounding;
    lane.change = f_.t[0] > arrived ? 0 : row_at(f_, arrived) + 1;
    lane.ended = false;
  }
  /// All lanes are placed.
  void begin() {
    load(start_, now_);
    before_ = from_ = until_ = limit_ = now_;
    h_ = T(f_.max_step);
    step_ = steps_ = 0.0;
    first_ = true;
  }

  /// No step runs across a change of the command, as it reaches the first servo; readings may lie
  /// inside a step. False: every window has ended.
  bool schedule() {
    if (!any(no_more(steps_, step_))) return true;
    double step[kLanes], steps[kLanes];
    store(step_, step);
    store(steps_, steps);
    double from[kLanes], until[kLanes], limit[kLanes], h[kLanes];
    store(from_, from), store(until_, until), store(limit_, limit), store(h_, h);
    bool runs = false;
    for (std::size_t i = 0; i < kLanes; ++i) {
      Lane& lane = lane_[i];
      if (step[i] < steps[i]) {
        runs = runs || !lane.ended;
        continue;
      }
      if (!next_interval(lane, from[i], until[i], h[i], steps[i])) {
        lane.ended = true;
        steps[i] = kNone;  // goes on unseen as long as others run
        continue;
      }
      step[i] = 0.0;
      limit[i] = until[i] < lane.end ? until[i] : lane.end + 1.0;
      take_commands(i, lane.change > 1 ? lane.change - 2 : 0);
      runs = true;
    }
    load(step, step_), load(steps, steps_);
    load(from, from_), load(until, until_), load(limit, limit_), load(h, h_);
    return runs;
  }

  /// On to the next step.
  void start_step() {
    const T next = step_ + 1.0;
    last_ = no_more(steps_, next);
    before_ = from_ + step_ * h_;
    now_ = choose(last_, until_, from_ + next * h_);
    commands_over(before_, h_, false);
  }
  void end_step() {
    step_ += T(1.0);
    first_ = false;
  }

  /// Begin and end of the step, and its length, s.
  T before() const { return before_; }
  T now() const { return now_; }
  T h() const { return h_; }
  /// Until when its end is read: beyond the window's end whatever is left. Rounding may leave the
  /// last sample.
  T read_until() const { return choose(last_, limit_, now_); }
  MaskOf<T> ends_window() const { return both(last_, less(now_, limit_)); }
  /// The command changed at the step's begin.
  MaskOf<T> changed() const { return no_more(step_, T(0.0)); }
  bool first_step() const { return first_; }
  /// By joint.
  const CommandOf<T>* commands() const { return command_; }

  /// Commands over the step from t on; `all_joints`: also those that are known from the schedule.
  void commands_over(T t, T h, bool all_joints) {
    double from[kLanes], span[kLanes];
    store(t, from);
    store(h, span);
    for (std::size_t n = 0; n < f_.joint_count; ++n) {
      const std::size_t k = f_.simulated[n];
      if (all_joints || f_.command_delay[k] != command_delay_) {
        for (std::size_t i = 0; i < kLanes; ++i) {
          if (first_) cursor_[k][i] = CommandPath::kUnset;
          set_command(k, i, command_over(f_, k, from[i], from[i] + span[i], cursor_[k][i]));
        }
      }
      T off;
      load(value_[k], command_[k].value);
      load(rate_[k], command_[k].rate);
      load(off_[k], off);
      command_[k].off = FlagOf<T>(off);
    }
  }

 private:
  /// One window on its own clock.
  struct Lane {
    std::size_t change = 0;     // row of the command that arrives next
    double t = 0.0, end = 0.0;  // s; where the interval ends, and the window
    bool ended = false;
  };

  /// From one change of the command to the next, in equal steps. False: the window is at its end.
  bool next_interval(Lane& lane, double& from, double& until, double& h, double& steps) const {
    while (lane.t < lane.end) {
      from = lane.t;
      const double change = lane.change < f_.rows ? f_.t[lane.change] + command_delay_ : kNone;
      until = change < lane.end ? change : lane.end;
      ++lane.change;
      lane.t = until;
      const double span = until - from;
      if (!(span > 0.0)) continue;
      steps = __builtin_ceil(span / f_.max_step - 1e-9);
      if (steps < 1.0) steps = 1.0;
      h = span / steps;
      return true;
    }
    return false;
  }

  /// What row `row` commands, to all joints whose commands arrive with those of the first.
  void take_commands(std::size_t i, std::size_t row) {
    for (std::size_t n = 0; n < f_.joint_count; ++n) {
      const std::size_t k = f_.simulated[n];
      if (f_.command_delay[k] != command_delay_) continue;
      const double* u = f_.series[k];
      CommandOf<double> c{0.0, 0.0, true};
      if (u != nullptr && is_number(u[row])) {
        const bool known = row > 0 && is_number(u[row - 1]);
        c = {u[row], known ? (u[row] - u[row - 1]) / (f_.t[row] - f_.t[row - 1]) : 0.0, false};
      }
      set_command(k, i, c);
    }
  }
  static bool is_number(double x) { return x - x == 0.0; }
  void set_command(std::size_t k, std::size_t i, const CommandOf<double>& c) {
    value_[k][i] = c.off ? 0.0 : c.value;
    rate_[k][i] = c.off ? 0.0 : c.rate;
    off_[k][i] = c.off ? 1.0 : 0.0;
  }

  const SimFigures& f_;
  double command_delay_ = 0.0;  // of the first joint that is simulated
  Lane lane_[kLanes];
  double start_[kLanes];
  bool first_ = true;
  // s: the interval's begin, end, and until when it is read; its step and steps
  T from_, until_, limit_, h_, step_, steps_;
  T before_, now_;
  MaskOf<T> last_;
  CommandOf<T> command_[kMaxJoints];
  double value_[kMaxJoints][kLanes], rate_[kMaxJoints][kLanes], off_[kMaxJoints][kLanes];
  std::size_t cursor_[kMaxJoints][kLanes];
};

}  // namespace sanso::diagnose::SANSO_ISA
