// A window either runs freely from its start (window_run.h), or is replayed: the tree follows
// the recording and only servo and transmission are computed.
#include "tools/diagnose/sim/simulator.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <memory>

#include "tools/diagnose/sim/actuator.h"
#include "tools/diagnose/sim/integrator.h"
#include "tools/diagnose/sim/lane_simulation.h"
#include "tools/diagnose/sim/transmission.h"

namespace sanso::diagnose {
namespace {

using State = portable::RobotStateOf<double>;
using StepTorques = portable::StepTorquesOf<double>;
using InnerStates = std::array<InnerState, kMaxJoints>;

/// Simulated joints whose inner states have to be brought to the start of a window. A sagging
/// supply needs every current.
std::vector<std::size_t> with_memory(const SimParams& params, const SimFigures& figures) {
  const std::vector<std::size_t> simulated(figures.simulated,
                                           figures.simulated + figures.joint_count);
  std::vector<std::size_t> out;
  for (const std::size_t j : simulated) {
    if (has_memory(params.joints[j])) out.push_back(j);
  }
  return out.empty() || params.supply_resistance == 0.0 ? out : simulated;
}

/// A measured coordinate's position and speed on the link's side.
struct LinkMotion {
  double q, dq;
};
LinkMotion link_motion(const JointParams& joint, double reading, double speed_reading,
                       const InnerState& inner) {
  const double side = position_for_reading(joint, reading);
  const double speed = speed_reading / encoder_slope(joint, side);
  if (!joint.encoder_at_motor) return {side, speed};
  return {side - inner.motor_offset, speed - inner.motor_speed_offset};
}

/// Follows a recording with the servos of some joints, and with their transmissions where `gears`.
class Follower {
 public:
  Follower(const SimFigures& figures, const MeasuredMotion& motion, std::vector<std::size_t> serves,
           bool gears)
      : f_(figures),
        motion_(motion),
        serves_(std::move(serves)),
        gears_(gears),
        integrator_(std::make_unique<portable::Integrator<double>>(figures)) {
    cursor_.fill(CommandPath::kUnset);
  }

  /// Calls at_row(row, state, torques) at every row up to the last.
  template <class AtRow>
  void follow(std::size_t last, AtRow&& at_row) {
    integrator_->restart(f_.t[0]);
    snap(0);
    for (std::size_t i = 0; i < f_.joint_count; ++i) {
      const std::size_t j = f_.simulated[i];
      state_.inner[j].velocity_channel = state_.dq[j];
    }
    settle();
    at_row(std::size_t{0}, state_, torques_);
    for (std::size_t row = 0; row < last; ++row) {
      advance(row);
      snap(row + 1);
      at_row(row + 1, state_, torques_);
    }
  }

 private:
  void snap(std::size_t row) {
    for (std::size_t i = 0; i < f_.joint_count; ++i) {
      const std::size_t j = f_.simulated[i];
      const LinkMotion m =
          link_motion(f_.joints[j], motion_.q[j][row], motion_.dq[j][row], state_.inner[j]);
      state_.q[j] = m.q;
      state_.dq[j] = m.dq;
    }
  }

  /// Inner states of servos that held this posture before (their integral).
  void settle() {
    const double supply = 1.0 + f_.params->supply_level;
    const double* held = integrator_->held(f_.t[0], state_);
    const double seconds = f_.params->settings.held;
    for (const std::size_t j : serves_)
      settle_integral(f_.joints[j], held[j], supply, seconds, state_.inner[j]);
  }

  void advance(std::size_t row) {
    const double span = f_.t[row + 1] - f_.t[row];
    const int steps = std::max(1, static_cast<int>(std::ceil(span / f_.max_step - 1e-9)));
    const double h = span / steps;
    double end[kMaxJoints];
    for (int s = 0; s < steps; ++s) {
      const double share = (s + 1.0) / steps, t = f_.t[row] + s * h;
      for (const std::size_t j : serves_) {
        const std::vector<double>& dq = motion_.dq[j];
        end[j] = (1 - share) * dq[row] + share * dq[row + 1];
        command_[j] = command_over(f_, j, t, t + h, cursor_[j]);
      }
      integrator_->follow(t, h, command_, end, serves_.data(), serves_.size(), gears_, state_,
                          torques_);
    }
  }

