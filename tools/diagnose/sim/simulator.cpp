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

namespace {

/// One recording's figures, which point at each other, and room for its torques.
struct PreparedReplay {
  PreparedReplay(const Replayed& recording, const SimOptions& options)
      : of(recording),
        commands(*of.params, *of.drive, options.random_seed),
        figures(sim_figures(*of.params, *of.drive, commands, options.max_step_s, {})) {
    torques.rows = of.drive->rows();
    for (auto* v :
         {&torques.motor, &torques.friction, &torques.passive, &torques.current, &torques.duty})
      v->assign(of.params->size() * torques.rows, 0.0);
  }
  PreparedReplay(const PreparedReplay&) = delete;
  PreparedReplay& operator=(const PreparedReplay&) = delete;

  FollowFigures lane() {
    FollowFigures out;
    out.figures = &figures;
    out.last = torques.rows - 1;
    for (std::size_t j = 0; j < figures.n; ++j) {
      out.q[j] = of.motion->q[j].data();
      out.dq[j] = of.motion->dq[j].data();
    }
    out.torques = {torques.motor.data(), torques.friction.data(), torques.passive.data(),
                   torques.current.data(), torques.duty.data()};
    return out;
  }
  /// Viscous friction is told as friction too.
  ReplayTorques told() {
    for (std::size_t j = 0; j < figures.n; ++j) {
      const JointParams& joint = of.params->joints[j];
      const double viscous = joint.nominal.viscous + joint.viscous;
      for (std::size_t row = 0; row < torques.rows; ++row)
        torques.friction[j * torques.rows + row] -= viscous * of.motion->dq[j][row];
    }
    return std::move(torques);
  }

  const Replayed of;
  CommandPath commands;
  SimFigures figures;
  ReplayTorques torques;
};

}  // namespace

std::vector<ReplayTorques> replay_torques(std::span<const Replayed> recordings,
                                          const SimOptions& options) {
  const std::vector<Window> any(1);  // what is in step does not depend on windows
  std::vector<Followed> followed;
  followed.reserve(recordings.size());
  for (const Replayed& r : recordings) followed.push_back({r.params, r.drive, r.motion, any});
  std::vector<ReplayTorques> out(recordings.size());
  for (const std::vector<std::size_t>& group : in_step(followed)) {
    std::vector<std::unique_ptr<PreparedReplay>> prepared;
    std::vector<FollowFigures> lanes;
    for (const std::size_t i : group) {
      prepared.push_back(std::make_unique<PreparedReplay>(recordings[i], options));
      lanes.push_back(prepared.back()->lane());
    }
    const SimFigures& figures = prepared.front()->figures;
    FollowedJoints all;
    all.count = figures.joint_count;
    all.gears = true;
    std::copy_n(figures.simulated, figures.joint_count, all.joint);
    replay_recordings(lanes, all, options.unit);
    for (std::size_t k = 0; k < group.size(); ++k) out[group[k]] = prepared[k]->told();
  }
  return out;
}

}  // namespace sanso::diagnose
