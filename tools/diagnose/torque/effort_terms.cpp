// Joint terms are the library's own laws, read by inverse_effort; links by differences of inverse
// dynamics, which is linear in mass properties.
#include "tools/diagnose/torque/effort_terms.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "tools/diagnose/model_folder/joint_units.h"

namespace sanso::diagnose {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kLengthStep = 1e-3;  // m, of a centre of mass
constexpr double kAngleStep = 1e-4;   // rad, of an encoder's zero

const EffortRecording& first_of(const EffortRows& rows) { return rows.recordings.front(); }
const TreeJoint& joint_of(const EffortRows& rows, std::size_t j) {
  return first_of(rows).nominal.tree.joints[j];
}

/// A joint of which nothing acts but `effect` with theta.
JointParams only(const Effect& effect, const std::vector<double>& theta) {
  SimParams blank;
  blank.joints.resize(1);
  effect.apply(blank, 0, theta);
  return blank.joints.front();
}

/// A term of the library, without places and numbers.
EffortTerm term_of(const Effect& effect) {
  EffortTerm term;
  term.effect = effect.id;
  term.family = to_string(effect.family);
  term.law = effect.effort;
  return term;
}

/// A term of the library at one joint. `theta`: values of the parameters that are no columns.
EffortTerm at_joint_term(const EffortRows& rows, const Effect& effect, std::size_t j,
                         const std::vector<double>& theta) {
  const TreeJoint& joint = joint_of(rows, j);
  const std::vector<std::size_t>& sizes = effect.effort.values;
  EffortTerm term = term_of(effect);
  term.where = {joint.name};
  term.joints = {j};
  std::vector<JointParams> laws;
  for (std::size_t p = 0; p < effect.parameters.size(); ++p) {
    const EffectParameter& parameter = effect.parameters[p];
    if (std::find(sizes.begin(), sizes.end(), p) == sizes.end()) {
      term.fixed[std::string(parameter.name)] = theta[p];
      continue;
    }
    std::vector<double> unit = theta;
    for (const std::size_t s : sizes) unit[s] = s == p ? 1.0 : effect.parameters[s].null;
    laws.push_back(only(effect, unit));
    term.parameters.emplace_back(parameter.name);
    term.units.push_back(at_joint(std::string(parameter.unit), joint.prismatic));
    term.low.push_back(parameter.low < 0.0 ? -kInf : 0.0);
    term.high.push_back(kInf);
  }
  term.columns = [laws, j](const EffortRecording&) -> ColumnsAt {
    return [laws, j](const MotionSample& m, const std::vector<NeededEffort>& needed,
                     std::vector<double>& out) {
      for (std::size_t c = 0; c < laws.size(); ++c)
        out[j * laws.size() + c] +=
            joint_effort(laws[c], m.q[j], m.dq[j], m.ddq[j], needed[j].load, needed[j].external);
    };
  };
  return term;
}

EffortTerm offset_term(const EffortRows& rows, std::size_t j) {
  EffortTerm term;
  term.effect = kEffortOffset.id;
  term.law.beside_gain = true;
  term.family = to_string(kEffortOffset.family);
  term.where = {joint_of(rows, j).name};
  term.joints = {j};
  term.parameters = {"torque"};
  term.units = {at_joint("N m", joint_of(rows, j).prismatic)};
  term.low = {-kInf}, term.high = {kInf};
  term.columns = [j](const EffortRecording&) -> ColumnsAt {
    return [j](const MotionSample&, const std::vector<NeededEffort>&, std::vector<double>& out) {
      out[j] += 1.0;
    };
  };
  return term;
}

/// The recorded effort is a multiple of what the joint needs.
EffortTerm share_term(const EffortRows& rows, const Effect& effect, std::size_t j) {
  EffortTerm term = term_of(effect);
  term.where = {joint_of(rows, j).name};
  term.joints = {j};
  term.parameters = {"effort_share"};
  term.units = {"-"};
  term.low = {-effect.effort.most}, term.high = {effect.effort.most};
  term.low_is_nothing = false;
  term.columns = [j](const EffortRecording&) -> ColumnsAt {
    return [j](const MotionSample&, const std::vector<NeededEffort>& needed,
               std::vector<double>& out) { out[j] += needed[j].total(); };
  };
  return term;
}

/// Difference of the links' inverse dynamics for one unit of each parameter. `change` alters the
/// model by `step` of parameter c.
using Change = std::function<void(SimParams&, std::size_t parameter)>;
std::function<ColumnsAt(const EffortRecording&)> link_columns(std::size_t columns, double step,
                                                              const Change& change) {
  return [columns, step, change](const EffortRecording& recording) -> ColumnsAt {
    auto changed = std::make_shared<std::vector<InverseEffort>>();
    for (std::size_t c = 0; c < columns; ++c) {
      SimParams params = recording.nominal;
      change(params, c);
      changed->emplace_back(params);
    }
    return [changed, columns, step](const MotionSample& m, const std::vector<NeededEffort>& needed,
                                    std::vector<double>& out) {
      for (std::size_t c = 0; c < columns; ++c) {
        JointVector load{};
        (*changed)[c].loads(m, load);
        for (std::size_t j = 0; j < needed.size(); ++j)
          out[j * columns + c] += (load[j] - needed[j].load) / step;
      }
    };
  };
}

EffortTerm link_term(const EffortRows& rows, const Effect& effect, std::size_t j) {
  EffortTerm term = term_of(effect);
  term.where = {joint_of(rows, j).link};
  for (std::size_t k = 0; k <= j; ++k) term.joints.push_back(k);
  const bool lengths = effect.effort.lengths;
  const Vec3& com = joint_of(rows, j).body.com;
  // a link reaches from its joint to about twice the distance of its centre of mass
  const double reach = std::max(0.05, 2.0 * std::hypot(com[0], com[1], com[2]));
  for (const std::size_t value : effect.effort.values) {
    const EffectParameter& p = effect.parameters[value];
    term.parameters.emplace_back(p.name);
    term.units.emplace_back(p.unit);
    // no negative mass, and any that is recorded
    term.low.push_back(lengths ? -reach : -1.0);
    term.high.push_back(lengths ? reach : effect.effort.bounded ? p.high : kInf);
  }
  term.low_is_nothing = !lengths;
  const double step = lengths ? kLengthStep : 1.0;
  term.columns = link_columns(term.size(), step, [&effect, j, step](SimParams& p, std::size_t c) {
    std::vector<double> theta = effect.null();
    theta[effect.effort.values[c]] = step;
    effect.apply(p, static_cast<int>(j), theta);
  });
  return term;
}

/// The encoder's zero as a change of the pose in which the links are weighed.
EffortTerm zero_term(const EffortRows& rows, const Effect& effect, std::size_t j) {
  EffortTerm term = term_of(effect);
  const EffectParameter& offset = effect.parameters[effect.effort.values.front()];
  term.where = {joint_of(rows, j).name};
  for (std::size_t k = 0; k <= j; ++k) term.joints.push_back(k);
  term.parameters = {std::string(offset.name)};
  term.units = {std::string(offset.unit)};
  term.low = {-kInf}, term.high = {kInf};
  term.columns = [j](const EffortRecording& recording) -> ColumnsAt {
    auto turned = std::make_shared<InverseEffort>(recording.nominal);
    return [turned, j](const MotionSample& m, const std::vector<NeededEffort>& needed,
                       std::vector<double>& out) {
      MotionSample there = m;
      there.q[j] -= kAngleStep;
      JointVector load{};
      turned->loads(there, load);
      for (std::size_t k = 0; k < needed.size(); ++k)
        out[k] += (load[k] - needed[k].load) / kAngleStep;
    };
  };
  return term;
}

/// A motor that turns with joint k and, one to one, with joint j before it, as in a wrist whose
/// last motor sits behind the bend: its friction and rotor act on both.
EffortTerm coupled_term(const EffortRows& rows, std::size_t j, std::size_t k, double ratio) {
  EffortTerm term;
  term.effect = kCoupledDrive.id;
  term.law.dry = DryFriction::adds;
  term.family = to_string(kCoupledDrive.family);
  term.where = {joint_of(rows, j).name, joint_of(rows, k).name};
  term.joints = {j, k};
  term.parameters = {"coulomb", "viscous", "armature"};
  term.units = {"N m", "N m s/rad", "kg m^2"};
  term.low = {0, 0, 0}, term.high = {kInf, kInf, kInf};
  term.fixed = {{"ratio", ratio}};
  term.columns = [j, k, ratio](const EffortRecording&) -> ColumnsAt {
    return [j, k, ratio](const MotionSample& m, const std::vector<NeededEffort>&,
                         std::vector<double>& out) {
      const double speed = m.dq[k] + ratio * m.dq[j];
      const double each[] = {speed > 0.0 ? 1.0 : (speed < 0.0 ? -1.0 : 0.0), speed,
                             m.ddq[k] + ratio * m.ddq[j]};
      for (std::size_t c = 0; c < 3; ++c)
        out[k * 3 + c] += each[c], out[j * 3 + c] += ratio * each[c];
    };
  };
  return term;
}

/// The term as a nuisance: within `tolerance` of its null.
EffortTerm as_nuisance(EffortTerm term, double tolerance, const ToleranceSettings& t) {
  term.nuisance = true;
  term.precision = t.precision / (tolerance * tolerance);
  term.low.assign(term.low.size(), -t.reach * tolerance);
  term.high.assign(term.high.size(), t.reach * tolerance);
  return term;
}

/// Effects with a tolerance of the effort, in its order.
std::vector<const Effect*> tolerated_efforts() {
  std::vector<const Effect*> out;
  for (const Effect& effect : library()) {
    if (effect.effort.tolerance) out.push_back(&effect);
  }
  std::sort(out.begin(), out.end(), [](const Effect* a, const Effect* b) {
    return a->effort.tolerance->order < b->effort.tolerance->order;
  });
  return out;
}

EffortTerm term_at(const EffortRows& rows, const Effect& effect, std::size_t j) {
  switch (effect.effort.kind) {
    case EffortKind::link:
      return link_term(rows, effect, j);
    case EffortKind::share:
      return share_term(rows, effect, j);
    case EffortKind::zero:
      return zero_term(rows, effect, j);
    default:
      return at_joint_term(rows, effect, j, effect.null());
  }
}

void add_nuisances(std::vector<EffortTerm>& all, const EffortRows& rows, std::size_t j,
                   const ToleranceSettings& t) {
  const EffortChannel& channel = first_of(rows).channels[j];
  for (const Effect* effect : tolerated_efforts()) {
    const EffortTolerance& stated = *effect->effort.tolerance;
    double tolerance = t.*stated.deviation * stated.of(first_of(rows).nominal, j);
    if (effect->effort.kind == EffortKind::share) {
      if (!channel.known || channel.column.empty()) continue;
      if (channel.gain_unknown) tolerance = kInf;
    }
    if (tolerance > 0.0) all.push_back(as_nuisance(term_at(rows, *effect, j), tolerance, t));
  }
}

/// Median speed of a joint in motion.
double usual_speed(const EffortRows& rows, std::size_t j) {
  std::vector<double> speed;
  for (const EffortRow& row : rows.rows) {
    if (row.joint == j)
      speed.push_back(std::abs(rows.recordings[row.recording].motion[row.first].dq[j]));
  }
  if (speed.empty()) return 1.0;
  std::nth_element(speed.begin(), speed.begin() + static_cast<long>(speed.size() / 2), speed.end());
  return speed[speed.size() / 2];
}

/// Values that are held, speeds as shares of the usual one at the joint.
std::vector<double> held_at(const EffortRows& rows, const Effect& effect, std::size_t j,
                            std::vector<double> theta) {
  for (std::size_t p = 0; p < theta.size(); ++p) {
    if (effect.parameters[p].scale == Unit::speed) theta[p] *= usual_speed(rows, j);
  }
  return theta;
}

void add_joint_terms(std::vector<EffortTerm>& all, const EffortRows& rows, std::size_t j) {
  const JointSettings& s = first_of(rows).nominal.joints[j].nominal;
  const EffortChannel& channel = first_of(rows).channels[j];
  if (!channel.known) return;
  for (const Effect* effect : effort_effects(EffortKind::joint)) {
    for (const std::vector<double>& held : effect->effort.held)
      all.push_back(at_joint_term(rows, *effect, j, held_at(rows, *effect, j, held)));
    if (!effect->effort.held.empty()) continue;
    all.push_back(at_joint_term(rows, *effect, j, effect->null()));
    // what the nominal model has of it is the most that may be taken away
    if (effect->effort.stated != nullptr) all.back().low.front() = -(s.*effect->effort.stated);
  }
  all.push_back(offset_term(rows, j));
  if (channel.column.empty() || channel.gain_unknown) return;
  for (const Effect* effect : effort_effects(EffortKind::share))
    all.push_back(share_term(rows, *effect, j));
}

}  // namespace

