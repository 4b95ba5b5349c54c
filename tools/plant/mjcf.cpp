// Text of the model: links from the maker's data, primitives for contacts, the ground from the
// world's parameters.
#include "tools/plant/mjcf.h"

#include <fmt/format.h>

#include <algorithm>

#include "tools/plant/body_data.h"
#include "tools/plant/ground_profile.h"
#include "tools/plant/random.h"

namespace sanso::plant {
namespace {

// Left sole, ank_roll frame: eight corners of the outline, measured from the maker's foot mesh. The
// right one mirrors y.
constexpr double kSoleZ_m = -0.0305;
constexpr double kSoleCorners_m[8][2] = {{0.0875, 0.0391},  {0.0815, 0.0515},   {-0.0335, 0.0515},
                                         {-0.0395, 0.0391}, {-0.0395, -0.0141}, {-0.0335, -0.0265},
                                         {0.0815, -0.0265}, {0.0875, -0.0141}};
constexpr double kCornerRadius_m = 0.003;  // fillet of the sole's edge (2 to 4 mm on the mesh)

// Skate: axles under the sole, along y; the rest of its mass is a frame under the sole's centre.
constexpr double kSkateCentre_m[2] = {0.024, 0.0125};
constexpr double kAxleSigns[4][2] = {{1, 1}, {-1, 1}, {-1, -1}, {1, -1}};

// Limbs as primitives, so that a fallen robot lies on something. Sizes from the maker's drawings,
// rounded.
struct Primitive {
  const char* link;
  const char* geom;
};
constexpr Primitive kBodyPrimitives[] = {
    {"body_link", R"(type="box" size="0.045 0.065 0.070" pos="-0.015 0 0.060")"},
    {"head_tilt_link", R"(type="box" size="0.040 0.050 0.035" pos="0.005 -0.019 0.040")"},
    {"r_sho_roll_link", R"(type="capsule" size="0.018" fromto="0.0 -0.01 0 0.0 -0.085 0")"},
    {"l_sho_roll_link", R"(type="capsule" size="0.018" fromto="0.0 0.01 0 0.0 0.085 0")"},
    {"r_el_link", R"(type="capsule" size="0.015" fromto="-0.019 -0.02 0 -0.019 -0.13 0")"},
    {"l_el_link", R"(type="capsule" size="0.015" fromto="-0.019 0.02 0 -0.019 0.13 0")"},
    {"r_hip_pitch_link", R"(type="capsule" size="0.020" fromto="0 0.019 -0.02 0 0.019 -0.10")"},
    {"l_hip_pitch_link", R"(type="capsule" size="0.020" fromto="0 -0.019 -0.02 0 -0.019 -0.10")"},
    {"r_knee_link", R"(type="capsule" size="0.020" fromto="0 0.019 -0.01 0 0.019 -0.09")"},
    {"l_knee_link", R"(type="capsule" size="0.020" fromto="0 -0.019 -0.01 0 -0.019 -0.09")"},
};

// Mechanical stops are not published. The maker's kinematics class gives working ranges, and its
// crouch bends the knee 16 deg beyond them: stops are put 0.35 rad outside. Units of pi rad.
struct Range {
  const char* joint;
  double lower, upper;
};
constexpr Range kWorkingRanges[] = {
    {"head_pan", -0.5, 0.5},   {"head_tilt", -0.5, 0.5},  {"sho_pitch", -0.5, 0.5},
    {"r_sho_roll", -0.5, 0.3}, {"l_sho_roll", -0.3, 0.5}, {"el", -0.5, 0.5},
    {"hip_yaw", -0.45, 0.45},  {"hip_roll", -0.3, 0.3},   {"hip_pitch", -0.4, 0.4},
    {"r_knee", -0.7, 0.1},     {"l_knee", -0.1, 0.7},     {"ank_pitch", -0.45, 0.45},
    {"ank_roll", -0.45, 0.45},
};
constexpr double kStopMargin_rad = 0.35;

Range stop_range(const std::string& joint) {
  for (const Range& range : kWorkingRanges) {
    if (joint.ends_with(range.joint)) {
      return {range.joint, range.lower * kPi - kStopMargin_rad,
              range.upper * kPi + kStopMargin_rad};
    }
  }
  return {"", -kPi, kPi};
}

std::string text(const Vec3& v) { return fmt::format("{:.9g} {:.9g} {:.9g}", v[0], v[1], v[2]); }

std::string inertial(LinkData link, const World& world) {
  Vec3 com = link.com_m;
  double mass = link.mass_kg;
  if (link.name == "body_link") {
    mass += world.body.torso_extra_mass_kg;
    com = com + world.body.torso_com_offset_m;
  } else if (link.name.find("sho") == std::string::npos &&
             link.name.find("el_") == std::string::npos &&
             link.name.find("head") == std::string::npos) {
    mass *= world.body.leg_mass_scale;
  }
  const double s = mass / link.mass_kg;  // added mass is spread like the link's own
  return fmt::format(
      R"(<inertial pos="{}" mass="{:.9g}" fullinertia="{:.9g} {:.9g} {:.9g} {:.9g} {:.9g} )"
      R"({:.9g}"/>)",
      text(com), mass, s * link.ixx, s * link.iyy, s * link.izz, s * link.ixy, s * link.ixz,
      s * link.iyz);
}

