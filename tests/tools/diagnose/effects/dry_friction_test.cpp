// Over which angle dry friction builds up, against what a spring holds back on its way.
#include "tools/diagnose/effects/dry_friction.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace sanso::diagnose {
namespace {

// A spring of stiffness k that slides at F holds back  integral (1 - f / F) dz = F / (2 k)  on its
// way: the bend is twice that, whatever elements the friction is made of.
TEST(BendOfDryFriction, IsTwiceWhatTheForceHoldsBackOnItsWay) {
  for (const double spread : {0.0, 1.0, 2.5}) {
    JointParams joint;
    joint.slip_torque = 0.2, joint.slip_stiffness = 40.0, joint.slip_spread = spread;
    double total = 0.0;
    for (int i = 1; i <= 4; ++i) total += std::pow(i, spread);
    double held_back = 0.0;
    const double dz = 1e-6;
    for (double z = 0.5 * dz; z < 0.1; z += dz) {
      double force = 0.0;
      for (int i = 1; i <= 4; ++i)
        force +=
            std::min(joint.slip_stiffness / 4 * z, joint.slip_torque * std::pow(i, spread) / total);
      held_back += (1.0 - force / joint.slip_torque) * dz;
    }
    EXPECT_NEAR(bend_of_dry_friction(joint), 2.0 * held_back, 1e-5) << spread;
  }
}

TEST(BendOfDryFriction, IsTheMeanOverAllThatRubs) {
  JointParams joint;
  EXPECT_EQ(bend_of_dry_friction(joint), 0.0) << "nothing rubs";
  joint.nominal.coulomb = 0.2, joint.coulomb = 0.1;
  EXPECT_EQ(bend_of_dry_friction(joint), 0.0) << "all slips at once";
  joint.presliding_compliance = 0.01;
  EXPECT_DOUBLE_EQ(bend_of_dry_friction(joint), 0.3 * 0.01) << "stated friction bends too";
  joint.slip_torque = 0.1, joint.slip_stiffness = 20.0, joint.slip_spread = 0.0;
  EXPECT_DOUBLE_EQ(bend_of_dry_friction(joint), 0.75 * 0.003 + 0.25 * 0.005);
}

}  // namespace
}  // namespace sanso::diagnose
