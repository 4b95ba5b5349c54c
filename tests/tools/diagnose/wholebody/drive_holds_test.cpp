// Standing twice as long tells no more; another posture does.
#include "tools/diagnose/wholebody/drive_holds.h"

#include <gtest/gtest.h>

namespace sanso::diagnose {
namespace {

/// Windows of one joint at these positions, moving as much as `sign` says.
std::vector<StandingWindow> at(const std::vector<double>& q, double sign) {
  std::vector<StandingWindow> out(q.size());
  for (std::size_t k = 0; k < q.size(); ++k) {
    out[k].means.motion.q = Eigen::VectorXd::Constant(1, q[k]);
    out[k].means.sign = Eigen::VectorXd::Constant(1, sign);
  }
  return out;
}

std::vector<double> alike(const std::vector<StandingWindow>& windows, double zero) {
  std::vector<double> out;
  for (const Eigen::VectorXd& n : holds_alike(windows, zero)) out.push_back(n[0]);
  return out;
}

TEST(DriveHolds, CountTheWindowsOfAPosture) {
  EXPECT_EQ(alike(at({0.1, 0.5, 0.1, 0.1, 0.5, -0.3}, 0.0), 0.01),
            (std::vector<double>{3, 2, 3, 3, 2, 1}));
  EXPECT_EQ(alike(at({0.10, 0.12, 0.14}, 0.0), 0.021), (std::vector<double>{2, 3, 2}));
  EXPECT_TRUE(holds_alike({}, 0.01).empty());
}

// Friction of a joint that moves points against it and is a figure, not what holds it.
TEST(DriveHolds, WhatMovesIsNotHeld) {
  EXPECT_EQ(alike(at({0.1, 0.1, 0.1, 0.1}, -1.0), 0.01), (std::vector<double>{1, 1, 1, 1}));
  EXPECT_EQ(alike(at({0.1, 0.1, 0.1, 0.1}, 0.5), 0.01), (std::vector<double>{2, 2, 2, 2}));
}

}  // namespace
}  // namespace sanso::diagnose
