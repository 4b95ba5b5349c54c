// Orientation from gyro and accelerometer against motions whose truth is known in closed form.
#include "firmware/imu/orientation_filter.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sanso::firmware {
namespace {

constexpr double kDt = 0.01;
const math::Vec3 kUp(0, 0, 9.81);

double tilt_error(const OrientationFilter& filter, const math::Quat& truth) {
  const math::Vec3 a = math::rotation_matrix(filter.quat_world_body()).row(2);
  const math::Vec3 b = math::rotation_matrix(truth).row(2);
  return std::acos(std::clamp(a.dot(b), -1.0, 1.0));
}

TEST(OrientationFilter, TheFirstSampleGivesTheTilt) {
  for (const math::Vec3& turn : {math::Vec3(0.4, 0, 0), math::Vec3(0, -0.7, 0),
                                 math::Vec3(-0.3, 0.5, 0), math::Vec3(2.0, 0.3, 0)}) {
    const math::Quat truth = math::quat_exp(turn);
    OrientationFilter filter;
    filter.update({0, 0, 0}, math::rotation_matrix(truth).transpose() * kUp, kDt);
    EXPECT_LT(tilt_error(filter, truth), 1e-6);
  }
}

TEST(OrientationFilter, LearnsTheBiasAtRestAndKeepsItInMotion) {
  const math::Vec3 bias(0.03, -0.02, 0.05);
  OrientationFilter filter;
  for (int i = 0; i < 300; ++i) filter.update(bias, kUp, kDt);
  ASSERT_TRUE(filter.bias_known());
  EXPECT_LT((filter.bias() - bias).norm(), 2e-3);
  // 10 s of rocking about y: the tilt follows, the bias stays
  math::Quat truth = math::quat_identity();
  double worst = 0;
  for (int i = 0; i < 1000; ++i) {
    const math::Vec3 rate(0, 1.5 * std::cos(6.0 * i * kDt), 0);
    truth = math::quat_multiply(truth, math::quat_exp(math::Vec3(rate * kDt)));
    filter.update(rate + bias, math::rotation_matrix(truth).transpose() * kUp, kDt);
    worst = std::max(worst, tilt_error(filter, truth));
  }
  EXPECT_LT((filter.bias() - bias).norm(), 5e-3);
  EXPECT_LT(worst, 0.01);
}

TEST(OrientationFilter, ATurnAtConstantRateIsNoBias) {
  OrientationFilter filter;
  for (int i = 0; i < 500; ++i) filter.update({0, 0, 1.0}, kUp, kDt);
  EXPECT_EQ(filter.bias().norm(), 0.0);
  EXPECT_NEAR(std::remainder(math::yaw_of(filter.quat_world_body()) - 4.99, 2 * M_PI), 0, 1e-6);
}

TEST(OrientationFilter, AKickDoesNotTurnTheWorld) {
  OrientationFilter filter;
  for (int i = 0; i < 100; ++i) filter.update({0, 0, 0}, kUp, kDt);
  for (int i = 0; i < 20; ++i) filter.update({0, 0, 0}, kUp + math::Vec3(8, 0, 0), kDt);
  EXPECT_LT(tilt_error(filter, math::quat_identity()), 0.01);
}

}  // namespace
}  // namespace sanso::firmware
