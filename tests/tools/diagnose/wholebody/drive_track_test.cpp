// What a window says of a recording: means of what was read, with what is known of sensors taken
// out, and no weight where a foot comes down.
#include "tools/diagnose/wholebody/drive_track.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/tools/diagnose/wholebody/made_stance.h"

namespace sanso::diagnose {
namespace {

using namespace test;

/// A robot that stands still, its goals a rising line and its feet on scales.
class DriveTrack : public ::testing::Test {
 protected:
  DriveTrack() : world_({.recordings = 1, .seconds = 1.0, .current = true}) {
    WholeRecording& r = world_.recordings.front();
    r.q.setConstant(0.2);
    r.attitude = true;
    for (Eigen::Index k = 0; k < r.u.cols(); ++k) r.u.col(k).setConstant(slope_ * r.t[at(k)]);
    for (V3& acc : r.imu_acc) acc = V3(0.0, 0.0, 9.81);
    for (V3& w : r.w) w.setZero();
    r.feet = {{"left", 5, std::vector<double>(r.rows(), 10.0)},
              {"right", 11, std::vector<double>(r.rows(), 20.0)}};
  }
  static std::size_t at(Eigen::Index k) { return static_cast<std::size_t>(k); }
  WholeRecording& recording() { return world_.recordings.front(); }
  WindowMeans means(std::size_t a, std::size_t b) const { return means(world_.asking(), a, b); }
  WindowMeans means(const Asking& asking, std::size_t a, std::size_t b) const {
    return window_of(asking, track_of(asking, world_.recordings.front()), a, b);
  }

  static constexpr double slope_ = 0.5;  // rad/s, of the goals
  StanceWorld world_;
};

TEST_F(DriveTrack, ErrorIsThatOfTheGoalThatActed) {
  const WholeRecording& r = recording();
  const double middle = r.t[14] + 0.5 * r.interval;  // of rows 10 to 19
  const WindowMeans with_current = means(10, 20);
  EXPECT_NEAR(with_current.error[0], slope_ * (middle - r.interval) - 0.2, 1e-9);
  EXPECT_NEAR(with_current.command_rate[0], slope_, 1e-9);
  recording().current = false;  // then torques are those that moved it, over half of both rows
  EXPECT_NEAR(means(10, 20).error[0], slope_ * (middle - 0.5 * r.interval) - 0.2, 1e-9);
}

TEST_F(DriveTrack, ADelayIsThatOfTheGoalsAlone) {
  for (Eigen::Index k = 0; k < recording().u.cols(); ++k)
    recording().u.col(k).setConstant(std::sin(9.0 * recording().t[at(k)]));
  const auto n = recording().q.rows();
  const Asking asking = world_.asking();
  const Track now = track_of(asking, recording());
  const Track whole = track_of(asking, recording(), Eigen::VectorXd::Constant(n, 0.03));
  const Track half = track_of(asking, recording(), Eigen::VectorXd::Constant(n, 0.035));
  for (std::size_t k = 10; k < recording().rows(); ++k) {
    const auto& e = now.joints[2].error;
    EXPECT_NEAR(whole.joints[2].error[k], e[k - 3], 1e-9);
    EXPECT_NEAR(half.joints[2].error[k], 0.5 * (e[k - 3] + e[k - 4]), 1e-9);
    EXPECT_NEAR(whole.joints[2].command_rate[k], now.joints[2].command_rate[k - 3], 1e-6);
  }
  EXPECT_EQ(whole.joints[2].error[0], now.joints[2].error[0]) << "nobody knows what was before";
}

TEST_F(DriveTrack, AFootStandsWhereItCarriesAGoodPartAllTheTime) {
  const double weight = world_.body.mass() * 9.81;
  for (FootForce& foot : recording().feet) foot.fz.assign(recording().rows(), 0.5 * weight);
  EXPECT_EQ(means(10, 20).stands, (std::vector<std::size_t>{0, 1}));
  recording().feet[0].fz[15] = 0.05 * weight;
  EXPECT_EQ(means(10, 20).stands, (std::vector<std::size_t>{1}));
}

TEST_F(DriveTrack, AZeroThatIsKnownMovesTheJointAndNotTheLoop) {
  Asking asking = world_.asking();
  asking.known.zero.assign(static_cast<std::size_t>(recording().q.rows()), 0.03);
  const WindowMeans known = means(asking, 10, 20), unknown = means(10, 20);
  EXPECT_NEAR(known.motion.q[3], unknown.motion.q[3] - 0.03, 1e-9);
  EXPECT_NEAR(known.error[3], unknown.error[3], 1e-12);
}

TEST_F(DriveTrack, WhatStandsHasNoDirection) {
  const WindowMeans w = means(10, 20);
  EXPECT_NEAR(w.sign.cwiseAbs().maxCoeff(), 0.0, 1e-3);
  EXPECT_NEAR(w.motion.dq.norm(), 0.0, 1e-4);
  EXPECT_NEAR((w.motion.acc - V3(0.0, 0.0, 9.81)).norm(), 0.0, 1e-3);
}

TEST_F(DriveTrack, WeightIsTheSumOfTheFeet) {
  EXPECT_NEAR(means(10, 20).weight, 30.0, 1e-9);
  Asking asking = world_.asking();
  asking.known.force_scale = 1.2;
  EXPECT_NEAR(means(asking, 10, 20).weight, 25.0, 1e-9);
}

TEST_F(DriveTrack, WhereAFootComesDownNothingIsSaidOfTheWeight) {
  for (std::size_t k = 15; k < recording().rows(); ++k) recording().feet[0].fz[k] = 25.0;
  EXPECT_TRUE(std::isnan(means(10, 20).weight));
  EXPECT_NEAR(means(20, 30).weight, 45.0, 1e-9);
  EXPECT_NEAR(means(1, 11).weight, 30.0, 1e-9);
}

TEST_F(DriveTrack, AFootIsInTheAirWhereItCarriesNothingAllTheTime) {
  EXPECT_TRUE(means(10, 20).in_air.empty());
  for (std::size_t k = 5; k < 25; ++k) recording().feet[1].fz[k] = 0.05;
  EXPECT_EQ(means(10, 20).in_air, std::vector<int>{11});
  EXPECT_TRUE(means(20, 30).in_air.empty()) << "it came down in it";
  recording().feet[1].fz[15] = std::nan("");
  EXPECT_TRUE(means(10, 20).in_air.empty()) << "nobody read it";
}

TEST_F(DriveTrack, WithoutFeetOrAttitudeThereIsNoWeight) {
  recording().feet.clear();
  recording().attitude = false;
  const Track track = track_of(world_.asking(), recording());
  EXPECT_TRUE(track.weight.empty());
  EXPECT_TRUE(track.up.empty());
}

}  // namespace
}  // namespace sanso::diagnose