std::vector<EffortTerm> effort_terms(const EffortRows& rows, const Settings& settings) {
  std::vector<EffortTerm> all;
  const RobotTree& tree = first_of(rows).nominal.tree;
  for (std::size_t j = 0; j < tree.size(); ++j) add_nuisances(all, rows, j, settings.tolerances);
  for (std::size_t j = 0; j < tree.size(); ++j) add_joint_terms(all, rows, j);
  for (std::size_t j = 0; j < tree.size(); ++j) {
    for (const Effect* effect : effort_effects(EffortKind::link))
      all.push_back(link_term(rows, *effect, j));
    const TreeJoint& joint = joint_of(rows, j);
    if (joint.parent < 0 || joint.prismatic) continue;
    const auto before = static_cast<std::size_t>(joint.parent);
    if (joint_of(rows, before).prismatic) continue;
    for (const double ratio : {1.0, -1.0}) all.push_back(coupled_term(rows, before, j, ratio));
  }
  return all;
}

EffortTerm ripple_term(const EffortRows& rows, const Effect& effect, std::size_t joint, int order) {
  std::vector<double> theta = effect.null();
  for (std::size_t p = 0; p < theta.size(); ++p) {
    if (effect.parameters[p].role == Role::order) theta[p] = static_cast<double>(order);
  }
  return at_joint_term(rows, effect, joint, theta);
}

}  // namespace sanso::diagnose
