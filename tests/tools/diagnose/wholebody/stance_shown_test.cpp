// What a page shows of a balance is what the balance says: torque that is missing stands where it
// is missing, and what was found takes it away.
#include "tools/diagnose/wholebody/stance_shown.h"

#include <gtest/gtest.h>

#include "tests/tools/diagnose/wholebody/made_stance.h"
#include "tools/diagnose/wholebody/drive_rows.h"

namespace sanso::diagnose {
namespace {

using namespace test;

/// A robot with one drive of another gain.
struct Shown {
  StanceWorld world;
  DriveRows rows;
  Eigen::VectorXd named;
  StanceShown shown;

  static Stance softer(int joint, double gain) {
    Stance out;
    out.recordings = 2, out.current = true;
    out.drive = [=](int j) { return TrueDrive{.gain = j == joint ? gain : 1.0}; };
    return out;
  }
  Shown(int joint, double gain) : world(softer(joint, gain)), rows(drive_rows(world.asking())) {
    named = Eigen::VectorXd::Zero(rows.columns.count());
    named[rows.columns.joint(JointFigure::gain, joint)] = gain - 1.0;
    shown = stance_shown(rows, named);
  }
  double rms(const std::vector<TorqueSample>& samples, std::size_t joint) const {
    double squares = 0.0, count = 0.0;
    for (const TorqueSample& s : samples)
      if (s.joint == joint) squares += s.missing * s.missing, count += 1.0;
    return std::sqrt(squares / count);
  }
};

TEST(StanceShown, HasAMomentAWindowAndASampleAJoint) {
  const Shown s(3, 0.7);
  EXPECT_EQ(s.shown.moments.size(), s.rows.windows.size());
  const auto joints = static_cast<std::size_t>(s.rows.columns.joints);
  EXPECT_EQ(s.shown.nominal.size(), joints * s.rows.windows.size());
  EXPECT_EQ(s.shown.patched.size(), s.shown.nominal.size());
  for (const StanceShown::Moment& m : s.shown.moments) {
    EXPECT_GE(m.t, 0.0);
    EXPECT_LT(m.recording, 2u);
  }
}

TEST(StanceShown, WhatIsMissingIsAtTheJointThatLacksIt) {
  const Shown s(3, 0.7);
  for (std::size_t j = 0; j < 12; ++j) {
    if (j == 3) continue;
    EXPECT_GT(s.rms(s.shown.nominal, 3), 2.0 * s.rms(s.shown.nominal, j)) << j;
  }
  EXPECT_LT(s.rms(s.shown.patched, 3), 0.3 * s.rms(s.shown.nominal, 3));
}

TEST(StanceShown, IsATorqueInNewtonMetres) {
  const Shown s(3, 0.7);
  const double stiffness = s.rows.laws[3].stiffness;
  double errors = 0.0, missing = 0.0;
  for (const TorqueSample& sample : s.shown.nominal) {
    if (sample.joint != 3) continue;
    errors += sample.error * sample.error, missing += sample.missing * sample.error;
  }
  // the loop gives 0.7 of stiffness times error
  EXPECT_NEAR(missing / errors, -0.3 * stiffness, 0.05 * stiffness);
}

TEST(StanceShown, MomentsFallWithWhatWasFound) {
  const Shown s(3, 0.7);
  double nominal = 0.0, patched = 0.0;
  for (const StanceShown::Moment& m : s.shown.moments)
    nominal += m.nominal * m.nominal, patched += m.patched * m.patched;
  EXPECT_LT(patched, 0.2 * nominal);
}

TEST(StanceShown, NothingFoundIsTheNominal) {
  Shown s(3, 0.7);
  const StanceShown same = stance_shown(s.rows, Eigen::VectorXd::Zero(s.rows.columns.count()));
  for (std::size_t i = 0; i < same.nominal.size(); ++i)
    EXPECT_EQ(same.nominal[i].missing, same.patched[i].missing);
}

}  // namespace
}  // namespace sanso::diagnose
