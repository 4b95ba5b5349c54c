// How a clip becomes a motion of the robot: the figures of the retargeting, one set per motion,
// kept in its file.
#pragma once

#include <string>

namespace sanso::motion {

enum class MotionKind {
  in_place,  // both feet stay: scaled hips move the centre of mass
  one_leg,   // composed: shift, lift, hold on the clip's segment, down, back
  gait,      // footsteps of the clip, base from the linear inverted pendulum
};

struct Recipe {
  MotionKind kind = MotionKind::in_place;
  std::string clip;              // file of the human motion, relative to the mocap folder
  int first_frame = 0;           // cut, inclusive
  int last_frame = -1;           // -1: to the end
  bool mirror = false;           // left and right swapped
  bool heading_by_body = false;  // gait: +x where the man faces (sidestep), else along his travel
  double cutoff_Hz = 6.0;        // low-pass of the clip
  // looped clips: cycles to string together; gait: repeats of the step sequence
  int loops = 1;
  double kt = 2.0;                // time, relative to dynamic similarity
  double kx = 1.0;                // stride, relative to leg length
  double kz = 0.3;                // height of the hips, relative to leg length
  double kappa = 0.93;            // leg length when standing, of the straight leg
  double swing_height_m = 0.028;  // gait: highest point of the swing foot
  // gait: the swing foot's height goes as (4 u (1 - u))^sharpness; smaller rises sooner
  double swing_sharpness = 3.0;
  // gait: share of a swing, at either end, in which the foot only rises or sinks
  double swing_dwell = 0.0;
  // gait: at least this long between a landing and the next lift; negative: may overlap
  double double_support_s = 0.15;
  double swing_stretch = 1.0;  // gait: length of a swing relative to the scaled clip
  // gait: every swing and every step lasts as long as the clip's mean (a man limps a little)
  bool even_rhythm = false;
  double lift_scale = 0.5;  // one_leg: of the scaled ankle-to-ankle vector
  double hold_s = 2.5;      // one_leg
  int max_steps = 100;      // gait, without the closing one
  // gait, one_leg: support point moved from the sole's centre line towards the other foot
  double zmp_inside_m = 0.0;
  double stand_s = 1.0;            // standing before and after
  double basis_per_second = 12.0;  // of the primitives
};

MotionKind motion_kind(const std::string& name);  // throws std::invalid_argument naming the three
const char* to_string(MotionKind kind);

/// Calls `field(key, value)` for every figure except kind: one list for reading and writing.
template <class R, class Field>
void visit_recipe(R& r, Field&& field) {
  field("clip", r.clip);
  field("first_frame", r.first_frame);
  field("last_frame", r.last_frame);
  field("mirror", r.mirror);
  field("heading_by_body", r.heading_by_body);
  field("cutoff_Hz", r.cutoff_Hz);
  field("loops", r.loops);
  field("kt", r.kt);
  field("kx", r.kx);
  field("kz", r.kz);
  field("kappa", r.kappa);
  field("swing_height_m", r.swing_height_m);
  field("swing_sharpness", r.swing_sharpness);
  field("swing_dwell", r.swing_dwell);
  field("double_support_s", r.double_support_s);
  field("swing_stretch", r.swing_stretch);
  field("even_rhythm", r.even_rhythm);
  field("lift_scale", r.lift_scale);
  field("hold_s", r.hold_s);
  field("max_steps", r.max_steps);
  field("zmp_inside_m", r.zmp_inside_m);
  field("stand_s", r.stand_s);
  field("basis_per_second", r.basis_per_second);
}

}  // namespace sanso::motion
