// Rigid bodies: M1 to M5 of the method page.
#include <algorithm>
#include <cmath>

#include "tools/diagnose/effects/families.h"

namespace sanso::diagnose {
namespace {

/// Rotation by small angles about two axes perpendicular to `axis` (exact rotation by their
/// resultant).
Vec3 tilted(const Vec3& axis, double about_1, double about_2) {
  // two unit vectors perpendicular to the axis, fixed by the axis alone
  const Vec3 helper = std::abs(axis[0]) < 0.9 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const auto cross = [](const Vec3& a, const Vec3& b) {
    return Vec3{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  };
  const auto unit = [](Vec3 v) {
    const double n = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (double& c : v) c /= n;
    return v;
  };
  const Vec3 e1 = unit(cross(axis, helper)), e2 = cross(axis, e1);
  const Vec3 moved{axis[0] + about_1 * e1[0] + about_2 * e2[0],
                   axis[1] + about_1 * e1[1] + about_2 * e2[1],
                   axis[2] + about_1 * e1[2] + about_2 * e2[2]};
  return unit(moved);
}

/// v' I v
double along(const BodyInertia& b, const Vec3& v) {
  double sum = 0.0;
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 3; ++c) sum += v[r] * b.about_com[3 * r + c] * v[c];
  }
  return sum;
}

/// Of the link behind joint j: its own inertia, about its centre of mass, and that about its joint.
struct TurnedInertia {
  double own = 0.0, about_joint = 0.0;  // kg m^2
};

/// About the axis of the joint; behind a slide, about no axis in particular.
TurnedInertia turned_inertia(const TreeJoint& joint) {
  const BodyInertia& b = joint.body;
  const Vec3& c = b.com;
  const Vec3& a = joint.axis;
  const double far = c[0] * c[0] + c[1] * c[1] + c[2] * c[2];
  if (joint.prismatic) {
    const double mean = (b.about_com[0] + b.about_com[4] + b.about_com[8]) / 3.0;
    return {mean, mean + b.mass * far};
  }
  const double ahead = a[0] * c[0] + a[1] * c[1] + a[2] * c[2];
  const double own = along(b, a);
  return {own, own + b.mass * (far - ahead * ahead)};
}

/// What a body can give of its own inertia.
double gives(const SimParams& p, const TurnedInertia& is) {
  return (1.0 - p.settings.own_inertia) * is.own;
}

/// The body's own inertia grows or shrinks in its shape until that about its joint has changed by
/// `share`: one law on both sides of nothing, and to its joint the same as a rotor. A body without
/// own inertia gains alike about all axes.
void add_inertia(SimParams& p, int j, double share) {
  BodyInertia& b = body(p, j);
  const TurnedInertia is = turned_inertia(p.tree.joints[static_cast<std::size_t>(j)]);
  const double added = std::max(share * is.about_joint, -gives(p, is));
  const bool thin = is.own <= 1e-3 * is.about_joint;  // no shape to grow in
  for (std::size_t k = 0; k < 9; ++k) {
    if (thin && added > 0.0)
      b.about_com[k] += k % 4 == 0 ? added : 0.0;
    else if (is.own > 0.0)
      b.about_com[k] *= 1.0 + added / is.own;
  }
}

void lengthen(SimParams& p, int j, double length, double tilt_1, double tilt_2) {
  TreeJoint& t = p.tree.joints[static_cast<std::size_t>(j)];
  const Vec3& r = t.p_parent_joint;
  const double distance = std::sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
  if (length != 0.0 && distance > 0.0) {
    for (double& c : t.p_parent_joint) c *= 1.0 + length / distance;
  }
  if (tilt_1 != 0.0 || tilt_2 != 0.0) t.axis = tilted(t.axis, tilt_1, tilt_2);
}

Effect of_link(Effect effect) {
  return of_chapter({Family::mass, Port::rigid_body, Scope::link, kR2 | kR3 | kR5},
                    std::move(effect));
}
Effect of_joint(Effect effect) {
  return of_chapter({Family::mass, Port::rigid_body, Scope::joint, kR2 | kR3 | kR5},
                    std::move(effect));
}

/// Lengths are wrong along the line from a turning joint to its link's centre of mass.
std::vector<double> along_the_link(const SimParams& p, std::size_t j) {
  const TreeJoint& joint = p.tree.joints[j];
  if (joint.prismatic) return {};
  return {joint.body.com[0], joint.body.com[1], joint.body.com[2]};
}

/// ... and from the joint before it to its own, along the link that holds both.
std::vector<double> along_the_link_before(const SimParams& p, std::size_t j) {
  const TreeJoint& joint = p.tree.joints[j];
  const Vec3& r = joint.p_parent_joint;
  const double distance = std::hypot(r[0], r[1], r[2]);
  if (joint.parent < 0 || distance == 0.0) return {};
  return {distance, 0.0, 0.0};
}

/// From the joint to its link's centre of mass.
double how_far_out(const SimParams& p, std::size_t j) {
  const Vec3& com = p.tree.joints[j].body.com;
  return std::hypot(com[0], com[1], com[2]);
}

Effect link_mass() {
  return of_link({
      .id = "link_mass",
      .code = "M1",
      .name = "link mass",
      .form = "mass and inertia times 1 + share",
      .parameters = {{"share", "-", 0, -0.6, 1, 0.1}},
      .terms = kOfAngle | kOfAcceleration,
      .probes = {{0.1}},
      .cluster = "A",
      .confounders = {"servo_p_gain", "torque_constant", "battery_drift", "payload", "link_com"},
      .regimes = {"high load", "accelerating"},
      .signature = "gravity and inertia together",
      .experiments = {kAddPayload, kTilt},
      .tolerances = {{.name = "mass",
                      .order = 1,
                      .deviation = &ToleranceSettings::mass,
                      .direction = everywhere({1.0})}},
      .effort = {.kind = EffortKind::link,
                 .order = 1,
                 .wild = 1.0,  // more than doubles
                 .tolerance = within(1, &ToleranceSettings::mass)},
      .whole = WholeFigure::mass_share,
      .apply =
          [](SimParams& p, int j, Theta x) {
            body(p, j).mass *= 1.0 + x[0];
            for (double& i : body(p, j).about_com) i *= 1.0 + x[0];
          },
  });
}

Effect link_com() {
  return of_link({
      .id = "link_com",
      .code = "M2",
      .name = "centre of mass of a link",
      .form = "com + (x, y, z)",
      // a link reaches from its joint to about twice the distance of its centre of mass (scaled
      // to 0.1 m)
      .parameters = {{"x", "m", 0, -0.1, 0.1, 0.005, Unit::length},
                     {"y", "m", 0, -0.1, 0.1, 0.005, Unit::length},
                     {"z", "m", 0, -0.1, 0.1, 0.005, Unit::length}},
      .terms = kOfAngle | kOfAcceleration,
      .probes = {{0.005, 0, 0}, {0, 0.005, 0}, {0, 0, 0.005}},
      .cluster = "E",
      .confounders = {"encoder_offset", "ground_slope", "imu_misalignment", "cable_spring",
                      "link_mass"},
      .regimes = {"standstill", "high load"},
      .signature = "static error that follows the posture",
      .experiments = {kTilt, kPostures},
      .tolerances = {{.name = "length",
                      .order = 2,
                      .deviation = &ToleranceSettings::length,
                      .direction = along_the_link}},
      .effort = {.kind = EffortKind::link,
                 .order = 2,
                 .values = {0, 1, 2},
                 .lengths = true,
                 .tolerance = EffortTolerance{2, &ToleranceSettings::length, how_far_out}},
      .whole = WholeFigure::centre,
      .apply =
          [](SimParams& p, int j, Theta x) {
            for (std::size_t k = 0; k < 3; ++k) body(p, j).com[k] += x[k];
          },
  });
}

Effect link_inertia() {
  return of_link({
      .id = "link_inertia",
      .code = "M3",
      .name = "rotational inertia of a link",
      .form = "+share of the inertia about its joint",
      // mass r^2 at the centre of mass to twice that, half of it at either end of such a link
      .parameters = {{"share", "-", 0, -0.6, 1, 0.1}},
      .terms = kOfAcceleration,
      .probes = {{0.1}},
      .cluster = "F",
      .confounders = {"rotor_inertia", "link_mass"},
      .regimes = {"accelerating"},
      .signature = "fast motion",
      .experiments = {kAddPayload, kChirp},
      // at most as if the mass sat at the link's ends; what resists more is a rotor
      .effort = {.kind = EffortKind::link, .order = 3, .bounded = true},
      // no body gives more than it has
      .lowest =
          [](const SimParams& p, std::size_t j) {
            const TurnedInertia is = turned_inertia(p.tree.joints[j]);
            return is.about_joint > 0.0 ? -gives(p, is) / is.about_joint : 0.0;
          },
      .apply = [](SimParams& p, int j, Theta x) { add_inertia(p, j, x[0]); },
  });
}

Effect payload() {
  return of_link({
      .id = "payload",
      .code = "M4",
      .name = "payload",
      .form = "mass at (x, y, z) of the link from the instant `from` on",
      // of a uniform rod: half its length beyond its end
      .parameters = {{"mass", "kg", 0, 0, 1, 0.1, Unit::torque},
                     {"x", "m", 0, -0.3, 0.3, 0.05, Unit::reach},
                     {"y", "m", 0, -0.3, 0.3, 0.05, Unit::reach},
                     {"z", "m", 0, -0.3, 0.3, 0.05, Unit::reach},
                     {"from", "s", 0, 0, 1e4, 1, Unit::none, true, Role::instant}},
      .smooth = false,
      .terms = kOfAngle | kOfAcceleration,
      .probes =
          {{0.1, 0, 0, -0.1, 0}, {0.1, 0, 0, 0.1, 0}, {0.1, 0.1, 0, 0, 0}, {0.1, -0.1, 0, 0, 0}},
      .sign = 1,
      .cluster = "J",
      .confounders = {"link_mass", "external_push", "tether"},
      .contains = {"link_mass", "link_com"},
      .another_cause = true,
      .regimes = {"high load", "late"},
      .signature = "a step in time",
      .experiments = {kTilt},
      .whole = WholeFigure::payload,
      .apply =
          [](SimParams& p, int j, Theta x) {
            if (x[0] != 0.0) p.late_payloads.push_back({j, {x[0], {x[1], x[2], x[3]}, {}}, x[4]});
          },
  });
}

Effect link_geometry() {
  return of_joint({
      .id = "link_geometry",
      .code = "M5",
      .name = "link length or joint axis",
      .form = "joint origin + length along its own direction, axis tilted",
      .parameters = {{"length", "m", 0, -0.02, 0.02, 0.001, Unit::length},
                     {"tilt_1", "rad", 0, -0.09, 0.09, 0.01},
                     {"tilt_2", "rad", 0, -0.09, 0.09, 0.01}},
      .probes = {{0.005, 0, 0}, {0, 0.02, 0}, {0, 0, 0.02}},
      .residuals = kR2 | kR3 | kR6,
      .confounders = {"encoder_offset", "link_com"},
      .regimes = {"high load"},
      .signature = "position of the link, many postures",
      .experiments = {kOutsideSensor, kPostures},
      .tolerances = {{.name = "place",
                      .order = 10,
                      .deviation = &ToleranceSettings::length,
                      .direction = along_the_link_before}},
      .apply = [](SimParams& p, int j, Theta x) { lengthen(p, j, x[0], x[1], x[2]); },
  });
}

}  // namespace

std::vector<Effect> mass_effects() {
  return {link_mass(), link_com(), link_inertia(), payload(), link_geometry()};
}

}  // namespace sanso::diagnose
