// A window either runs freely from its start (window_run.h), or is replayed: the tree follows
// the recording and only servo and transmission are computed.
#include "tools/diagnose/sim/simulator.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <memory>
#include <utility>

#include "tools/diagnose/sim/actuator.h"
#include "tools/diagnose/sim/follow.h"
#include "tools/diagnose/sim/follow_run.h"
#include "tools/diagnose/sim/lane_simulation.h"

namespace sanso::diagnose {
namespace {

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
  std::vector<InnerStates> inner;
  if (options.starts != nullptr) {
    inner = *options.starts;
  } else {
    const Followed own{&params, &drive, options.motion, windows, options.random_seed};
    inner = std::move(follow({&own, 1}, options).front());
  }
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
  FollowFigures recording;
  FollowedJoints all;
  recording.figures = &figures;
  recording.last = drive.rows() - 1;
  all.count = figures.joint_count;
  all.gears = true;
  std::copy_n(figures.simulated, figures.joint_count, all.joint);
  for (std::size_t j = 0; j < n; ++j) {
    recording.q[j] = motion.q[j].data();
    recording.dq[j] = motion.dq[j].data();
  }
  const auto run = std::make_unique<portable::FollowRun<double>>(&recording, 1, all);
  run->run([&](std::size_t, std::size_t row) {
    const portable::StepTorquesOf<double>& torques = run->torques();
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