/// A plate for the other foot to meet; clear of the ground by a centimetre.
std::string foot_plate(bool left) {
  return fmt::format(
      R"(<geom class="{}" type="box" size="0.06 0.036 0.008" pos="0.024 {:.4f} -0.0125"/>)",
      left ? "left" : "right", left ? 0.0125 : -0.0125);
}

/// Wheels are balls that turn about their axle alone: as the crown of a real one they touch in a
/// point, and MuJoCo rolls a ball over the seams of boxes exactly.
std::string skate(bool left, const WheelParameters& w) {
  const double y_centre = (left ? 1.0 : -1.0) * kSkateCentre_m[1];
  const char* side = left ? "l" : "r";
  const double frame = w.skate_mass_kg - 4 * w.wheel_mass_kg;
  const double inertia = 0.5 * w.wheel_mass_kg * w.radius_m * w.radius_m;
  // a plate as long and as wide as the axles are apart
  const double xx = w.wheelbase_m * w.wheelbase_m, yy = w.track_m * w.track_m,
               zz = w.radius_m * w.radius_m;
  std::string out =
      fmt::format(R"(<body name="{}_skate" pos="{} {} {}"><inertial pos="0 0 0" mass="{}" )"
                  R"(diaginertia="{} {} {}"/></body>)",
                  side, kSkateCentre_m[0], y_centre, kSoleZ_m - 0.5 * w.radius_m, frame,
                  frame * (yy + zz) / 12, frame * (xx + zz) / 12, frame * (xx + yy) / 12);
  for (int i = 0; i < 4; ++i) {
    out += fmt::format(
        R"(<body name="{0}_wheel{1}" pos="{2} {3} {4}"><joint name="{0}_wheel{1}" axis="0 1 0" )"
        R"(limited="false" armature="0" frictionloss="{5}"/>)"
        R"(<inertial pos="0 0 0" mass="{6}" diaginertia="{7} {8} {7}"/>)"
        R"(<geom name="{0}_sole{1}" class="sole" type="sphere" size="{9}"/></body>)",
        side, i, kSkateCentre_m[0] + 0.5 * kAxleSigns[i][0] * w.wheelbase_m,
        y_centre + (left ? 0.5 : -0.5) * kAxleSigns[i][1] * w.track_m, kSoleZ_m - w.radius_m,
        w.bearing_Nm, w.wheel_mass_kg, 0.5 * inertia, inertia, w.radius_m);
  }
  return out;
}

std::string soles(bool left, const World& world) {
  if (world.feet == FeetKind::wheels) return skate(left, world.wheels);
  const double mirror = left ? 1.0 : -1.0;
  const char* side = left ? "l" : "r";
  std::string out;
  for (int i = 0; i < 8; ++i) {
    out += fmt::format(
        R"(<geom name="{}_sole{}" class="sole" type="sphere" size="{}" pos="{} {} {}"/>)", side, i,
        kCornerRadius_m, kSoleCorners_m[i][0], mirror * kSoleCorners_m[i][1],
        kSoleZ_m + kCornerRadius_m);
  }
  return out;
}

/// Legs meet those of the other side where the world says so; all limbs meet the ground.
const char* limb_class(const LinkData& link, const World& world) {
  const bool leg =
      link.name.find("hip") != std::string::npos || link.name.find("knee") != std::string::npos;
  if (!world.body.self_collision || !leg) return "limb";
  return link.name[0] == 'l' ? "left" : "right";
}

void write_link(std::string& out, const LinkData& link, const World& world) {
  const BodyData& body = op3_body();
  out += inertial(link, world);
  for (const Primitive& p : kBodyPrimitives) {
    if (link.name == p.link)
      out += fmt::format(R"(<geom class="{}" {}/>)", limb_class(link, world), p.geom);
  }
  if (link.name == "r_ank_roll_link" || link.name == "l_ank_roll_link") {
    out += soles(link.name[0] == 'l', world);
    if (world.body.self_collision) out += foot_plate(link.name[0] == 'l');
  }
  for (const JointData& joint : body.joints) {
    if (joint.parent != link.name) continue;
    const Range stops = stop_range(joint.name);
    out += fmt::format(
        R"(<body name="{}" pos="{}"><joint name="{}" axis="{}" range="{:.6f} {:.6f}"/>)",
        joint.child, text(joint.origin_m), joint.name, text(joint.axis), stops.lower, stops.upper);
    for (const LinkData& child : body.links) {
      if (child.name == joint.child) write_link(out, child, world);
    }
    out += "</body>\n";
  }
}

