// The library of effects, placed on this robot.
#include <algorithm>
#include <map>
#include <utility>

#include "tools/diagnose/compare/candidate.h"
#include "tools/diagnose/effects/effect.h"
#include "tools/diagnose/effects/joint_scale.h"
#include "tools/diagnose/model_folder/joint_units.h"
#include "tools/diagnose/stats/robust.h"

namespace sanso::diagnose {
namespace {

/// All drives as the library's checks want them.
std::vector<Drive> drives_of(const Comparison& comparison) {
  std::vector<Drive> out;
  for (const Source& s : comparison.sources) out.push_back(s.drive);
  return out;
}

/// What begins at a position is looked for at several depths below the end of what the joint did,
/// not at the library's example positions. Near the ends only, what acts on half of the motion
/// looks like nothing that was probed.
void place_positions(Candidate& c, const Comparison& comparison, std::size_t joint) {
  for (std::size_t i = 0; i < c.parameters.size(); ++i) {
    if (c.parameters[i].role != Role::position) continue;
    std::vector<double> q;
    for (const Source& s : comparison.sources)
      q.insert(q.end(), s.motion.q[joint].begin(), s.motion.q[joint].end());
    const double low = quantile(q, 0.0), high = quantile(q, 1.0);
    const std::vector<std::vector<double>> own = std::exchange(c.probes, {});
    for (const double share : {comparison.settings.data.end_margin, 0.25, 0.5, 0.75}) {
      for (std::vector<double> probe : own) {
        const double depth = share * (high - low);
        probe[i] = probe[i] > 0.0 ? high - depth : low + depth;
        c.probes.push_back(std::move(probe));
      }
    }
  }
}

/// What begins at an instant is looked for at several instants of the recordings beside the
/// library's own.
void place_instants(Candidate& c, const Comparison& comparison) {
  const int instants = comparison.settings.data.instants;
  for (std::size_t i = 0; i < c.parameters.size(); ++i) {
    if (c.parameters[i].role != Role::instant) continue;
    const std::vector<std::vector<double>> own = c.probes;
    for (int k = 1; k < instants; ++k) {
      for (std::vector<double> probe : own) {
        probe[i] = longest_recording(comparison) * k / instants;
        c.probes.push_back(std::move(probe));
      }
    }
  }
}

/// What is short is looked for only where errors stand alone (Comparison::instants), in both halves
/// of such a shot, and at one joint that is struck: a blow is no property of a pair.
void place_events(Candidate& c, const Comparison& comparison) {
  for (std::size_t i = 0; i < c.parameters.size(); ++i) {
    if (c.parameters[i].role != Role::event) continue;
    const std::vector<std::vector<double>> own = std::exchange(c.probes, {});
    const bool struck =
        c.joints.size() == 1 && std::find(comparison.struck.begin(), comparison.struck.end(),
                                          c.joints.front()) != comparison.struck.end();
    for (const double from : struck ? comparison.instants : std::vector<double>{}) {
      for (const double later : {0.0, 0.5 * comparison.settings.data.shot_seconds}) {
        for (std::vector<double> probe : own) {
          probe[i] = from + later;
          c.probes.push_back(std::move(probe));
        }
      }
    }
  }
}

/// "l_knee" and "r_knee" are of one class, "knee".
std::string joint_class(const std::string& name) {
  for (const char* side : {"l_", "r_", "left_", "right_", "L_", "R_"}) {
    if (name.rfind(side, 0) == 0) return name.substr(std::string(side).size());
  }
  return name;
}

/// One number can be meant for both: they turn or they slide, are driven alike or not at all, and
/// are of one scale. A number without a scale (a delay, a share) can be meant for any joint:
/// `scales` empty.
bool alike(const Comparison& comparison, const std::vector<JointScale>& scales, std::size_t a,
           std::size_t b) {
  if (scales.empty()) return true;
  const SimParams& nominal = comparison.sources.front().nominal;
  const std::vector<TreeJoint>& tree = nominal.tree.joints;
  const double x = scales[a].torque, y = scales[b].torque;
  return tree[a].prismatic == tree[b].prismatic &&
         nominal.joints[a].nominal.actuator == nominal.joints[b].nominal.actuator &&
         std::max(x, y) <= comparison.settings.decisions.tied_drives * std::min(x, y);
}

/// Places with more than one joint: mirror pairs, then all joints alike. One number stands for all
/// of them, so that they have to be of one kind.
std::vector<std::vector<std::size_t>> tied_places(const Comparison& comparison,
                                                  const std::vector<JointScale>& scales) {
  std::map<std::string, std::vector<std::size_t>> classes;
  std::vector<std::vector<std::size_t>> kinds;
  const std::size_t joints = comparison.joints.size();
  for (std::size_t j = 0; j < joints; ++j) {
    classes[joint_class(comparison.joints[j])].push_back(j);
    const auto kind = std::find_if(kinds.begin(), kinds.end(), [&](const auto& members) {
      return alike(comparison, scales, members.front(), j);
    });
    if (kind == kinds.end())
      kinds.push_back({j});
    else
      kind->push_back(j);
  }
  std::vector<std::vector<std::size_t>> out;
  for (const auto& [name, members] : classes) {
    const auto like_first = [&, first = members.front()](std::size_t j) {
      return alike(comparison, scales, first, j);
    };
    const bool one_kind = std::all_of(members.begin(), members.end(), like_first);
    if (members.size() > 1 && members.size() < joints && one_kind) out.push_back(members);
  }
  for (const std::vector<std::size_t>& members : kinds) {
    const bool known = std::find(out.begin(), out.end(), members) != out.end();
    if (members.size() > 1 && !known) out.push_back(members);
  }
  return out;
}

Candidate place(const Effect& effect, const Comparison& comparison,
                const std::vector<JointScale>& scales, const std::vector<std::size_t>& joints) {
  const SimParams& nominal = comparison.sources.front().nominal;
  // tied joints share one number: scaled by the first, they are alike
  const JointScale& scale = scales[joints.empty() ? 0 : joints.front()];
  Candidate c;
  c.effect = std::string(effect.id);
  c.family = std::string(to_string(effect.family));
  c.two_sided = effect.sign == 0;
  c.random = effect.random;
  for (const std::string_view id : effect.confounders) c.confounders.emplace_back(id);
  for (const std::string_view id : effect.contains) c.contains.emplace_back(id);
  const bool prismatic = !joints.empty() && effect.scope != Scope::link &&
                         nominal.tree.joints[joints.front()].prismatic;
  for (const EffectParameter& p : effect.parameters) {
    const EffectParameter here = scaled(p, scale);
    c.parameters.push_back({std::string(p.name), at_joint(std::string(p.unit), prismatic),
                            here.null, here.low, here.high, here.typical, p.structural, p.role});
  }
  for (const std::size_t j : joints) {
    if (effect.lowest)
      c.parameters[0].low = std::max(c.parameters[0].low, effect.lowest(nominal, j));
  }
  c.probes = scaled_probes(effect, scale);
  for (const std::size_t j : joints) {
    c.where.push_back(effect.scope == Scope::link ? nominal.tree.joints[j].link
                                                  : comparison.joints[j]);
    c.joints.push_back(j);
  }
  if (joints.size() == 1) place_positions(c, comparison, joints.front());
  place_instants(c, comparison);
  place_events(c, comparison);
  const auto apply = effect.apply;
  if (joints.empty()) {
    c.apply = [apply](SimParams& p, const std::vector<double>& theta) { apply(p, 0, theta); };
  } else {
    c.apply = [apply, joints](SimParams& p, const std::vector<double>& theta) {
      for (const std::size_t j : joints) apply(p, j, theta);
    };
  }
  return c;
}

}  // namespace

Placement place_library(const Comparison& comparison, const std::vector<std::string>& only) {
  Placement out;
  const std::vector<Drive> drives = drives_of(comparison);
  const SimParams& nominal = comparison.sources.front().nominal;
  const std::vector<JointScale> scales = joint_scales(nominal, drives, comparison.settings.library);
  const std::vector<std::vector<std::size_t>> of_one_scale = tied_places(comparison, scales),
                                              of_any = tied_places(comparison, {});
  for (const Effect& effect : library()) {
    if (!only.empty() && std::find(only.begin(), only.end(), effect.id) == only.end()) continue;
    const bool robot = effect.scope == Scope::robot;
    std::vector<std::size_t> able;
    std::string reason;
    for (std::size_t j = 0; j < (robot ? 1 : comparison.joints.size()); ++j) {
      const std::string missing =
          why_untestable(effect, nominal, drives, robot ? -1 : static_cast<int>(j));
      if (missing.empty())
        able.push_back(j);
      else
        reason = missing;
    }
    if (able.empty()) {
      out.untestable.emplace_back(std::string(effect.id), reason);
      continue;
    }
    if (robot) {
      out.candidates.push_back(place(effect, comparison, scales, {}));
      continue;
    }
    for (const std::size_t j : able)
      out.candidates.push_back(place(effect, comparison, scales, {j}));
    const bool scale_free =
        std::all_of(effect.parameters.begin(), effect.parameters.end(),
                    [](const EffectParameter& p) { return p.scale == Unit::none; });
    for (const std::vector<std::size_t>& joints : scale_free ? of_any : of_one_scale) {
      const bool all = std::all_of(joints.begin(), joints.end(), [&](std::size_t j) {
        return std::find(able.begin(), able.end(), j) != able.end();
      });
      if (all) out.candidates.push_back(place(effect, comparison, scales, joints));
    }
  }
  std::erase_if(out.candidates, [](const Candidate& c) { return c.probes.empty(); });
  return out;
}

}  // namespace sanso::diagnose
