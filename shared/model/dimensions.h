// Sizes and offsets of state, tangent and input as plain constants: no Eigen, so that kernels and
// drivers may include them.
// The meaning of every entry is written in state_layout.h.
#pragma once

namespace sanso::model {

inline constexpr int kNumJoints = 12;
inline constexpr int kNq = 7 + kNumJoints;  // configuration
inline constexpr int kNv = 6 + kNumJoints;  // velocity
inline constexpr int kNx = kNq + kNv;       // state, 37
inline constexpr int kNdx = 2 * kNv;        // tangent, 36
inline constexpr int kNu = kNumJoints;      // input

// Offsets in the state.
inline constexpr int kXPos = 0, kXQuat = 3, kXJoint = 7, kXVel = 19, kXOmega = 22, kXJointRate = 25;
// Offsets in the tangent.
inline constexpr int kDPos = 0, kDTheta = 3, kDJoint = 6, kDVel = 18, kDOmega = 21,
                     kDJointRate = 24;

// Contact: four sole corners on each of two feet (0 right, 1 left), three force components each.
inline constexpr int kNumFeet = 2;
inline constexpr int kCornersPerFoot = 4;
inline constexpr int kNumContacts = kNumFeet * kCornersPerFoot;
inline constexpr int kNumContactRows = 3 * kNumContacts;

}  // namespace sanso::model
