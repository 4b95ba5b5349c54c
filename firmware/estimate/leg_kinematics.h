// Where a sole is and how it moves, seen from the base. Only what the estimator needs of the robot
// model; geometry from shared/model/op3_table.h. tests/firmware compares it with the general
// kinematics.
#pragma once

#include "shared/math/so3.h"
#include "shared/model/foot_shape.h"
#include "shared/model/state_layout.h"

namespace sanso::firmware {

enum Leg : int { kRightLeg = 0, kLeftLeg = 1 };
inline constexpr int kJointsPerLeg = 6;

struct SoleKinematics {
  math::Vec3 p_base_sole = math::Vec3::Zero();  // sole centre, base axes  m
  math::Mat3 R_base_sole = math::Mat3::Identity();
  // velocity relative to the base by joint rates, base axes  m/s
  math::Vec3 v_sole_in_base = math::Vec3::Zero();
  // its angular velocity relative to the base by joint rates, base axes  rad/s
  math::Vec3 w_sole_in_base = math::Vec3::Zero();
};

/// q, dq: the six angles and rates of the leg, hip_yaw .. ank_roll. `foot`: what touches the
/// ground.
SoleKinematics sole_kinematics(Leg leg, const double* q, const double* dq,
                               const model::FootShape& foot = model::kSoles);

/// Height of the lowest of the foot's four points relative to the base origin [m] (negative), along
/// `up`: world z or the normal of the ground, base axes.
double lowest_corner(const SoleKinematics& sole, const math::Vec3& up_in_base,
                     const model::FootShape& foot = model::kSoles);

}  // namespace sanso::firmware
