// A robot that stands says as much as its joints' friction lets it: what moving joints show of that
// friction is all that may hold them when they stand.
#include "tools/diagnose/wholebody/drive_balance.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/tools/diagnose/wholebody/made_stance.h"

namespace sanso::diagnose {
namespace {

using namespace test;

/// Stands in every second recording.
Stance half_still() {
  Stance out;
  out.recordings = 6, out.current = true;
  out.moves = [](int recording) { return recording % 2 == 0 ? 1.0 : 0.0; };
  return out;
}

std::string told(const DriveChoice& choice) {
  std::string out;
  for (const std::string& line : choice.log) out += line + "\n";
  return out;
}

double rms(const Eigen::VectorXd& x) {
  return std::sqrt(x.squaredNorm() / static_cast<double>(std::max<Eigen::Index>(1, x.size())));
}

TEST(DriveBalance, NamesACentreByHowTheRobotStands) {
  Stance stance = half_still();
  stance.links = [](WholeBody& body) { body.base.com[0] += 0.012; };
  const StanceWorld world(stance);
  const DriveChoice choice = balance_drives(world.asking()).choice;
  ASSERT_EQ(choice.terms.size(), 1u) << told(choice);
  const JudgedDriveTerm& first = choice.terms.front();
  EXPECT_EQ(first.term.effect, name_of(WholeFigure::centre)) << told(choice);
  EXPECT_EQ(first.term.where, std::vector<std::string>{world.body.root});
  EXPECT_NEAR(first.parameters.front().value, 0.012, 0.004);
  const std::string friction(effect_of(JointFigure::speed)->id);
  EXPECT_EQ(std::count(first.equally_good.begin(), first.equally_good.end(), friction), 0)
      << "what stands has no speed";
}

TEST(DriveBalance, FrictionThatHoldsIsNoCentre) {
  Stance stance = half_still();
  stance.drive = [](int) { return TrueDrive{.coulomb = 0.25}; };  // holds by all of it, one way
  const StanceWorld world(stance);
  const DriveChoice choice = balance_drives(world.asking()).choice;
  ASSERT_FALSE(choice.terms.empty());
  for (const JudgedDriveTerm& j : choice.terms)
    EXPECT_EQ(j.term.effect, effect_of(JointFigure::dry)->id) << told(choice);
  EXPECT_NEAR(choice.terms.front().parameters.front().value, 0.25, 0.04);
}

// Joints that never move show no friction: what holds them may be all that a nominal model allows,
// and no zero is read off a posture that they hold by themselves.
TEST(DriveBalance, JointsThatNeverMoveAreHeldByWhatNobodyKnows) {
  Stance stance = half_still();
  stance.moves = [](int) { return 0.0; };
  const StanceWorld still(stance), moving(half_still());
  const DriveBalance stood = balance_drives(still.asking()),
                     moved = balance_drives(moving.asking());
  const DriveGuess unknown = guess_of(still.asking(), stood.rows, stood.choice.figures);
  const DriveGuess known = guess_of(moving.asking(), moved.rows, moved.choice.figures);
  EXPECT_TRUE(unknown.dry.array().isInf().all());
  EXPECT_TRUE(known.dry.array().isFinite().all());
}

TEST(DriveBalance, OfARobotAsStatedAccusesNobody) {
  const StanceWorld world(half_still());
  const DriveBalance found = balance_drives(world.asking());
  EXPECT_TRUE(found.choice.terms.empty()) << told(found.choice);
  EXPECT_TRUE(found.choice.adequate);
}

TEST(DriveBalance, AGuessIsWhatTheFiguresSay) {
  Stance stance = half_still();
  stance.recordings = 1, stance.current = false;
  const StanceWorld world(stance);
  const Asking asking = world.asking();
  const DriveRows rows = drive_rows(asking);
  Eigen::VectorXd figures = Eigen::VectorXd::Zero(rows.columns.count());
  figures[rows.columns.joint(JointFigure::gain, 2)] = 0.5;
  figures[rows.columns.joint(JointFigure::lag, 3)] = 0.02;
  figures[rows.columns.joint(JointFigure::lag, 4)] = -0.5;  // earlier than at once
  figures[rows.columns.joint(JointFigure::dry, 5)] = 0.2;
  figures[rows.columns.joint(JointFigure::load, 6)] = 0.1;
  const DriveGuess guess = guess_of(asking, rows, figures);
  EXPECT_DOUBLE_EQ(guess.scales[2], 2.0);
  EXPECT_DOUBLE_EQ(guess.lags[3], 0.02);
  EXPECT_DOUBLE_EQ(guess.lags[4], -rows.laws[4].lag);
  EXPECT_NEAR(guess.dry[5] - guess.dry[4], 0.2, 1e-12);
  EXPECT_NEAR(guess.load[6] - guess.load[5], 0.1, 1e-12);
  EXPECT_GT(guess.dry[4], 0.0) << "what nobody states may be there";
}

TEST(DriveRows, OfAStanceWeighMoreTheLessMayHoldIt) {
  Stance stance = half_still();
  stance.moves = [](int) { return 0.0; };
  stance.links = [](WholeBody& body) { body.base.com[0] += 0.012; };
  const StanceWorld world(stance);
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(12), none = Eigen::VectorXd::Zero(12);
  double before = 0.0;
  for (const double dry : {0.3, 0.1, 0.02}) {
    const DriveRows rows = drive_rows(world.asking(), {ones, none, dry * ones, none});
    EXPECT_GT(rms(rows.y), 1.05 * before) << dry;
    before = rms(rows.y);
  }
  const DriveRows unknown = drive_rows(world.asking()),
                  most = drive_rows(world.asking(), {ones, none, 9.0 * ones, none});
  EXPECT_NEAR(rms(unknown.y), rms(most.y), 1e-9) << "what nobody knows is the most";
}

}  // namespace
}  // namespace sanso::diagnose
