// A window either runs freely from its start, or is replayed: the tree follows the recording and
// only servo and transmission are computed.
#include "tools/diagnose/sim/simulator.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "tools/diagnose/sim/integrator.h"

namespace sanso::diagnose {
namespace {

constexpr double kRounding = 1e-9;  // s: instants that are the same

/// Runs one window and writes each joint's channels at the instants its sensor samples.
class WindowRun {
 public:
  WindowRun(const SimParams& params, const Drive& drive, const SimOptions& options,
            Integrator& integrator)
      : params_(params),
        drive_(drive),
        options_(options),
        integrator_(integrator),
        n_(params.size()) {
    for (const JointParams& joint : params.joints) {
      delay_.push_back(joint.nominal.sensor_delay_s + joint.sensor_delay);
      longest_delay_ = std::max(longest_delay_, delay_.back());
    }
    if (integrator.joints().empty()) return;
    const JointParams& first = params.joints[static_cast<std::size_t>(integrator.joints().front())];
    command_delay_ = first.nominal.command_delay_s + first.command_delay;
  }

  Prediction run(const Window& window, const std::array<InnerState, kMaxJoints>* inner) {
    assert(window.first <= window.last && window.last < drive_.rows());
    rows_ = window.last - window.first + 1;
    prediction_ = Prediction{};
    prediction_.first = window.first;
    prediction_.rows = rows_;
    for (auto* channel :
         {&prediction_.q, &prediction_.dq, &prediction_.tau, &prediction_.i, &prediction_.pwm}) {
      channel->assign(static_cast<std::size_t>(n_) * rows_, 0.0);
    }
    prediction_.volt.assign(rows_, 0.0);
    next_.assign(static_cast<std::size_t>(n_), 0);
    next_effort_ = next_;
    place(window, inner);

    double t = drive_.t[window.first] - longest_delay_;
    integrator_.restart(t);
    if (longest_delay_ == 0.0) {  // row `first` is the start itself
      emit_start(window);
    }
    // no step runs across a change of the command, as it reaches the first servo; readings may lie
    // inside a step
    for (std::size_t k = first_change_after(t); t < drive_.t[window.last]; ++k) {
      const double change = k < drive_.rows() ? drive_.t[k] + command_delay_ : kNone;
      const double until = std::min(change, drive_.t[window.last]);
      advance(t, until);
      t = until;
    }
    emit_until(drive_.t[window.last] + 1.0);  // rounding may leave the last sample
    if (longest_delay_ > 0.0) emit_efforts_until(drive_.t[window.last] + 1.0);
    return std::move(prediction_);
  }

 private:
  /// Start of the window: measured coordinates back to the joints, `delay` seconds before the first
  /// row.
  void place(const Window& window, const std::array<InnerState, kMaxJoints>* inner) {
    state_ = RobotState{};
    if (inner != nullptr) state_.inner = *inner;
    for (const int j : integrator_.joints()) {
      const auto k = static_cast<std::size_t>(j);
      const JointParams& joint = params_.joints[k];
      const double early = longest_delay_ - delay_[k];
      const double side = position_for_reading(joint, window.q[k] - early * window.dq[k]);
      const double speed = window.dq[k] / encoder_slope(joint, side);
      InnerState& in = state_.inner[k];
      state_.q[k] = joint.encoder_at_motor ? side - in.motor_offset : side;
      state_.dq[k] = joint.encoder_at_motor ? speed - in.motor_speed_offset : speed;
      if (inner == nullptr || joint.velocity_filter == 0.0) in.velocity_channel = speed;
    }
    before_ = state_;
    t_before_ = t_now_ = drive_.t[window.first] - longest_delay_;
    first_step_ = true;
  }

  /// Row of the command that is the first to arrive later than t.
  std::size_t first_change_after(double t) const {
    const auto next =
        std::upper_bound(drive_.t.begin(), drive_.t.end(), t - command_delay_ + kRounding);
    return static_cast<std::size_t>(next - drive_.t.begin());
  }

  /// state_ into before_, only the joints that exist.
  void keep_state() {
    std::copy_n(state_.q.begin(), n_, before_.q.begin());
    std::copy_n(state_.dq.begin(), n_, before_.dq.begin());
    std::copy_n(state_.inner.begin(), n_, before_.inner.begin());
  }

  void advance(double from, double until) {
    const double span = until - from;
    if (!(span > 0.0)) return;
    const int steps = std::max(1, static_cast<int>(std::ceil(span / options_.max_step_s - 1e-9)));
    const double h = span / steps;
    for (int s = 0; s < steps; ++s) {
      keep_state();  // old readings lie inside a step
      changed_ = s == 0;
      t_before_ = from + s * h;
      t_now_ = s + 1 == steps ? until : from + (s + 1) * h;
      if (!diverged_) diverged_ = !integrator_.step(t_before_, h, state_, torques_);
      emit_until(t_now_);
      if (longest_delay_ > 0.0) emit_efforts_until(0.5 * (t_before_ + t_now_));
    }
  }