/// A box whose top face is the facet.
std::string slab(const Facet& f, double width, double friction) {
  constexpr double kHalfThick_m = 0.05;
  const double length = std::hypot(f.x1 - f.x0, f.z1 - f.z0);
  const double pitch = std::atan2(f.z0 - f.z1, f.x1 - f.x0);  // about y, positive is downhill
  const Vec3 centre{0.5 * (f.x0 + f.x1) - kHalfThick_m * std::sin(pitch), 0.0,
                    0.5 * (f.z0 + f.z1) - kHalfThick_m * std::cos(pitch)};
  // of two geoms MuJoCo takes the larger friction, unless one has priority
  const std::string patch = f.friction_factor == 1.0
                                ? ""
                                : fmt::format(R"(friction="{:.9g} 0.003 0.0001" priority="1")",
                                              f.friction_factor * friction);
  return fmt::format(R"(<geom class="ground" type="box" size="{:.9g} {:.6g} {}" pos="{}" )"
                     R"(euler="0 {:.12g} 0" {}/>)"
                     "\n",
                     0.5 * length, 0.5 * width, kHalfThick_m, text(centre), pitch, patch);
}

/// Facets side by side; a floor below, for what falls off the edge.
std::string profile(const GroundParameters& g) {
  const GroundProfile surface = load_profile(g.profile);
  std::string out;
  double lowest = 0.0;
  for (const Facet& f : surface.facets) {
    out += slab(f, surface.width_m, g.friction);
    lowest = std::min({lowest, f.z0, f.z1});
  }
  constexpr double kBelow_m = 0.02;
  return out + fmt::format(
                   R"(<geom name="floor" class="ground" type="plane" size="0 0 1" pos="0 0 {}"/>)",
                   lowest - kBelow_m);
}

/// A plane, tilted where the world says so, or a profile.
std::string ground(const GroundParameters& g) {
  if (g.profile != "plane") return profile(g);
  if (g.tilt_roll_rad == 0.0 && g.tilt_pitch_rad == 0.0)
    return R"(<geom name="ground" class="ground" type="plane" size="0 0 1"/>)";
  return fmt::format(
      R"(<geom name="ground" class="ground" type="plane" size="0 0 1" euler="{:.9f} {:.9f} 0"/>)",
      g.tilt_roll_rad, g.tilt_pitch_rad);
}

/// Plates of 0.1 m x 0.1 m within a metre; where the robot starts, the floor is free.
std::string plates(const GroundParameters& g, std::uint64_t seed) {
  Random random(seed ^ 0x9A7E5u);
  std::string out;
  for (std::uint64_t i = 0; i < g.plates; ++i) {
    const double x = random.uniform(-1.0, 1.0), y = random.uniform(-1.0, 1.0);
    constexpr double kFree_m = 0.17;
    if (std::abs(x) < kFree_m && std::abs(y) < kFree_m) continue;
    const double top = y * g.tilt_roll_rad - x * g.tilt_pitch_rad + g.plate_height_m;
    constexpr double kHalfThick_m = 0.01;
    out += fmt::format(R"(<geom class="ground" type="box" size="0.05 0.05 {}" )"
                       R"(pos="{:.6f} {:.6f} {:.6f}" euler="{:.9f} {:.9f} 0"/>)",
                       kHalfThick_m, x, y, top - kHalfThick_m, g.tilt_roll_rad, g.tilt_pitch_rad);
  }
  return out;
}

}  // namespace

std::string make_mjcf(const World& world) {
  std::string out = fmt::format(R"(<mujoco model="op3">
<compiler angle="radian" boundmass="1e-6"/>
<option timestep="{}" cone="pyramidal" solver="Newton" iterations="20" tolerance="1e-8"
 gravity="0 0 -9.81"/>
<size njmax="400" nconmax="80"/>
<default>
<joint armature="{}" damping="0" limited="true" solreflimit="0.01 1"/>
<geom solref="{} 1" friction="{} 0.003 0.0001" condim="3"/>
<default class="ground"><geom contype="1" conaffinity="0" group="1"/></default>
<default class="sole"><geom contype="0" conaffinity="1" mass="0"/></default>
<default class="limb"><geom contype="0" conaffinity="1" mass="0"/></default>
<default class="right"><geom contype="2" conaffinity="5" mass="0"/></default>
<default class="left"><geom contype="4" conaffinity="3" mass="0"/></default>
</default>
<worldbody>
)",
                                kPhysicsStep_s, world.servo.output_inertia_kgm2,
                                world.ground.contact_time_s, world.ground.friction);
  out += ground(world.ground);
  if (world.ground.profile == "plane") out += plates(world.ground, world.servo.spread_seed);
  out += "\n<body name=\"body_link\" pos=\"0 0 0.28\"><freejoint name=\"base\"/>";
  for (const LinkData& link : op3_body().links) {
    if (link.parent.empty()) write_link(out, link, world);
  }
  out += "</body>\n</worldbody>\n</mujoco>\n";
  return out;
}

}  // namespace sanso::plant
