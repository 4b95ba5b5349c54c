// The controlled OP3: upper body lumped into the base (arms in walkready), twelve leg links.
// Written by tools/model/generate_op3.py from shared/model/data/op3-*.csv (ROBOTIS figures, see
// data/README.md).
// Do not edit: change the figures and run the generator.
#pragma once

namespace sanso::model {

/// Mass properties of one body in the axes of its link frame.
struct BodyInertia {
  double mass;        // kg
  double com[3];      // m, from the link origin
  double inertia[6];  // kg m^2 about the centre of mass: xx xy xz yy yz zz
};

/// Where a joint sits on its parent. No OP3 joint has a fixed rotation, and all axes are coordinate
/// axes.
struct JointGeometry {
  double origin[3];  // m, joint origin (= child link origin) in parent axes
  int axis;          // 0 x, 1 y, 2 z
  int sign;          // +1 or -1: the joint turns about sign * axis
};

// 0 base, 1..6 right leg, 7..12 left leg: body j + 1 is moved by joint j
inline constexpr int kNumBodies = 13;

inline constexpr BodyInertia kOp3Bodies[kNumBodies] = {
    {1.95857,
     {-0.008490497606, 0.000137973874, 0.072074688733},
     {0.01437487512, 2.726116e-06, -0.000236121865, 0.006718135667, -8.088152e-06,
      0.010940864237}},  // body_link
    {0.01181,
     {-0.00157, 0.0, -0.00774},
     {1.51e-06, 0.0, 1e-08, 4.3e-06, 0.0, 4.12e-06}},  // r_hip_yaw_link
    {0.17886,
     {0.00388, -0.00028, -0.01214},
     {4.661e-05, 1.01e-06, -1.31e-06, 0.00012523, 6e-08, 0.00010857}},  // r_hip_roll_link
    {0.11543,
     {0.00059, 0.01901, -0.08408},
     {0.00010499, 1e-08, -7.1e-07, 9.613e-05, -3.53e-06, 2.493e-05}},  // r_hip_pitch_link
    {0.04015,
     {0.0, 0.02151, -0.055},
     {3.715e-05, 0.0, 0.0, 2.751e-05, 0.0, 1.511e-05}},  // r_knee_link
    {0.17886,
     {-0.02022, 0.01872, 0.01214},
     {4.661e-05, 1.01e-06, 1.31e-06, 0.00012523, -6e-08, 0.00010857}},  // r_ank_pitch_link
    {0.06934,
     {0.02373, -0.01037, -0.0276},
     {4.034e-05, 1.9e-07, 1.2e-07, 7.874e-05, -1.01e-06, 0.00011579}},  // r_ank_roll_link
    {0.01181,
     {-0.00157, 0.0, -0.00774},
     {1.51e-06, 0.0, 1e-08, 4.3e-06, 0.0, 4.12e-06}},  // l_hip_yaw_link
    {0.17886,
     {0.00388, 0.00028, -0.01214},
     {4.661e-05, -1.01e-06, -1.31e-06, 0.00012523, -6e-08, 0.00010857}},  // l_hip_roll_link
    {0.11543,
     {0.00059, -0.01901, -0.08408},
     {0.00010499, -1e-08, -7.1e-07, 9.613e-05, 3.53e-06, 2.493e-05}},  // l_hip_pitch_link
    {0.04015,
     {0.0, -0.02151, -0.055},
     {3.715e-05, 0.0, 0.0, 2.751e-05, 0.0, 1.511e-05}},  // l_knee_link
    {0.17886,
     {-0.02022, -0.01872, 0.01214},
     {4.661e-05, -1.01e-06, 1.31e-06, 0.00012523, 6e-08, 0.00010857}},  // l_ank_pitch_link
    {0.06934,
     {0.02373, 0.01037, -0.0276},
     {4.034e-05, -1.9e-07, 1.2e-07, 7.874e-05, 1.01e-06, 0.00011579}},  // l_ank_roll_link
};

inline constexpr JointGeometry kOp3Joints[kNumBodies - 1] = {
    {{0.0, -0.035, 0.0}, 2, -1},      // r_hip_yaw
    {{-0.024, 0.0, -0.0285}, 0, -1},  // r_hip_roll
    {{0.0241, -0.019, 0.0}, 1, -1},   // r_hip_pitch
    {{0.0, 0.0, -0.11015}, 1, -1},    // r_knee
    {{0.0, 0.0, -0.11}, 1, +1},       // r_ank_pitch
    {{-0.0241, 0.019, 0.0}, 0, +1},   // r_ank_roll
    {{0.0, 0.035, 0.0}, 2, -1},       // l_hip_yaw
    {{-0.024, 0.0, -0.0285}, 0, -1},  // l_hip_roll
    {{0.0241, 0.019, 0.0}, 1, +1},    // l_hip_pitch
    {{0.0, 0.0, -0.11015}, 1, +1},    // l_knee
    {{0.0, 0.0, -0.11}, 1, -1},       // l_ank_pitch
    {{-0.0241, -0.019, 0.0}, 0, +1},  // l_ank_roll
};

/// Sole corners in ankle-roll axes [m], the four-point approximation inside the sole's octagon
/// (left foot; right: -y).
inline constexpr double kSoleFront = 0.0815, kSoleBack = -0.0335;
inline constexpr double kSoleOuter = 0.0515, kSoleInner = -0.0265;
inline constexpr double kSoleHeight = -0.0305;

}  // namespace sanso::model