  /// First row without any sensor delay: the given state, and what the servo does in the first
  /// instant.
  void emit_start(const Window& window) {
    if (window.last > window.first) {  // a probing step for the torques; the state stays
      RobotState probe = state_;
      const double h =
          std::min(options_.max_step_s, drive_.t[window.first + 1] - drive_.t[window.first]);
      integrator_.step(drive_.t[window.first], h, probe, torques_);
      integrator_.restart(drive_.t[window.first]);
    }
    emit_until(drive_.t[window.first]);
  }

  /// Writes every sample whose instant (its time stamp minus the sensor's delay) has been reached,
  /// by cubic interpolation.
  void emit_until(double t) {
    const double h = t_now_ - t_before_;
    for (const int j : integrator_.joints()) {
      const auto k = static_cast<std::size_t>(j);
      for (std::size_t& row = next_[k]; row < rows_; ++row) {
        const double instant = drive_.t[prediction_.first + row] - delay_[k];
        if (instant > t) break;
        emit(j, row, h > 0.0 ? std::clamp((instant - t_before_) / h, 0.0, 1.0) : 1.0, h);
      }
    }
  }

  void emit(int j, std::size_t row, double s, double h) {
    const auto k = static_cast<std::size_t>(j);
    const JointParams& joint = params_.joints[k];
    const auto side = [&](const RobotState& x) {
      return x.q[k] + (joint.encoder_at_motor ? x.inner[k].motor_offset : 0.0);
    };
    double position = side(state_), velocity = state_.inner[k].velocity_channel;
    if (s < 1.0) {
      // the step is a parabola in position and a line in velocity
      const double dq0 =
          before_.dq[k] + (joint.encoder_at_motor ? before_.inner[k].motor_speed_offset : 0.0);
      const double dq1 =
          state_.dq[k] + (joint.encoder_at_motor ? state_.inner[k].motor_speed_offset : 0.0);
      position = side(before_) + h * s * (dq0 + 0.5 * s * (dq1 - dq0));
      velocity = (1.0 - s) * before_.inner[k].velocity_channel + s * velocity;
    }
    const std::size_t at = k * rows_ + row;
    prediction_.q[at] = encoder_reading(joint, position);
    prediction_.dq[at] = velocity * (1.0 + joint.encoder_scale);
    if (delay_[k] == 0.0) emit_efforts(j, row, torques_.servo[k], torques_.servo[k], 1.0);
  }

  /// Efforts are means over steps: what a delayed sensor reads lies between the middles of two of
  /// them, where the command is the same in both. Where it changes efforts jump, and the reading is
  /// the one before or after; of the two at the same instant, the reading comes before the command.
  void emit_efforts_until(double middle) {
    for (const int j : integrator_.joints()) {
      const auto k = static_cast<std::size_t>(j);
      if (delay_[k] == 0.0) continue;
      const ServoOutput& now = torques_.servo[k];
      const ServoOutput& earlier = first_step_ ? now : efforts_before_[k];
      for (std::size_t& row = next_effort_[k]; row < rows_; ++row) {
        const double instant = drive_.t[prediction_.first + row] - delay_[k];
        if (instant > middle) break;
        double s = first_step_ ? 1.0 : (instant - middle_before_) / (middle - middle_before_);
        if (changed_) s = instant > t_before_ + kRounding ? 1.0 : 0.0;
        emit_efforts(j, row, earlier, now, std::clamp(s, 0.0, 1.0));
      }
      efforts_before_[k] = now;
    }
    middle_before_ = middle;
    first_step_ = false;
  }

  void emit_efforts(int j, std::size_t row, const ServoOutput& before, const ServoOutput& after,
                    double s) {
    const auto between = [s](double a, double b) { return s < 1.0 ? a + s * (b - a) : b; };
    const std::size_t at = static_cast<std::size_t>(j) * rows_ + row;
    prediction_.tau[at] = between(before.torque, after.torque);
    prediction_.i[at] = between(before.current, after.current);
    prediction_.pwm[at] = between(before.duty, after.duty);
    if (j == 0) prediction_.volt[row] = between(before.volt, after.volt);
  }

  const SimParams& params_;
  const Drive& drive_;
  const SimOptions& options_;
  Integrator& integrator_;
  int n_;
  std::vector<double> delay_;
  double longest_delay_ = 0.0;
  double command_delay_ = 0.0;  // of the first joint that is simulated

  std::size_t rows_ = 0;
  Prediction prediction_;
  std::vector<std::size_t> next_, next_effort_;  // by joint, the next row to write
  RobotState state_, before_;
  StepTorques torques_;
  std::array<ServoOutput, kMaxJoints> efforts_before_{};  // of the step before
  bool first_step_ = true, changed_ = false;  // changed_: a command arrived at the step's start
  double t_before_ = 0.0, t_now_ = 0.0, middle_before_ = 0.0;
  bool diverged_ = false;

