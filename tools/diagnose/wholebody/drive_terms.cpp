// Joints that are one kind of drive are asked as one number first, as they come out of one box.
#include "tools/diagnose/wholebody/drive_terms.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

namespace sanso::diagnose {
namespace {

using Joints = std::vector<std::size_t>;
constexpr double kNoLimit = std::numeric_limits<double>::infinity();

bool one_kind(const DriveLaw& a, const DriveLaw& b) {
  return a.stiffness == b.stiffness && a.damping == b.damping && a.armature == b.armature &&
         a.torque_constant == b.torque_constant;
}

/// Joints before this one in its branch, and the branch's first joint.
std::pair<std::size_t, std::size_t> place_of(const RobotTree& tree, std::size_t joint) {
  std::size_t depth = 0;
  while (tree.joints[joint].parent >= 0)
    joint = static_cast<std::size_t>(tree.joints[joint].parent), ++depth;
  return {depth, joint};
}

/// Every joint alone, pairs at one place of two branches, branches, all of a kind.
std::vector<Joints> groups_of(const RobotTree& tree, const std::vector<DriveLaw>& laws) {
  std::set<Joints> out;
  const auto collect = [&](const auto& alike) {
    for (std::size_t a = 0; a < tree.size(); ++a) {
      Joints group;
      for (std::size_t b = 0; b < tree.size(); ++b) {
        if (one_kind(laws[a], laws[b]) && alike(a, b)) group.push_back(b);
      }
      out.insert(group);
    }
  };
  collect([](std::size_t, std::size_t) { return true; });
  collect([](std::size_t a, std::size_t b) { return a == b; });
  collect([&](std::size_t a, std::size_t b) {
    return place_of(tree, a).second == place_of(tree, b).second;
  });
  collect([&](std::size_t a, std::size_t b) {
    return place_of(tree, a).first == place_of(tree, b).first;
  });
  return {out.begin(), out.end()};
}

// In the order in which they are asked for.
constexpr JointFigure kFigures[] = {JointFigure::gain,  JointFigure::lag,  JointFigure::speed,
                                    JointFigure::dry,   JointFigure::load, JointFigure::zero,
                                    JointFigure::torque};

/// Of a coefficient x (DriveTerm).
struct Bounds {
  double low, high, tolerance;
};

Bounds bounds_of(JointFigure figure, const Asking& asking, const DriveLaw& l, bool current) {
  const ToleranceSettings& t = asking.tolerances;
  const StanceSettings& s = asking.stance;
  switch (figure) {
    case JointFigure::gain:
      if (current) return {s.least_gain - 1.0, s.most_gain - 1.0, t.gain};
      return {1.0 - 1.0 / s.least_gain, 1.0 - 1.0 / s.most_gain, t.gain};
    case JointFigure::lag:
      return {0.0, s.most_lag, t.lag};
    case JointFigure::speed:
      return {-l.damping, 5.0 * std::max(l.damping, 1.0), t.damping * l.damping};
    case JointFigure::dry:
      return {-l.coulomb, kNoLimit, std::max(s.coulomb, t.friction * l.coulomb)};
    case JointFigure::load:
      return {0.0, s.most_load, t.friction};
    case JointFigure::zero:
      return {-s.most_zero, s.most_zero, t.zero};
    case JointFigure::torque:
      return {1.0 - 1.0 / s.least_torque, 1.0 - 1.0 / s.most_torque, t.motor};
    case JointFigure::rotor:
      break;
  }
  return {0.0, 0.0, kNoLimit};
}

/// An effect of the library, its first `numbers` parameters as they stand there.
DriveTerm term_of(const Effect& effect, std::size_t numbers) {
  DriveTerm out;
  out.effect = effect.id, out.family = effect.family;
  for (std::size_t k = 0; k < numbers; ++k) {
    out.parameters.emplace_back(effect.parameters[k].name);
    out.units.emplace_back(effect.parameters[k].unit);
  }
  return out;
}

DriveTerm at_joints(const Asking& asking, const DriveRows& rows, JointFigure figure,
                    const Joints& joints) {
  const Effect& effect = *effect_of(figure);
  const DriveLaw& law = rows.laws[joints.front()];
  const Bounds bounds = bounds_of(figure, asking, law, rows.current);
  DriveTerm out = term_of(effect, 1);
  // what gives the torque is held against the torque that is needed, the scale's inverse times it
  out.inverse = figure == (rows.current ? JointFigure::torque : JointFigure::gain);
  out.low = {bounds.low}, out.high = {bounds.high}, out.tolerance = bounds.tolerance;
  out.nothing = effect.parameters.front().null;
  // goals are held for a row: where currents are read, a delay shows in whole ones
  if (figure == JointFigure::lag && rows.current)
    for (const WholeRecording& r : asking.recordings) out.steps = std::max(out.steps, r.interval);
  out.columns = Eigen::MatrixXd::Zero(rows.columns.count(), 1);
  for (const std::size_t j : joints) {
    out.where.push_back(asking.body.model.tree.joints[j].name);
    out.columns(rows.columns.joint(figure, static_cast<Eigen::Index>(j)), 0) = 1.0;
  }
  return out;
}

const BodyInertia& inertia_of(const WholeBody& body, int joint) {
  return joint < 0 ? body.base : body.model.tree.joints[static_cast<std::size_t>(joint)].body;
}

/// A kilogram at the centre of mass of a link.
Eigen::VectorXd at_centre(const WholeBody& body, const DriveColumns& c, int joint) {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(c.count());
  out[c.mass(joint)] = 1.0;
  out.segment<3>(c.mass(joint) + 1) = eigen(inertia_of(body, joint).com);
  return out;
}

/// Links of joints that are one group, heavier by one share.
void add_links(const Asking& asking, const DriveRows& rows, const Joints& joints,
               std::vector<DriveTerm>& out) {
  DriveTerm mass = term_of(effect_of(WholeFigure::mass_share), 1);
  mass.low = {asking.stance.least_mass - 1.0}, mass.high = {asking.stance.most_mass};
  mass.tolerance = asking.tolerances.mass;
  mass.columns = Eigen::MatrixXd::Zero(rows.columns.count(), 1);
  for (const std::size_t j : joints) {
    const int joint = static_cast<int>(j);
    const double kg = inertia_of(asking.body, joint).mass;
    if (!(kg > 0.0)) return;
    mass.where.push_back(asking.body.model.tree.joints[j].link);
    mass.columns += kg * at_centre(asking.body, rows.columns, joint);
  }
  out.push_back(mass);
}

/// Sensors under the feet that read too much.
DriveTerm scale_of_forces(const Asking& asking, const DriveRows& rows) {
  DriveTerm out = term_of(effect_of(WholeFigure::force_scale), 1);
  out.low = {asking.stance.least_mass - 1.0}, out.high = {asking.stance.most_mass};
  out.nothing = 1.0, out.tolerance = asking.settings.scale;
  out.columns = Eigen::VectorXd::Unit(rows.columns.count(), rows.columns.force_scale());
  return out;
}

/// A vertical that is felt wrong moves every weight to one side: what a centre elsewhere does too.
DriveTerm turned_sensor(const Asking& asking, const DriveRows& rows) {
  DriveTerm out = term_of(effect_of(WholeFigure::imu_turn), 2);
  const double g = eigen(asking.body.model.gravity).norm();
  out.low.assign(2, -asking.stance.most_zero), out.high.assign(2, asking.stance.most_zero);
  out.tolerance = asking.settings.mount;
  out.columns = Eigen::MatrixXd::Zero(rows.columns.count(), 2);
  out.columns(rows.columns.acc_bias() + 1, 0) = g;
  out.columns(rows.columns.acc_bias(), 1) = -g;
  return out;
}

void add_link(const Asking& asking, const DriveRows& rows, int joint, std::vector<DriveTerm>& out) {
  const WholeBody& body = asking.body;
  const BodyInertia& b = inertia_of(body, joint);
  if (!(b.mass > 0.0)) return;
  const DriveColumns& c = rows.columns;
  const Eigen::VectorXd kilogram = at_centre(body, c, joint);
  const std::string link =
      joint < 0 ? body.root : body.model.tree.joints[static_cast<std::size_t>(joint)].link;
  DriveTerm mass = term_of(effect_of(WholeFigure::mass_share), 1);
  mass.where = {link};
  mass.low = {asking.stance.least_mass - 1.0}, mass.high = {asking.stance.most_mass},
  mass.tolerance = asking.tolerances.mass;
  mass.columns = b.mass * kilogram;
  out.push_back(mass);
  const double most = asking.stance.most_place;
  DriveTerm centre = term_of(effect_of(WholeFigure::centre), 3);
  centre.where = {link};
  for (std::size_t k = 0; k < 3; ++k) {
    const EffectParameter& p = effect_of(WholeFigure::centre).parameters[k];
    centre.low.push_back(p.low * b.mass), centre.high.push_back(p.high * b.mass);
  }
  centre.tolerance = asking.stance.centre * b.mass, centre.mass = b.mass;
  centre.columns = Eigen::MatrixXd::Zero(c.count(), 3);
  for (Eigen::Index i = 0; i < 3; ++i) centre.columns(c.mass(joint) + 1 + i, i) = 1.0;
  out.push_back(centre);
  DriveTerm payload = term_of(effect_of(WholeFigure::payload), 4);
  payload.where = {link};
  payload.carried = true, payload.centre = eigen(b.com);
  payload.low = {0.0, -most, -most, -most},
  payload.high = {asking.stance.most_mass * body.mass(), most, most, most};
  payload.tolerance = asking.tolerances.mass * b.mass;
  payload.columns.resize(c.count(), 4);
  payload.columns << kilogram, centre.columns;
  out.push_back(payload);
}

}  // namespace

std::vector<DriveTerm> drive_terms(const Asking& asking, const DriveRows& rows) {
  std::vector<DriveTerm> out;
  const RobotTree& tree = asking.body.model.tree;
  for (const Joints& joints : groups_of(tree, rows.laws)) {
    for (const JointFigure figure : kFigures) {
      // nothing tells a torque constant without a current; zeros differ from joint to joint
      if (figure == JointFigure::torque && !rows.current) continue;
      if (figure == JointFigure::zero && joints.size() > 1) continue;
      out.push_back(at_joints(asking, rows, figure, joints));
    }
    if (joints.size() > 1) add_links(asking, rows, joints, out);
  }
  if (rows.weighed) out.push_back(scale_of_forces(asking, rows));
  out.push_back(turned_sensor(asking, rows));
  for (int joint = -1; joint < static_cast<int>(tree.size()); ++joint)
    add_link(asking, rows, joint, out);
  std::erase_if(out, [&](const DriveTerm& t) {
    return !asking.effects.empty() && std::find(asking.effects.begin(), asking.effects.end(),
                                                t.effect) == asking.effects.end();
  });
  return out;
}

namespace {

/// What the figures of a joint's drive may be off by.
std::vector<std::pair<JointFigure, double>> tolerances_of(const Asking& asking, const DriveLaw& l,
                                                          bool current) {
  const ToleranceSettings& t = asking.tolerances;
  std::vector<std::pair<JointFigure, double>> out = {
      {JointFigure::zero, t.zero},
      {JointFigure::gain, t.gain},
      {JointFigure::speed, t.damping * l.damping},
      {JointFigure::dry, std::max(asking.stance.coulomb, t.friction * l.coulomb)},
      {JointFigure::load, t.friction},
      // smoothing takes a share of every acceleration, as a lighter rotor would
      {JointFigure::rotor, std::hypot(t.armature, asking.stance.acceleration) * l.armature}};
  if (current) out.emplace_back(JointFigure::torque, t.motor);
  return out;
}

std::string in_words(JointFigure figure) {
  const Effect* effect = effect_of(figure);
  return effect != nullptr ? std::string(effect->name) : "rotor inertia";
}

}  // namespace

DriveNuisances drive_nuisances(const Asking& asking, const DriveRows& rows) {
  const DriveColumns& c = rows.columns;
  std::vector<Eigen::VectorXd> columns;
  std::vector<double> spreads;
  DriveNuisances out;
  const auto add = [&](const Eigen::VectorXd& column, double spread, const std::string& name) {
    if (!(spread > 0.0)) return;
    columns.push_back(column), spreads.push_back(spread), out.names.push_back(name);
  };
  const auto unit = [&](Eigen::Index at) {
    return Eigen::VectorXd(Eigen::VectorXd::Unit(c.count(), at));
  };
  double damping = 0.0;
  Eigen::VectorXd lag = Eigen::VectorXd::Zero(c.count());
  for (Eigen::Index j = 0; j < c.joints; ++j) {
    const DriveLaw& l = rows.laws[static_cast<std::size_t>(j)];
    damping = std::max(damping, l.damping);
    const std::string& place = asking.body.model.tree.joints[static_cast<std::size_t>(j)].name;
    for (const auto& [figure, spread] : tolerances_of(asking, l, rows.current))
      add(unit(c.joint(figure, j)), spread, in_words(figure) + " of " + place);
    lag[c.joint(JointFigure::lag, j)] = 1.0;
  }
  // instants inside a row are known to a part of it
  double row = 0.0;
  for (const WholeRecording& r : asking.recordings) row = std::max(row, r.interval);
  add(lag, std::max(asking.tolerances.lag, asking.stance.instant * row), "delay of all goals");
  if (rows.weighed) add(unit(c.force_scale()), asking.settings.scale, "scale of the feet's forces");
  for (int joint = -1; joint < c.joints; ++joint) {
    const double mass = inertia_of(asking.body, joint).mass;
    const std::string place =
        joint < 0 ? asking.body.root
                  : asking.body.model.tree.joints[static_cast<std::size_t>(joint)].link;
    add(at_centre(asking.body, c, joint), asking.tolerances.mass * mass, "mass of " + place);
    for (Eigen::Index i = 0; i < 3; ++i)
      add(unit(c.mass(joint) + 1 + i), asking.stance.moment * mass, "centre of " + place);
  }
  if (rows.current)
    add(unit(c.back_emf()), asking.stance.back_emf * damping, "damping that is electrical");
  for (Eigen::Index i = 0; i < 3; ++i)
    add(unit(c.acc_bias() + i), asking.stance.acc_bias, "vertical that is felt");
  out.columns.resize(c.count(), static_cast<Eigen::Index>(columns.size()));
  out.precision.resize(static_cast<Eigen::Index>(columns.size()));
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    out.columns.col(k) = columns[i], out.precision[k] = 1.0 / (spreads[i] * spreads[i]);
  }
  return out;
}

}  // namespace sanso::diagnose
