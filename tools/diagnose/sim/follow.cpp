// Figures of every recording that remembers, then its lane. Recordings share lanes where their
// robots are equal but for the gains of servos and what links weigh, and nothing but motion and
// commands depends on time.
#include "tools/diagnose/sim/follow.h"

#include <algorithm>
#include <memory>

#include "tools/diagnose/sim/lane_simulation.h"
#include "tools/diagnose/sim/transmission.h"

namespace sanso::diagnose {
namespace {

/// One recording's figures, which point at each other, and room for what is remembered.
struct Prepared {
  Prepared(const Followed& recording, const SimOptions& options)
      : motion(*recording.motion),
        commands(*recording.params, *recording.drive, recording.random_seed),
        figures(sim_figures(*recording.params, *recording.drive, commands, options.max_step_s,
                            options.wanted)),
        joints(remembering(*recording.params, figures)) {
    for (const Window& w : recording.windows) rows.push_back(w.first);
    states.resize(rows.size() * figures.n);
    cut(figures.heats ? kNone : recording.recalled_s);
  }
  Prepared(const Prepared&) = delete;
  Prepared& operator=(const Prepared&) = delete;

  /// Simulated joints with a memory. A sagging supply needs every current.
  static FollowedJoints remembering(const SimParams& params, const SimFigures& figures) {
    FollowedJoints out;
    for (std::size_t i = 0; i < figures.joint_count; ++i) {
      const std::size_t j = figures.simulated[i];
      if (has_memory(params.joints[j])) out.joint[out.count++] = j;
    }
    if (out.count > 0 && figures.sags) {
      out.count = figures.joint_count;
      std::copy_n(figures.simulated, figures.joint_count, out.joint);
    }
    out.gears = std::any_of(params.joints.begin(), params.joints.end(), gears_remember);
    return out;
  }

  /// Windows of which each begins within what is recalled of the one before are one stretch.
  void cut(double recalled_s) {
    const std::span<const double> t(figures.t, figures.rows);
    for (std::size_t w = 0; w < rows.size(); ++w) {
      const auto from = std::lower_bound(t.begin(), t.end(), t[rows[w]] - recalled_s);
      const auto first = static_cast<std::size_t>(from - t.begin());
      if (w == 0 || first > rows[w - 1]) stretches.push_back({first, w, w});
      stretches.back().end = w + 1;
    }
  }

  FollowFigures lane(std::size_t stretch) {
    const auto [first, begin, end] = stretches[stretch];
    FollowFigures out;
    out.figures = &figures;
    for (std::size_t j = 0; j < figures.n; ++j) {
      out.q[j] = motion.q[j].data();
      out.dq[j] = motion.dq[j].data();
    }
    out.first = first;
    out.last = rows[end - 1];
    out.wanted = rows.data() + begin;
    out.wanted_count = end - begin;
    out.out = states.data() + begin * figures.n;
    return out;
  }
  std::vector<InnerStates> by_window() const {
    std::vector<InnerStates> out(rows.size());
    for (std::size_t w = 0; w < rows.size(); ++w)
      std::copy_n(states.data() + w * figures.n, figures.n, out[w].begin());
    return out;
  }

  const MeasuredMotion& motion;
  CommandPath commands;
  SimFigures figures;
  FollowedJoints joints;
  struct Stretch {
    std::size_t first, begin, end;  // its first row; windows [begin, end)
  };
  std::vector<std::size_t> rows;  // where windows begin
  std::vector<Stretch> stretches;
  std::vector<InnerState> states;
};

bool depends_on_time(const SimParams& params) {
  return params.supply_slope != 0.0 ||
         std::any_of(params.joints.begin(), params.joints.end(), [](const JointParams& j) {
           return j.derating != 0.0 || j.friction_temperature != 0.0;
         });
}

/// The same joint but for the gains of its position loop, which is of one kind.
bool alike_but_for_gains(JointParams a, const JointParams& b) {
  if ((servo_gains(a).i > 0.0) != (servo_gains(b).i > 0.0)) return false;
  const JointSettings& s = b.nominal;
  a.nominal.p_gain = s.p_gain, a.nominal.i_gain = s.i_gain, a.nominal.d_gain = s.d_gain;
  a.nominal.kp = s.kp, a.nominal.kd = s.kd;
  a.stated_gain = b.stated_gain;
  return a == b;
}

/// The same but for what links and their payloads weigh.
bool alike_but_for_bodies(RobotTree a, const RobotTree& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t j = 0; j < a.size(); ++j) a.joints[j].body = b.joints[j].body;
  return a == b;
}

/// One robot but for the gains of its servos and what its links weigh, and nothing of it depends on
/// time.
bool one_robot(const SimParams& a, const SimParams& b) {
  return !depends_on_time(a) && a.supply_level == b.supply_level &&
         a.supply_slope == b.supply_slope && a.supply_resistance == b.supply_resistance &&
         a.gravity == b.gravity &&
         std::equal(a.joints.begin(), a.joints.end(), b.joints.begin(), b.joints.end(),
                    alike_but_for_gains) &&
         a.forces == b.forces && a.settings == b.settings && alike_but_for_bodies(a.tree, b.tree);
}

}  // namespace

std::vector<std::vector<std::size_t>> in_step(std::span<const Followed> recordings) {
  std::vector<std::vector<std::size_t>> out;
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    if (recordings[i].motion == nullptr || recordings[i].windows.empty()) continue;
    const SimParams& own = *recordings[i].params;
    const auto group = std::find_if(out.begin(), out.end(), [&](const auto& members) {
      return one_robot(own, *recordings[members.front()].params);
    });
    if (group != out.end()) {
      group->push_back(i);
    } else {
      out.push_back({i});
    }
  }
  return out;
}

std::vector<std::vector<InnerStates>> follow(std::span<const Followed> recordings,
                                             const SimOptions& options) {
  std::vector<std::vector<InnerStates>> out(recordings.size());
  for (const std::vector<std::size_t>& group : in_step(recordings)) {
    std::vector<std::unique_ptr<Prepared>> prepared;
    std::vector<FollowFigures> lanes;
    for (const std::size_t i : group) {
      prepared.push_back(std::make_unique<Prepared>(recordings[i], options));
      for (std::size_t s = 0; s < prepared.back()->stretches.size(); ++s)
        lanes.push_back(prepared.back()->lane(s));
    }
    const FollowedJoints& joints = prepared.front()->joints;
    if (joints.count == 0) continue;
    follow_recordings(lanes, joints, options.unit);
    for (std::size_t k = 0; k < group.size(); ++k) out[group[k]] = prepared[k]->by_window();
  }
  return out;
}

}  // namespace sanso::diagnose