 public:
  void reset() { diverged_ = false; }
};

/// Simulated joints whose inner states have to be brought to the start of a window. A sagging
/// supply needs every current.
std::vector<int> with_memory(const SimParams& params, const Integrator& integrator) {
  std::vector<int> out;
  for (const int j : integrator.joints()) {
    if (has_memory(params.joints[static_cast<std::size_t>(j)])) out.push_back(j);
  }
  return out.empty() || params.supply_resistance == 0.0 ? out : integrator.joints();
}

/// Follows the recording with servo and transmission of `serves`, and calls at_row(row, state,
/// torques) at every row up to the last.
template <class AtRow>
void follow_recording(const SimParams& params, const Drive& drive, const MeasuredMotion& motion,
                      const SimOptions& options, std::size_t last, const std::vector<int>& serves,
                      Integrator& integrator, AtRow&& at_row) {
  RobotState state;
  StepTorques torques;
  const auto snap = [&](std::size_t row) {
    for (const int joint_index : integrator.joints()) {
      const auto j = static_cast<std::size_t>(joint_index);
      const JointParams& joint = params.joints[j];
      const InnerState& in = state.inner[j];
      const double side = position_for_reading(joint, motion.q[j][row]);
      const double speed = motion.dq[j][row] / encoder_slope(joint, side);
      state.q[j] = joint.encoder_at_motor ? side - in.motor_offset : side;
      state.dq[j] = joint.encoder_at_motor ? speed - in.motor_speed_offset : speed;
    }
  };
  integrator.restart(drive.t.front());
  snap(0);
  for (std::size_t j = 0; j < state.inner.size(); ++j)
    state.inner[j].velocity_channel = state.dq[j];
  integrator.settle(drive.t.front(), serves, state);
  at_row(std::size_t{0}, state, torques);
  for (std::size_t row = 0; row < last; ++row) {
    const double span = drive.t[row + 1] - drive.t[row];
    const int steps = std::max(1, static_cast<int>(std::ceil(span / options.max_step_s - 1e-9)));
    const double h = span / steps;
    JointVector end;
    for (int s = 0; s < steps; ++s) {
      const double share = (s + 1.0) / steps;
      for (const int joint_index : serves) {
        const auto j = static_cast<std::size_t>(joint_index);
        end[j] = (1 - share) * motion.dq[j][row] + share * motion.dq[j][row + 1];
      }
      integrator.follow(drive.t[row] + s * h, h, end.data(), serves, state, torques);
    }
    snap(row + 1);
    at_row(row + 1, state, torques);
  }
}

}  // namespace

std::vector<Prediction> simulate(const SimParams& params, const Drive& drive,
                                 std::span<const Window> windows, const SimOptions& options) {
  Integrator integrator(params, drive, options.random_seed, options.wanted);
  std::vector<Prediction> predictions;
  predictions.reserve(windows.size());
  if (windows.empty()) return predictions;

  // inner states at the starts, from following the recording up to there
  std::vector<std::array<InnerState, kMaxJoints>> inner;
  const std::vector<int> remembering = with_memory(params, integrator);
  if (options.motion != nullptr && !remembering.empty()) {
    inner.resize(windows.size());
    std::size_t next = 0;
    follow_recording(params, drive, *options.motion, options, windows.back().first, remembering,
                     integrator, [&](std::size_t row, const RobotState& state, const StepTorques&) {
                       for (; next < windows.size() && windows[next].first == row; ++next)
                         inner[next] = state.inner;
                     });
  }
  WindowRun run(params, drive, options, integrator);
  for (std::size_t w = 0; w < windows.size(); ++w) {
    run.reset();
    predictions.push_back(run.run(windows[w], inner.empty() ? nullptr : &inner[w]));
  }
  return predictions;
}

ReplayTorques replay_torques(const SimParams& params, const Drive& drive,
                             const MeasuredMotion& motion, const SimOptions& options) {
  Integrator integrator(params, drive, options.random_seed);
  const auto n = static_cast<std::size_t>(params.size());
  ReplayTorques out;
  out.rows = drive.rows();
  for (auto* v : {&out.motor, &out.friction, &out.passive, &out.current, &out.duty})
    v->assign(n * out.rows, 0.0);
  follow_recording(params, drive, motion, options, drive.rows() - 1, integrator.joints(),
                   integrator, [&](std::size_t row, const RobotState&, const StepTorques& torques) {
                     for (std::size_t j = 0; j < n; ++j) {
                       const std::size_t at = j * out.rows + row;
                       const JointParams& joint = params.joints[j];
                       const double viscous = joint.nominal.viscous + joint.viscous;
                       out.motor[at] = torques.servo[j].torque;
                       out.friction[at] = torques.friction[j] - viscous * motion.dq[j][row];
                       out.passive[at] = torques.passive[j];
                       out.current[at] = torques.servo[j].current;
                       out.duty[at] = torques.servo[j].duty;
                     }
                   });
  return out;
}

}  // namespace sanso::diagnose
