// The ground's profiles, and that lanes see the same surface as the plain functions.
#include "shared/model/ground.h"

#include <gtest/gtest.h>

#include <cmath>

#include "shared/model/kernel/ground_lanes.h"
#include "shared/model/op3_kinematics.h"
#include "shared/model/op3_step.h"
#include "shared/model/state_layout.h"

namespace sanso::model {
namespace {

Ground ramp_with_lip() {
  const GroundCorner corners[] = {{-1.0, 0.0, 0.0},  {0.2, 0.0, 0.8},   {0.7, -0.1, 1.0},
                                  {1.2, -0.05, 0.0}, {1.2, -0.09, 0.0}, {2.0, -0.09, 0.0}};
  Ground g;
  const GroundDefect defect = make_profile(corners, 6, g);
  EXPECT_EQ(defect.what, nullptr) << defect.what;
  return g;
}

TEST(Ground, ArcsTouchTheirLines) {
  const Ground g = ramp_with_lip();
  for (int i = 1; i < g.num_segments; ++i) {
    const double at = g.segment[i].x_start;
    const double step = ground_height(g, at) - ground_height(g, at - 1e-9);
    if (at == 1.2) {
      EXPECT_NEAR(step, -0.04, 1e-8) << "the lip";
      continue;
    }
    EXPECT_NEAR(step, 0.0, 1e-8) << "segment " << i;
    EXPECT_NEAR(ground_slope(g, at), ground_slope(g, at - 1e-9), 1e-7) << "segment " << i;
  }
}

TEST(Ground, SlopeIsDerivativeOfHeightAndLanesAgree) {
  for (const Ground& g : {make_plane(0.2), ramp_with_lip()})
    for (double x = -0.5; x < 3.0; x += 0.0137) {
      const portable::GroundPoint<double> p = portable::ground_at(g, x);
      EXPECT_NEAR(p.z, ground_height(g, x), 1e-12);
      EXPECT_NEAR(p.sin_slope / p.cos_slope, ground_slope(g, x), 1e-12);
      const double rise = ground_height(g, x + 1e-7) - ground_height(g, x - 1e-7);
      if (std::abs(rise) < 1e-3) {
        EXPECT_NEAR(rise / 2e-7, p.sin_slope / p.cos_slope, 1e-5) << "x " << x;
      }
    }
}

// On a plane tilted by `angle`, standing robot turned with the plane: speed along the slope after
// one second.
double slide_speed(double angle, double friction_forward) {
  ModelParameters theta = nominal_parameters();
  theta.friction_forward = friction_forward;
  const StepModel model = make_step_model(theta);
  Ground slope = make_plane();
  slope.segment[0].sin_slope = -std::sin(angle);
  State x = standing_state();
  const math::Quat turn = math::quat_exp(math::Vec3(0, angle, 0));
  x.segment<3>(kXPos) = math::rotation_matrix(turn) * x.segment<3>(kXPos);
  x.segment<4>(kXQuat) = turn;
  const Input u = joints(x);
  StepScratch scratch;
  scratch.warm_start = true;
  for (int k = 0; k < 10; ++k)
    analytical_step(model, slope, x.data(), u.data(), 0.06, 1, x.data(), scratch);
  return x.segment<3>(kXVel).dot(math::Vec3(std::cos(angle), 0, -std::sin(angle)));
}

TEST(Ground, SolesHoldOnASlopeAndWheelsRoll) {
  const double angle = 0.06;
  EXPECT_LT(std::abs(slide_speed(angle, 0.8)), 0.02);
  // free rolling: v = g (sin a - c cos a) t; legs sway a little
  const double expected = 9.81 * (std::sin(angle) - 0.02 * std::cos(angle)) * 0.6;
  EXPECT_NEAR(slide_speed(angle, 0.02), expected, 0.2 * expected);
}

}  // namespace
}  // namespace sanso::model
