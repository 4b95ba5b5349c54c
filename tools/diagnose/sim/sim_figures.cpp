// Figures of one simulation, and what of model and recording is asked for on the way.
#include "tools/diagnose/sim/sim_figures.h"

#include <algorithm>
#include <cmath>

namespace sanso::diagnose {
namespace {

bool heats(const SimParams& params) {
  return std::any_of(params.joints.begin(), params.joints.end(), [](const JointParams& j) {
    return j.derating != 0.0 || j.friction_temperature != 0.0;
  });
}

/// Joints and branches that are wanted.
void choose_branches(const std::vector<char>& wanted, SimFigures& out) {
  for (std::size_t b = 0; b < out.tree.branches; ++b) {
    const std::size_t begin = out.tree.branch_begin[b], end = out.tree.branch_begin[b + 1];
    bool any = wanted.empty() || out.sags;
    for (std::size_t j = begin; j < end && !any; ++j) any = wanted[j] != 0;
    if (!any) continue;
    out.branch[out.branch_count++] = b;
    for (std::size_t j = begin; j < end; ++j) out.simulated[out.joint_count++] = j;
  }
}

}  // namespace

SimFigures sim_figures(const SimParams& params, const Drive& drive, const CommandPath& commands,
                       double max_step_s, const std::vector<char>& wanted) {
  SimFigures out;
  out.params = &params;
  out.commands = &commands;
  out.joints = params.joints.data();
  out.n = params.size();
  out.tree = tree_figures(params.tree, params.gravity);
  out.t = drive.t.data();
  out.rows = drive.rows();
  out.max_step = max_step_s;
  out.sags = params.supply_resistance > 0.0;
  out.heats = heats(params);
  out.late_payloads = !params.late_payloads.empty();
  out.forces = !params.forces.empty();
  for (std::size_t j = 0; j < params.joints.size(); ++j) {
    const JointParams& joint = params.joints[j];
    out.series[j] = commands.series(j);
    out.command_delay[j] = joint.nominal.command_delay_s + joint.command_delay;
    out.sensor_delay[j] = joint.nominal.sensor_delay_s + joint.sensor_delay;
    out.longest_sensor_delay = std::max(out.longest_sensor_delay, out.sensor_delay[j]);
    const std::vector<double>& temp = drive.joints[j].temp;
    const auto first =
        std::find_if(temp.begin(), temp.end(), [](double T) { return std::isfinite(T); });
    out.temperature[j] = temp.data();
    out.first_temperature[j] = first == temp.end() ? std::nan("") : *first;
  }
  choose_branches(wanted, out);
  return out;
}

std::size_t row_at(const SimFigures& figures, double t) {
  const double* after = std::upper_bound(figures.t, figures.t + figures.rows, t);
  return after == figures.t ? 0 : static_cast<std::size_t>(after - figures.t) - 1;
}

std::size_t payloads_on(const SimFigures& figures, double t) {
  const std::vector<LatePayload>& all = figures.params->late_payloads;
  return static_cast<std::size_t>(
      std::count_if(all.begin(), all.end(), [t](const LatePayload& p) { return t >= p.from_s; }));
}

void bodies_at(const SimFigures& figures, double t, BodyFigures* bodies) {
  RobotTree tree = figures.params->tree;
  for (const LatePayload& p : figures.params->late_payloads) {
    if (t >= p.from_s) add_body(tree.joints[static_cast<std::size_t>(p.joint)].body, p.body);
  }
  for (const TreeJoint& joint : tree.joints) *bodies++ = body_figures(joint.body);
}

double next_change(const SimFigures& figures, double t) {
  double next = kNone;
  const auto at = [&](double instant) {
    if (instant > t) next = std::min(next, instant);
  };
  for (const LatePayload& p : figures.params->late_payloads) at(p.from_s);
  for (const WorldForce& f : figures.params->forces) at(f.from_s), at(f.until_s);
  return next;
}

void forces_at(const SimFigures& figures, double t, double (*forces)[3]) {
  for (std::size_t j = 0; j < figures.n; ++j) std::fill_n(forces[j], 3, 0.0);
  for (const WorldForce& f : figures.params->forces) {
    if (t < f.from_s || t >= f.until_s) continue;
    for (std::size_t k = 0; k < 3; ++k) forces[f.joint][k] += f.force[k];
  }
}

CommandOf<double> command_over(const SimFigures& figures, std::size_t j, double from, double until,
                               std::size_t& cursor) {
  return figures.commands->over(j, from, until, cursor);
}

}  // namespace sanso::diagnose
