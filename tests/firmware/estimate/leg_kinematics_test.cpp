// The estimator's own leg kinematics against the general kinematics of the model, and its velocity
// against differences.
#include "firmware/estimate/leg_kinematics.h"

#include <gtest/gtest.h>

#include <random>

#include "shared/model/op3_kinematics.h"

namespace sanso::firmware {
namespace {

TEST(LegKinematics, AgreesWithTheModel) {
  const unsigned seed = 4;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> angle(-1.0, 1.0);
  for (int n = 0; n < 200; ++n) {
    model::State x = model::neutral_state();
    for (int j = 0; j < model::kNumJoints; ++j) {
      x[model::kXJoint + j] = angle(random);
      x[model::kXJointRate + j] = angle(random);
    }
    model::Kinematics kin;
    model::forward_kinematics(x, kin);
    for (const Leg leg : {kRightLeg, kLeftLeg}) {
      const auto sole =
          sole_kinematics(leg, &x[model::kXJoint + 6 * leg], &x[model::kXJointRate + 6 * leg]);
      const int body = model::foot_body(leg);
      const math::Vec3 expected = model::point_in_world(kin, body, model::sole_centre_in_foot(leg));
      EXPECT_LT((sole.p_base_sole - expected).norm(), 1e-12);
      EXPECT_LT((sole.R_base_sole - kin.R_world_link[body]).norm(), 1e-12);
      const math::Vec3 v =
          model::point_jacobian(kin, body, expected) * x.segment<model::kNv>(model::kXVel);
      EXPECT_LT((sole.v_sole_in_base - v).norm(), 1e-12);
      double lowest = 1e9;
      for (int c = 0; c < 4; ++c)
        lowest = std::min(lowest,
                          model::point_in_world(kin, body, model::sole_corner_in_foot(leg, c))[2]);
      EXPECT_NEAR(lowest_corner(sole, math::Vec3::UnitZ()), lowest, 1e-12);
    }
  }
}

}  // namespace
}  // namespace sanso::firmware