  const SimFigures& f_;
  const MeasuredMotion& motion_;
  std::vector<std::size_t> serves_;
  bool gears_;
  std::unique_ptr<portable::Integrator<double>> integrator_;
  State state_{};
  StepTorques torques_{};
  CommandOf<double> command_[kMaxJoints];
  std::array<std::size_t, kMaxJoints> cursor_;
};

/// Inner states at the starts of the windows, from following the recording up to there; empty:
/// nothing remembers.
std::vector<InnerStates> inner_at_starts(const SimParams& params, const SimFigures& figures,
                                         std::span<const Window> windows,
                                         const MeasuredMotion* motion) {
  std::vector<std::size_t> remembering = with_memory(params, figures);
  if (motion == nullptr || remembering.empty()) return {};
  const bool gears = std::any_of(params.joints.begin(), params.joints.end(), gears_remember);
  std::vector<InnerStates> inner(windows.size());
  std::size_t next = 0;
  Follower(figures, *motion, std::move(remembering), gears)
      .follow(windows.back().first, [&](std::size_t row, const State& state, const StepTorques&) {
        for (; next < windows.size() && windows[next].first == row; ++next)
          std::copy_n(state.inner, figures.n, inner[next].begin());
      });
  return inner;
}

Prediction empty_prediction(const Window& window, std::size_t n) {
  Prediction out;
  out.first = window.first;
  out.rows = window.last - window.first + 1;
  for (auto* channel : {&out.q, &out.dq, &out.tau, &out.i, &out.pwm})
    channel->assign(n * out.rows, 0.0);
  out.volt.assign(out.rows, 0.0);
  return out;
}

/// Start of a window: measured coordinates back to the joints, the longest sensor delay before the
/// first row.
WindowFigures placed(const SimFigures& figures, const Window& window, bool remembers,
                     InnerStates& inner, Prediction& out) {
  WindowFigures w;
  w.first = window.first;
  w.last = window.last;
  for (std::size_t i = 0; i < figures.joint_count; ++i) {
    const std::size_t j = figures.simulated[i];
    const JointParams& joint = figures.joints[j];
    const double early = figures.longest_sensor_delay - figures.sensor_delay[j];
    const LinkMotion m =
        link_motion(joint, window.q[j] - early * window.dq[j], window.dq[j], inner[j]);
    w.q[j] = m.q;
    w.dq[j] = m.dq;
    if (!remembers || joint.velocity_filter == 0.0)
      inner[j].velocity_channel =
          joint.encoder_at_motor ? m.dq + inner[j].motor_speed_offset : m.dq;
  }
  w.inner = inner.data();
  w.out_q = out.q.data(), w.out_dq = out.dq.data(), w.out_tau = out.tau.data();
  w.out_i = out.i.data(), w.out_pwm = out.pwm.data(), w.out_volt = out.volt.data();
  return w;
}

}  // namespace

std::vector<Prediction> simulate(const SimParams& params, const Drive& drive,
                                 std::span<const Window> windows, const SimOptions& options) {
  std::vector<Prediction> predictions;
  if (windows.empty()) return predictions;
  const CommandPath commands(params, drive, options.random_seed);
  const SimFigures figures =
      sim_figures(params, drive, commands, options.max_step_s, options.wanted);
  std::vector<InnerStates> inner = inner_at_starts(params, figures, windows, options.motion);
  const bool remembers = !inner.empty();
  inner.resize(windows.size());
  predictions.reserve(windows.size());
  std::vector<WindowFigures> placed_windows;
  for (std::size_t w = 0; w < windows.size(); ++w) {
    assert(windows[w].first <= windows[w].last && windows[w].last < drive.rows());
    predictions.push_back(empty_prediction(windows[w], params.size()));
    placed_windows.push_back(placed(figures, windows[w], remembers, inner[w], predictions.back()));
  }
  run_windows(figures, placed_windows, options.unit);
  return predictions;
}

ReplayTorques replay_torques(const SimParams& params, const Drive& drive,
                             const MeasuredMotion& motion, const SimOptions& options) {
  const CommandPath commands(params, drive, options.random_seed);
  const SimFigures figures = sim_figures(params, drive, commands, options.max_step_s, {});
  const std::size_t n = params.size();
  ReplayTorques out;
  out.rows = drive.rows();
  for (auto* v : {&out.motor, &out.friction, &out.passive, &out.current, &out.duty})
    v->assign(n * out.rows, 0.0);
  std::vector<std::size_t> all(figures.simulated, figures.simulated + figures.joint_count);
  Follower(figures, motion, std::move(all), true)
      .follow(drive.rows() - 1, [&](std::size_t row, const State&, const StepTorques& torques) {
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
