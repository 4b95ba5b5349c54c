// The torque at rest of the two actuators that follow a goal, and that of no other is claimed.
#include "tools/diagnose/wholebody/drive_law.h"

#include <gtest/gtest.h>

#include "tests/tools/diagnose/wholebody/made_stance.h"

namespace sanso::diagnose {
namespace {

TEST(DriveLaw, OfAServoIsWhatItsRegistersMakeOfARadian) {
  JointSettings s;
  s.actuator = Actuator::dc_servo;
  s.p_gain = 5.0, s.d_gain = 0.1, s.torque_constant = 2.0, s.back_emf = 2.0;
  s.voltage = 12.0, s.resistance = 4.0, s.viscous = 0.3;
  const DriveLaw law = law_of(s);
  EXPECT_DOUBLE_EQ(law.stiffness, 5.0 * 2.0 * 12.0 / 4.0);
  EXPECT_DOUBLE_EQ(law.damping, 0.1 * 2.0 * 12.0 / 4.0 + 2.0 * 2.0 / 4.0 + 0.3);
}

TEST(DriveLaw, IsUnknownWhereAnIntegralActs) {
  WholeBody body = test::StanceWorld({.recordings = 0}).body;
  EXPECT_EQ(drive_unknown(body), "");
  body.model.joints[3].actuator = Actuator::dc_servo;
  body.model.joints[3].i_gain = 1.0;
  EXPECT_NE(drive_unknown(body).find(body.model.tree.joints[3].name), std::string::npos);
}

}  // namespace
}  // namespace sanso::diagnose
