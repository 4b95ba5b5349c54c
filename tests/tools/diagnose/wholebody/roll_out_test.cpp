// A floating robot let go from a recorded state does what textbook formulas say where the model is
// the world, and something else where it is not.
#include "tools/diagnose/wholebody/roll_out.h"

#include <gtest/gtest.h>

#include <functional>

#include "tests/tools/diagnose/wholebody/made_toss.h"

namespace sanso::diagnose {
namespace {

using namespace test;

constexpr const char* kGround = "[ground]\nfriction = 0.2\nrestitution = 0.4\nheight = 0.0\n";
constexpr const char* kBrick = R"(<robot name="brick"><link name="brick"><inertial><mass value="2"/>
<inertia ixx="0.003" ixy="0" ixz="0" iyy="0.008" iyz="0" izz="0.009"/></inertial><collision>
<geometry><box size="0.2 0.1 0.06"/></geometry></collision></link></robot>)";

M3 turn(const V3& rotation) {
  return Eigen::AngleAxisd(rotation.norm(), rotation.normalized()).toRotationMatrix();
}

/// Largest distance between recording and roll-out.
double apart(const WholeRecording& r, const BaseMotion& m, const Span& shot) {
  double out = 0.0;
  for (std::size_t k = 0; k < m.p.size(); ++k)
    out = std::max(out, (m.p[k] - r.p[shot.first + k]).norm());
  return out;
}

WholeRecording judged(const WholeBody& body, const recording::Recording& r) {
  const WholeData data = judge_whole({r}, body, WholeOptions{}.settings);
  EXPECT_TRUE(data.defects.empty());
  return data.recordings.at(0);
}

/// Rows of 10 ms of a base that is thrown with `v`, `w`, and not recorded further: the first row is
/// a piece of its own, so that no other says its velocity.
WholeRecording made(double seconds, const V3& p, const M3& R, const V3& v, const V3& w,
                    const std::function<Eigen::VectorXd(double)>& q) {
  WholeRecording r;
  r.attitude = r.position = true;
  const auto rows = static_cast<std::size_t>(seconds / 0.01);
  r.q.resize(q(0).size(), static_cast<Eigen::Index>(rows));
  for (std::size_t k = 0; k < rows; ++k) {
    r.t.push_back(0.01 * static_cast<double>(k)), r.piece.push_back(k == 0 ? 0 : 1);
    r.p.push_back(p), r.R.push_back(R), r.v.push_back(v), r.w.push_back(w);
    r.q.col(static_cast<Eigen::Index>(k)) = q(r.t.back());
  }
  return r;
}
WholeRecording made(double seconds, const V3& p, const V3& v, const V3& w, int joints = 0) {
  return made(seconds, p, M3::Identity(), v, w,
              [joints](double) { return Eigen::VectorXd(Eigen::VectorXd::Zero(joints)); });
}

TEST(RollOut, ATossedBallDoesWhatItDidWhereTheModelIsTheWorld) {
  constexpr Span kTwoBounces{5, 100};  // the toss ends where it hardly rebounds any more
  for (unsigned long seed = 1; seed <= 4; ++seed) {
    const recording::Recording thrown = toss({}, seed);
    const auto with = [&](const std::string& ground) {
      const WholeBody body = body_of(ground, kBall);
      const WholeRecording r = judged(body, thrown);
      return apart(r, BaseRollOut(body, r).from(kTwoBounces), kTwoBounces);
    };
    constexpr double kSame_m = 0.01;
    EXPECT_LT(with(kGround), kSame_m) << seed;
    EXPECT_GT(with("[ground]\nfriction = 0.2\nrestitution = 0.8\nheight = 0.0\n"), 3 * kSame_m)
        << seed;
    EXPECT_GT(with("[ground]\nfriction = 0.05\nrestitution = 0.4\nheight = 0.0\n"), 3 * kSame_m)
        << seed;
  }
}

TEST(RollOut, PositionsAreInTheRecordingsLengths) {
  const recording::Recording thrown = toss({.scale = 0.96}, 1);
  const WholeBody nominal = body_of(kGround, kBall);
  Patch found;
  found.pose_scale = 0.96;
  const WholeRecording r = judged(nominal, thrown);
  constexpr Span kUntilTheFirst{5, 50};
  const auto with = [&](const WholeBody& body) {
    return apart(r, BaseRollOut(body, r).from(kUntilTheFirst), kUntilTheFirst);
  };
  const double before = with(nominal), after = with(patched(nominal, found));
  EXPECT_LT(after, 0.002);
  EXPECT_GT(before, 2.0 * after);
}

TEST(RollOut, WhatSlidesStopsWhereFrictionStopsIt) {
  const WholeBody body = body_of(kGround, kBrick);
  const WholeRecording r = made(1.0, {0, 0, 0.03}, {0.8, 0, 0}, V3::Zero());
  const BaseMotion m = BaseRollOut(body, r).from({0, r.rows()});
  EXPECT_NEAR(m.p.back().x(), 0.8 * 0.8 / (2 * 0.2 * 9.81), 0.004);
  EXPECT_NEAR(m.p.back().z(), 0.03, 0.001);
  EXPECT_LT(turned(m.R.back(), M3::Identity()).norm(), 0.01);
}

TEST(RollOut, WhatTurnsInTheAirKeepsItsSpinAndItsEnergy) {
  const WholeBody body = body_of(kGround, kBrick);
  const V3 w(0.3, 9.0, 0.2);  // about the middle axis: it turns over
  const WholeRecording r = made(0.6, {0, 0, 3}, {1, 0, 2}, w);
  const BaseMotion m = BaseRollOut(body, r).from({0, r.rows()});
  const M3 I = V3(0.003, 0.008, 0.009).asDiagonal();
  for (std::size_t k = 1; k + 1 < r.rows(); ++k) {
    const V3 rate = turned(m.R[k - 1], m.R[k + 1]) / 0.02;  // about the axes of the row before
    const V3 spin = m.R[k - 1] * turn(0.5 * 0.02 * rate) * I * rate;
    EXPECT_LT((spin - I * w).norm(), 0.02 * (I * w).norm()) << k;
    EXPECT_NEAR(0.5 * rate.dot(I * rate), 0.5 * w.dot(I * w), 0.03 * w.dot(I * w)) << k;
    const double t = r.t[k];
    EXPECT_NEAR(m.p[k].z(), 3 + 2 * t - 0.5 * 9.81 * t * t, 1e-6);
  }
}

/// Angular momentum about the origin of what kTwoLegs weighs, from its poses at two instants.
V3 momentum(const M3& R0, const V3& p0, const Eigen::VectorXd& q0, const M3& R1, const V3& p1,
            const Eigen::VectorXd& q1, double dt) {
  struct Part {
    double mass;
    V3 at, inertia;
  };
  const auto parts = [](const Eigen::VectorXd& q) {
    return std::vector<Part>{{4.0, {0.01, 0, 0.1}, {0.02, 0.02, 0.01}},
                             {0.5, {0, 0.1, -0.3 + q[0]}, {1e-3, 1e-3, 1e-3}},
                             {0.5, {0, -0.1, -0.3 + q[1]}, {1e-3, 1e-3, 1e-3}}};
  };
  V3 out = V3::Zero();
  const V3 w = R0 * turned(R0, R1) / dt;
  const std::vector<Part> a = parts(q0), b = parts(q1);
  for (std::size_t i = 0; i < a.size(); ++i) {
    const V3 here = p0 + R0 * a[i].at, there = p1 + R1 * b[i].at;
    out += a[i].mass * (0.5 * (here + there)).cross((there - here) / dt) +
           R0 * a[i].inertia.asDiagonal() * R0.transpose() * w;
  }
  return out;
}

TEST(RollOut, JointsThatSwingTurnTheBaseAndChangeNoMomentum) {
  WholeBody body = body_of(kGround, kTwoLegs);
  body.model.gravity = {0, 0, 0};
  const auto q = [](double t) {
    return Eigen::VectorXd(Eigen::Vector2d(0.15 * std::sin(9 * t), -0.15 * std::sin(9 * t)));
  };
  const WholeRecording r = made(0.5, {0, 0, 3}, M3::Identity(), V3::Zero(), {0.4, 0.1, 0.3}, q);
  const BaseMotion m = BaseRollOut(body, r).from({0, r.rows()});
  const auto at = [&](std::size_t k) {
    return momentum(m.R[k], m.p[k], q(r.t[k]), m.R[k + 1], m.p[k + 1], q(r.t[k + 1]), 0.01);
  };
  double turned_most = 0.0;
  for (std::size_t k = 0; k + 1 < r.rows(); ++k) {
    EXPECT_LT((at(k) - at(0)).norm(), 0.02 * at(0).norm() + 0.002) << k;
    const V3 rate = turned(m.R[k], m.R[k + 1]) / 0.01;
    turned_most = std::max(turned_most, std::abs(rate.x() - 0.4));
  }
  EXPECT_GT(turned_most, 0.3) << "the legs turn the trunk";
}

TEST(RollOut, WhatStandsOnASlopeStaysWhereTheModelKnowsTheSlope) {
  const V2 slope(0.06, 0.0);
  const M3 R = turn({slope[0], slope[1], 0});
  const V3 up = R.col(2);
  const WholeBody nominal = body_of("[ground]\nfriction = 0.8\n", kTwoLegs);
  Patch found;
  found.slope = slope;
  const WholeRecording r = made(1.0, 0.31 * up, R, V3::Zero(), V3::Zero(),
                                [](double) { return Eigen::VectorXd(Eigen::VectorXd::Zero(2)); });
  const BaseMotion flat = BaseRollOut(nominal, r).from({0, r.rows()}),
                   leans = BaseRollOut(patched(nominal, found), r).from({0, r.rows()});
  EXPECT_LT(turned(leans.R.back(), R).norm(), 0.005);
  EXPECT_LT((leans.p.back() - r.p.back()).norm(), 0.002);
  EXPECT_LT(turned(flat.R.back(), M3::Identity()).norm(), 0.01) << "stands upright on the flat";
}

}  // namespace
}  // namespace sanso::diagnose
