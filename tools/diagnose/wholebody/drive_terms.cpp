// Joints that are one kind of drive are asked as one number first, as they come out of one box.
#include "tools/diagnose/wholebody/drive_terms.h"

#include <algorithm>
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
  // without a current the loop's torque is held against the needed one, the gain's inverse times it
  const StanceSettings& s = asking.stance;
  const double least = s.least_gain, most = s.most_gain;
  const double low = current ? least - 1.0 : 1.0 - 1.0 / least;
  const double high = current ? most - 1.0 : 1.0 - 1.0 / most;
  switch (figure) {
    case JointFigure::gain:
      return {low, high, t.gain};
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
      return {s.least_torque - 1.0, s.most_torque - 1.0, t.motor};
    case JointFigure::rotor:
      break;
  }
  return {0.0, 0.0, kNoLimit};
}

/// An effect of the library, its first `numbers` parameters as they stand there.
DriveTerm term_of(const Effect& effect, std::size_t numbers) {
  DriveTerm out;
  out.effect = effect.id, out.family = to_string(effect.family);
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
  out.inverse = figure == JointFigure::gain && !rows.current;
  out.low = {bounds.low}, out.high = {bounds.high}, out.tolerance = bounds.tolerance;
  out.nothing = effect.parameters.front().null;
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
  centre.low.assign(3, -most), centre.high.assign(3, most);
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
  }
  for (int joint = -1; joint < static_cast<int>(tree.size()); ++joint)
    add_link(asking, rows, joint, out);
  return out;
}

DriveNuisances drive_nuisances(const Asking& asking, const DriveRows& rows) {
  const DriveColumns& c = rows.columns;
  std::vector<Eigen::VectorXd> columns;
  std::vector<double> spreads;
  const auto add = [&](const Eigen::VectorXd& column, double spread) {
    if (spread > 0.0) columns.push_back(column), spreads.push_back(spread);
  };
  const auto unit = [&](Eigen::Index at) {
    return Eigen::VectorXd(Eigen::VectorXd::Unit(c.count(), at));
  };
  double damping = 0.0;
  for (Eigen::Index j = 0; j < c.joints; ++j) {
    damping = std::max(damping, rows.laws[static_cast<std::size_t>(j)].damping);
    add(unit(c.joint(JointFigure::zero, j)), asking.tolerances.zero);
  }
  for (int joint = -1; joint < c.joints; ++joint) {
    const double mass = inertia_of(asking.body, joint).mass;
    add(at_centre(asking.body, c, joint), asking.tolerances.mass * mass);
    for (Eigen::Index i = 0; i < 3; ++i)
      add(unit(c.mass(joint) + 1 + i), asking.stance.moment * mass);
  }
  if (rows.current) add(unit(c.back_emf()), asking.stance.back_emf * damping);
  for (Eigen::Index i = 0; i < 3; ++i) add(unit(c.acc_bias() + i), asking.stance.acc_bias);
  DriveNuisances out;
  out.columns.resize(c.count(), static_cast<Eigen::Index>(columns.size()));
  out.precision.resize(static_cast<Eigen::Index>(columns.size()));
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    out.columns.col(k) = columns[i], out.precision[k] = 1.0 / (spreads[i] * spreads[i]);
  }
  return out;
}

}  // namespace sanso::diagnose
