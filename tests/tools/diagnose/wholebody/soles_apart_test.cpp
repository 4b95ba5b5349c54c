// Soles on one floor: what turns one against the other is a joint that reads wrong, and nothing
// else.
#include "tools/diagnose/wholebody/soles_apart.h"

#include <gtest/gtest.h>

#include "tests/tools/diagnose/wholebody/made_stance.h"

namespace sanso::diagnose {
namespace {

using namespace test;

class SolesApartTest : public ::testing::Test {
 protected:
  SolesApartTest() : world_({.recordings = 0}), tree_(world_.body) {
    const auto n = static_cast<Eigen::Index>(world_.body.model.tree.size());
    motion_.q = motion_.dq = motion_.ddq = Eigen::VectorXd::Zero(n);
    for (const CollisionShape& s : world_.body.shapes)
      if (feet_.empty() || feet_.front().joint != s.joint) feet_.push_back({s.link, s.joint, {}});
  }
  SolesApart apart() { return *soles_apart(world_.body, tree_, motion_, feet_[0], feet_[1]); }

  StanceWorld world_;
  FloatingTree tree_;
  FloatingMotion motion_;
  std::vector<FootForce> feet_;
};

TEST_F(SolesApartTest, SolesOfARobotAsStatedLieAlikeInAnyAttitude) {
  ASSERT_GE(feet_.size(), 2u);
  EXPECT_LT(apart().lean.norm(), 1e-9);
  motion_.acc = V3(1.0, 2.0, 9.0), motion_.w = V3(0.1, 0.2, 0.3);
  EXPECT_LT(apart().lean.norm(), 1e-9);
}

TEST_F(SolesApartTest, AJointThatReadsWrongTurnsItsSoleAsItsColumnSays) {
  const SolesApart level = apart();
  bool any = false;
  for (Eigen::Index j = 0; j < motion_.q.size(); ++j) {
    constexpr double kOff = 0.01;  // rad
    motion_.q[j] = kOff;
    const V2 lean = apart().lean, said = kOff * level.by_zero.col(j);
    motion_.q[j] = 0.0;
    EXPECT_LT((lean - said).norm(), 0.02 * kOff) << j;
    any = any || lean.norm() > 0.9 * kOff;
  }
  EXPECT_TRUE(any);
}

TEST_F(SolesApartTest, LeavesTheTreeAsItWas) {
  motion_.q.setConstant(0.1);
  apart();
  const M3 R = tree_.rotation(feet_[0].joint);
  tree_.set(motion_);
  EXPECT_EQ(R, tree_.rotation(feet_[0].joint));
}

}  // namespace
}  // namespace sanso::diagnose
