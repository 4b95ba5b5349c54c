// One function a motion: clip, figures of the retargeting, weights and success clauses, with the
// reason where a figure is not the plain one.
#include "host/motion/catalogue.h"

namespace sanso::motion {
namespace {

const ClipSource kAccad = {
    "Open Motion Data, Advanced Computing Center for the Arts and Design, The Ohio State "
    "University (set Male 1)",
    "CC BY 3.0", "retargeted to the ROBOTIS OP3, slowed down, fitted by movement primitives"};
const ClipSource kMass = {
    "lsw9021/MASS, data/motion/balance.bvh", "Apache-2.0",
    "one-leg hold retargeted to the ROBOTIS OP3 and composed with a lift and a put-down, fitted by "
    "movement primitives"};
const ClipSource kDeepMimic = {
    "xbpeng/DeepMimic, data/motions/humanoid3d_jog.txt", "MIT",
    "retargeted to the ROBOTIS OP3, shortened steps, fitted by movement primitives"};

/// What every motion has to do: finish under the threshold, upright, not fallen.
std::vector<Clause> upright(std::vector<Clause> more, bool deep = false) {
  std::vector<Clause> clauses = {
      at_least("completed", 1), at_most("cost", 350), at_most("tilt_deg", 40),
      deep ? at_most("below_reference_m", 0.05) : at_least("base_height_m", 0.17)};
  clauses.insert(clauses.end(), more.begin(), more.end());
  return clauses;
}

/// Of u_up [1/rad^2]. With 1, feet that should rise by 32 mm rise by 5 where servos have half the
/// stiffness, and the middle layer takes thirty trials to add the rest. With 0.1 such a robot falls
/// now and then before its model is learned.
constexpr double kInputWeight = 0.3;

Motion entry(const char* name, const char* title, const ClipSource& source, MotionKind kind,
             const char* clip) {
  Motion motion;
  motion.name = name;
  motion.title = title;
  motion.source = source;
  motion.recipe.kind = kind;
  motion.recipe.clip = clip;
  motion.weights.input.setConstant(kInputWeight);
  return motion;
}

Motion stand() {
  Motion m = entry("stand", "Standing still on both feet", kAccad, MotionKind::in_place,
                   "accad/Male1_A1_Stand.bvh");
  m.recipe.last_frame = 135;  // then he walks away
  m.recipe.kz = 1.0;
  m.success = upright({at_most("base_drift_m", 0.03), at_most("tilt_deg", 5),
                       at_least("both_feet_loaded_share", 0.99)});
  return m;
}

Motion sway() {
  Motion m = entry("sway", "Swaying from side to side on both feet", kAccad, MotionKind::in_place,
                   "accad/Male1_A2_Sway.bvh");
  m.recipe.last_frame = 240;
  m.recipe.kz = 1.0;
  m.success = upright({at_least("lateral_amplitude_share", 0.7),
                       at_least("lateral_correlation", 0.9), at_most("longest_gap_s", 0.05)});
  return m;
}

Motion squat() {
  Motion m = entry("squat", "Squatting down and standing up again", kAccad, MotionKind::in_place,
                   "accad/Male1_A7_Crouch.bvh");
  m.recipe.kz = 0.5;  // full depth bends the knee beyond its limit, and the man's heels rise
  m.recipe.kappa = 0.95;
  m.success = upright({at_least("depth_share", 0.7), at_most("return_height_error_m", 0.015),
                       at_most("foot_slip_m", 0.015)},
                      true);
  return m;
}

Motion one_leg() {
  Motion m =
      entry("one_leg", "Standing on the right leg", kMass, MotionKind::one_leg, "mass/balance.bvh");
  m.recipe.first_frame = 290;
  m.recipe.last_frame = 415;
  m.recipe.zmp_inside_m = 0.006;
  m.success =
      upright({at_least("longest_lift_s", 1.5), at_least("single_support_share", 0.99)}, true);
  return m;
}

/// The foot goes up first, then forward: otherwise the heel drags and in one trial of ten catches.
void rise_first(Recipe& recipe) {
  recipe.swing_sharpness = 2.0;
  recipe.swing_dwell = 0.15;
}

std::vector<Clause> walking() {
  return upright({at_least("steps", 5), at_least("distance_share", 0.6),
                  at_least("lowest_step_clearance_m", 0.005), at_most("cross_drift_m", 0.15),
                  at_most("yaw_deg", 20)});
}

Motion walk_forward() {
  Motion m =
      entry("walk_forward", "Walking forward", kAccad, MotionKind::gait, "accad/Male1_B3_Walk.bvh");
  m.recipe.kx = 0.35;
  m.recipe.kappa = 0.90;  // bent knees lift the foot at a lower knee speed
  m.recipe.swing_height_m = 0.032;
  rise_first(m.recipe);
  m.recipe.swing_stretch = 1.1;  // keeps the joints well within the servos' speed all the same
  m.recipe.basis_per_second = 20.0;
  m.recipe.zmp_inside_m = 0.008;
  m.success = walking();
  return m;
}

Motion walk_backward() {
  Motion m = entry("walk_backward", "Walking backward", kAccad, MotionKind::gait,
                   "accad/Male1_B6_WalkBackwards.bvh");
  m.recipe.kx = 0.35;
  m.recipe.kappa = 0.90;  // bent knees lift the foot at a lower knee speed
  m.recipe.swing_height_m = 0.032;
  rise_first(m.recipe);
  m.recipe.swing_stretch = 1.1;
  m.recipe.basis_per_second = 20.0;
  m.recipe.zmp_inside_m = 0.008;
  m.success = walking();
  return m;
}

Motion sidestep() {
  Motion m = entry("sidestep", "Three steps to the left", kAccad, MotionKind::gait,
                   "accad/Male1_B22_SideStepLeft.bvh");
  m.recipe.first_frame = 30;
  m.recipe.last_frame = 110;
  m.recipe.heading_by_body = true;
  m.recipe.loops = 3;
  m.recipe.kx = 0.40;
  m.recipe.kz = 0.1;
  m.recipe.basis_per_second = 20.0;
  m.recipe.kappa = 0.86;  // low enough to reach sideways with the other leg
  m.recipe.zmp_inside_m = 0.012;
  m.recipe.swing_height_m = 0.036;
  rise_first(m.recipe);
  m.recipe.swing_stretch = 1.1;
  m.success = upright({at_least("steps", 6), at_least("distance_share", 0.6),
                       at_most("cross_drift_m", 0.08), at_most("yaw_deg", 20)});
  return m;
}

Clause waived(Clause clause, const char* because) {
  clause.waived = because;
  return clause;
}

Motion jog() {
  Motion m =
      entry("jog", "Jogging forward", kDeepMimic, MotionKind::gait, "deepmimic/humanoid3d_jog.txt");
  m.recipe.kt = 1.5;
  m.recipe.kappa = 0.86;  // bent knees lift the foot at a lower knee speed
  m.recipe.kx = 0.12;
  m.recipe.kz = 0.25;
  m.recipe.loops = 7;
  m.recipe.max_steps = 11;  // with the closing one as many of the right as of the left foot
  m.recipe.even_rhythm = true;
  m.recipe.cutoff_Hz = 8.0;
  m.recipe.double_support_s = -1.0;  // swings may overlap: flight
  m.recipe.swing_stretch = 1.15;
  m.recipe.swing_height_m = 0.032;
  rise_first(m.recipe);  // a foot that leaves the ground late is double support
  m.recipe.basis_per_second = 30.0;
  m.success = upright({at_least("steps", 10), at_most("double_support_share", 0.05),
                       at_least("distance_share", 0.5),
                       waived(at_most("stance_share", 0.5),
                              "both shares add up to 1 + double support - flight: needs flight"),
                       waived(at_least("flight_share", 0.5),
                              "20 ms of flight take 0.78 to 0.88 of the load line that the data "
                              "sheet gives the servo; see docs/motions.md")});
  return m;
}

using Maker = Motion (*)();
const std::vector<std::pair<const char*, Maker>> kEntries = {{"stand", stand},
                                                             {"sway", sway},
                                                             {"squat", squat},
                                                             {"one_leg", one_leg},
                                                             {"walk_forward", walk_forward},
                                                             {"walk_backward", walk_backward},
                                                             {"sidestep", sidestep},
                                                             {"jog", jog}};

}  // namespace

Motion catalogue_entry(const std::string& name) {
  std::string known;
  for (const auto& [entry_name, make] : kEntries) {
    if (name == entry_name) return make();
    known += (known.empty() ? "" : ", ") + std::string(entry_name);
  }
  throw MotionError("no motion named '" + name + "'; there are: " + known);
}

}  // namespace sanso::motion
