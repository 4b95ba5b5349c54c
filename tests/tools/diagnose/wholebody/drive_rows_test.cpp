// What the balances of a stance say is true of the robot that made them, whatever the ground did.
#include "tools/diagnose/wholebody/drive_rows.h"

#include <gtest/gtest.h>

#include "tests/tools/diagnose/wholebody/made_body.h"
#include "tests/tools/diagnose/wholebody/made_stance.h"

namespace sanso::diagnose {
namespace {

using namespace test;

double rms(const Eigen::VectorXd& x) {
  return std::sqrt(x.squaredNorm() / static_cast<double>(std::max<Eigen::Index>(1, x.size())));
}

/// What the true figure of every joint leaves of the rows, over what the model leaves.
double left_with(const Stance& stance, JointFigure what, double value) {
  const StanceWorld world(stance);
  const DriveRows rows = drive_rows(world.asking());
  EXPECT_TRUE(rows.why_not.empty()) << rows.why_not;
  Eigen::VectorXd figures = Eigen::VectorXd::Zero(rows.columns.count());
  for (int j = 0; j < rows.columns.joints; ++j) figures[rows.columns.joint(what, j)] = value;
  return rms(rows.y - rows.X * figures) / rms(rows.y);
}

Stance all_joints(const TrueDrive& drive, bool current = false) {
  Stance out;
  out.recordings = 1, out.current = current;
  out.drive = [drive](int) { return drive; };
  return out;
}

TEST(DriveColumns, AreAllDifferent) {
  DriveColumns c;
  c.joints = 7;
  std::vector<int> places;
  for (int what = 0; what < kJointFigures; ++what)
    for (int j = 0; j < c.joints; ++j) places.push_back(c.joint(static_cast<JointFigure>(what), j));
  for (int link = -1; link < c.joints; ++link)
    for (int i = 0; i < 4; ++i) places.push_back(c.mass(link) + i);
  places.push_back(c.back_emf());
  for (int i = 0; i < 3; ++i) places.push_back(c.acc_bias() + i);
  places.push_back(c.force_scale());
  std::sort(places.begin(), places.end());
  ASSERT_EQ(places.size(), static_cast<std::size_t>(c.count()));
  for (int k = 0; k < c.count(); ++k) EXPECT_EQ(places[static_cast<std::size_t>(k)], k);
}

TEST(DriveRows, OfARobotAsStatedAreWithinWhatIsKnown) {
  const StanceWorld world(all_joints({}));
  const DriveRows rows = drive_rows(world.asking());
  ASSERT_TRUE(rows.why_not.empty()) << rows.why_not;
  EXPECT_FALSE(rows.current);
  EXPECT_EQ(rows.channels, 1);
  EXPECT_EQ(rows.sole_links.size(), 2u);
  EXPECT_LT(rms(rows.y), 1.0);
  // 18 equations, 12 forces of the ground
  EXPECT_EQ(rows.y.size() % 6, 0);
  EXPECT_GT(rows.y.size(), 6 * 70);
  EXPECT_EQ(rows.channel.size(), static_cast<std::size_t>(rows.y.size()));
}

TEST(DriveRows, AreExplainedByTheTrueFigure) {
  // the gain's inverse, held against what the motion needs
  EXPECT_LT(left_with(all_joints({.gain = 0.75}), JointFigure::gain, 1.0 - 1.0 / 0.75), 0.35);
  EXPECT_LT(left_with(all_joints({.coulomb = 0.3}), JointFigure::dry, 0.3), 0.35);
  EXPECT_LT(left_with(all_joints({.viscous = 0.6}), JointFigure::speed, 0.6), 0.35);
  // and by no other
  EXPECT_GT(left_with(all_joints({.gain = 0.75}), JointFigure::gain, 0.25), 1.2);
  EXPECT_GT(left_with(all_joints({.coulomb = 0.3}), JointFigure::dry, -0.3), 1.2);
}

TEST(DriveRows, KeepRecordingsAndPiecesApart) {
  Stance stance = all_joints({});
  stance.recordings = 2;
  StanceWorld world(stance);
  // a gap in the second
  for (std::size_t k = 400; k < world.recordings[1].rows(); ++k) world.recordings[1].piece[k] = 1;
  const DriveRows rows = drive_rows(world.asking());
  EXPECT_EQ(*std::max_element(rows.recording.begin(), rows.recording.end()), 1);
  EXPECT_TRUE(std::is_sorted(rows.recording.begin(), rows.recording.end()));
  const int pieces = *std::max_element(rows.piece.begin(), rows.piece.end()) + 1;
  EXPECT_EQ(pieces, static_cast<int>(stance.seconds / world.asking().settings.block));
}

TEST(DriveRows, SayWhyNothingCanBeAsked) {
  StanceWorld world(all_joints({}));
  world.recordings[0].commands = false;
  EXPECT_NE(drive_rows(world.asking()).why_not.find("goal"), std::string::npos);
  world.recordings[0].commands = true, world.recordings[0].acc = false;
  EXPECT_NE(drive_rows(world.asking()).why_not.find("imu_acc"), std::string::npos);
  world.recordings[0].acc = true;
  world.body.model.joints[4].actuator = Actuator::torque;
  const std::string why = drive_rows(world.asking()).why_not;
  EXPECT_NE(why.find(world.body.model.tree.joints[4].name), std::string::npos) << why;
}

TEST(DriveRows, ATrunkOnTwoSlidesHasMoreForcesThanEquations) {
  StanceWorld world(all_joints({}));
  world.body = body_of(R"([joint_default]
actuator = "position_pd"
kp = 100
)",
                       kTwoLegs);
  for (WholeRecording& r : world.recordings) {
    const auto rows = r.q.cols();
    r.q.conservativeResize(2, rows), r.u.conservativeResize(2, rows);
    r.i.conservativeResize(2, rows);
  }
  EXPECT_NE(drive_rows(world.asking()).why_not.find("more links"), std::string::npos);
}

/// A robot whose left foot hits the floor in these rows.
StanceWorld hit_in(std::size_t first, std::size_t last) {
  StanceWorld world(all_joints({}));
  WholeRecording& r = world.recordings.front();
  r.attitude = true;
  const double weight = world.body.mass() * 9.81;
  r.feet = {{"left", 5, std::vector<double>(r.rows(), 0.5 * weight)},
            {"right", 11, std::vector<double>(r.rows(), 0.5 * weight)}};
  for (std::size_t k = first; k < last; ++k) r.feet[0].fz[k] += (k % 2 == 0 ? 1.0 : 0.0) * weight;
  return world;
}

TEST(DriveRows, LeaveOutWindowsWithAnImpactAndThoseBesideThem) {
  const StanceWorld calm = hit_in(0, 0), hit = hit_in(400, 405);
  const DriveRows all = drive_rows(calm.asking()), some = drive_rows(hit.asking());
  EXPECT_LT(some.windows.size(), all.windows.size());
  EXPECT_GE(some.windows.size() + 5, all.windows.size());
  for (const StanceWindow& w : some.windows) EXPECT_FALSE(w.to > 3.9 && w.from < 4.15) << w.from;
}

TEST(DriveRows, SayWhyNotWhereFeetNeverRest) {
  const StanceWorld world = hit_in(0, 800);
  EXPECT_NE(drive_rows(world.asking()).why_not.find("comes down"), std::string::npos);
}

TEST(DriveRows, AboutADelayThatIsGuessedTheyAreExact) {
  const TrueDrive late{.lag = 0.06};
  const StanceWorld world(all_joints(late));
  const auto left = [&](const DriveGuess& guess) {
    const DriveRows rows = drive_rows(world.asking(), guess);
    Eigen::VectorXd figures = Eigen::VectorXd::Zero(rows.columns.count());
    for (Eigen::Index j = 0; j < rows.columns.joints; ++j)
      figures[rows.columns.joint(JointFigure::lag, j)] = late.lag;
    return rms(rows.y - rows.X * figures);
  };
  const Eigen::VectorXd lags = Eigen::VectorXd::Constant(12, late.lag);
  EXPECT_LT(left({{}, lags, {}, {}}), 0.6 * left({})) << "the goals bend within it";
}

}  // namespace
}  // namespace sanso::diagnose
