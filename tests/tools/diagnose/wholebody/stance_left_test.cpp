// What a stance leaves says who did it: a push comes and goes, a torque of unknown cause stays at
// its joint, and a foot that comes down is neither.
#include "tools/diagnose/wholebody/stance_left.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/tools/diagnose/wholebody/made_stance.h"
#include "tools/diagnose/wholebody/drive_choice.h"

namespace sanso::diagnose {
namespace {

using namespace test;

constexpr double kFrom_s = 2.0, kTo_s = 2.4;
const V3 kPush(56.0, -24.0, 0.0);  // N, base axes

Stance pushed() {
  Stance out;
  out.recordings = 2, out.current = true;
  out.push = [](int recording, double t) {
    return recording == 1 && t >= kFrom_s && t < kTo_s ? kPush : V3(V3::Zero());
  };
  return out;
}

struct Left {
  DriveRows rows;
  StanceLeft stance;
};

Left left_of(const Stance& stance) {
  const StanceWorld world(stance);
  const Asking asking = world.asking();
  DriveBalance found = balance_drives(asking);
  EXPECT_TRUE(found.rows.why_not.empty()) << found.rows.why_not;
  const StanceLeft left = stance_left(found.rows, found.choice.figures, asking.stance.pushed);
  return {std::move(found.rows), left};
}

/// Rows of a robot as stated, and figures that change nothing.
struct Plain {
  DriveRows rows;
  Eigen::VectorXd figures;
};

Plain plain() {
  Stance stance;
  stance.recordings = 1, stance.current = true;
  const StanceWorld world(stance);
  DriveRows rows = drive_rows(world.asking());
  Eigen::VectorXd figures = Eigen::VectorXd::Zero(rows.columns.count());
  return {std::move(rows), std::move(figures)};
}

TEST(StanceLeft, APushIsFoundWhereAndWhenItWas) {
  const StanceLeft left = left_of(pushed()).stance;
  ASSERT_FALSE(left.pushes.empty());
  const Push& p = left.pushes.front();
  EXPECT_EQ(p.recording, 1u);
  EXPECT_NEAR(p.from, kFrom_s, 0.11);
  EXPECT_NEAR(p.to, kTo_s, 0.11);
  for (const Push& other : left.pushes) EXPECT_EQ(other.recording, 1u);
}

TEST(StanceLeft, NobodyPushesARobotAsStated) {
  for (const bool current : {true, false}) {
    Stance stance;
    stance.recordings = 2, stance.current = current;
    EXPECT_TRUE(left_of(stance).stance.pushes.empty()) << current;
  }
}

TEST(StanceLeft, WithoutAPushNoneIsLeft) {
  const Left with = left_of(pushed());
  ASSERT_FALSE(with.stance.pushes.empty());
  const DriveRows rest = without(with.rows, with.stance.pushes);
  EXPECT_LT(rest.y.size(), with.rows.y.size());
  EXPECT_GT(rest.y.size(), with.rows.y.size() / 2);
  const auto count = static_cast<std::size_t>(rest.y.size());
  EXPECT_EQ(rest.X.rows(), rest.y.size());
  EXPECT_EQ(rest.unknown.rows(), rest.y.size());
  for (const std::size_t size :
       {rest.channel.size(), rest.recording.size(), rest.piece.size(), rest.window.size()})
    EXPECT_EQ(size, count);
  for (const std::size_t w : rest.window) {
    const StanceWindow& window = rest.windows[w];
    EXPECT_FALSE(window.recording == 1 && window.to > kFrom_s && window.from < kTo_s)
        << window.from;
  }
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(rest.columns.count());
  EXPECT_TRUE(stance_left(rest, none, 5.0).pushes.empty());
}

TEST(StanceLeft, ATorqueOfUnknownCauseShowsAtItsJoint) {
  const Plain as_stated = plain();
  const auto joints = static_cast<std::size_t>(as_stated.rows.columns.joints);
  for (std::size_t joint = 0; joint < joints; ++joint) {
    DriveRows rows = as_stated.rows;
    rows.y += 3.0 * rows.unknown.col(3 + static_cast<Eigen::Index>(joint));
    const std::vector<double> at = stance_left(rows, as_stated.figures, 5.0).at;
    ASSERT_EQ(at.size(), joints + 1);
    const auto most = std::max_element(at.begin() + 1, at.end()) - at.begin();
    EXPECT_EQ(most, static_cast<std::ptrdiff_t>(joint) + 1);
  }
}

/// A force on the base in one window of a robot as stated.
std::vector<Push> with_force(const V3& force) {
  Plain made = plain();
  const std::size_t window = made.rows.windows.size() / 2;
  for (std::size_t i = 0; i < made.rows.window.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    if (made.rows.window[i] == window)
      made.rows.y[k] += made.rows.unknown.row(k).head<3>().dot(force);
  }
  return stance_left(made.rows, made.figures, 5.0).pushes;
}

TEST(StanceLeft, AFootThatComesDownIsNoPush) {
  EXPECT_EQ(with_force(V3(60.0, 0.0, 0.0)).size(), 1u);
  EXPECT_TRUE(with_force(V3(0.0, 0.0, 60.0)).empty());
}

TEST(StanceLeft, NeighbouringWindowsAreOnePush) {
  const std::vector<Push> pushes = left_of(pushed()).stance.pushes;
  for (std::size_t a = 0; a < pushes.size(); ++a)
    for (std::size_t b = 0; b < a; ++b)
      EXPECT_TRUE(pushes[a].to < pushes[b].from || pushes[b].to < pushes[a].from);
  EXPECT_TRUE(std::is_sorted(pushes.begin(), pushes.end(), [](const Push& a, const Push& b) {
    return a.beyond > b.beyond;
  })) << "strongest first";
}

}  // namespace
}  // namespace sanso::diagnose
