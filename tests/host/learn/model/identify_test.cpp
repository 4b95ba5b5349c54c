// Identification's parts: bodies that could exist, a search that finds and continues, a loss
// that is zero for the truth.
#include "host/learn/model/identify.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "host/learn/model/pseudo_inertia.h"
#include "tests/host/learn/model/identify_windows.h"

namespace sanso::learn {
namespace {

TEST(PseudoInertia, RoundTripOfEveryLink) {
  const model::ModelParameters nominal = model::nominal_parameters();
  for (int b = 0; b < model::kNumBodies; ++b) {
    const model::BodyInertia& body = nominal.body[b];
    const model::BodyInertia back = body_of(log_cholesky_of(body));
    EXPECT_NEAR(back.mass, body.mass, 1e-12);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(back.com[i], body.com[i], 1e-12);
    for (int i = 0; i < 6; ++i)
      EXPECT_NEAR(back.inertia[i], body.inertia[i], 1e-12) << "body " << b << " entry " << i;
  }
}

TEST(PseudoInertia, EveryParameterVectorIsABodyThatCouldExist) {
  std::mt19937_64 rng(kSeed);
  std::normal_distribution<double> normal;
  for (int k = 0; k < 1000; ++k) {
    LogCholesky p;
    for (double& v : p) v = 2.0 * normal(rng);
    const model::BodyInertia b = body_of(p);
    Eigen::Matrix3d I;
    I << b.inertia[0], b.inertia[1], b.inertia[2], b.inertia[1], b.inertia[3], b.inertia[4],
        b.inertia[2], b.inertia[4], b.inertia[5];
    EXPECT_GT(b.mass, 0.0);
    // positive density: the second moments about the centre of mass are positive semi-definite
    const Eigen::Matrix3d second_moments = 0.5 * I.trace() * Eigen::Matrix3d::Identity() - I;
    EXPECT_GE(second_moments.eigenvalues().real().minCoeff(), -1e-9 * I.trace())
        << "seed " << kSeed << " draw " << k;
  }
}

TEST(PseudoInertia, ImpossibleBodyIsRefused) {
  EXPECT_THROW(log_cholesky_of({1.0, {0, 0, 0}, {1.0, 0, 0, 0.1, 0, 0.1}}), std::invalid_argument)
      << "1 > 0.1 + 0.1";
}

std::vector<double> bowl(const Eigen::MatrixXd& z) {
  std::vector<double> losses;
  for (Eigen::Index c = 0; c < z.cols(); ++c) {
    const Eigen::Vector3d d = z.col(c) - Eigen::Vector3d(0.5, -1.0, 0.2);
    losses.push_back(d[0] * d[0] + 10 * d[1] * d[1] + d[2] * d[2] + d[0] * d[1]);
  }
  return losses;
}

TEST(CrossEntropy, FindsTheBottomOfABowl) {
  CrossEntropySettings settings;
  settings.smallest_deviation = 1e-4;
  auto state = start_cross_entropy(Eigen::Vector3d::Zero(), Eigen::Vector3d::Ones(), bowl);
  for (int g = 0; g < 25; ++g) advance_cross_entropy(state, settings, kSeed, bowl);
  EXPECT_LT((state.best - Eigen::Vector3d(0.5, -1.0, 0.2)).norm(), 0.02);
}

TEST(CrossEntropy, ContinuedSearchEqualsUninterrupted) {
  const CrossEntropySettings settings;
  auto whole = start_cross_entropy(Eigen::Vector3d::Zero(), Eigen::Vector3d::Ones(), bowl);
  for (int g = 0; g < 6; ++g) advance_cross_entropy(whole, settings, kSeed, bowl);
  auto first = start_cross_entropy(Eigen::Vector3d::Zero(), Eigen::Vector3d::Ones(), bowl);
  for (int g = 0; g < 3; ++g) advance_cross_entropy(first, settings, kSeed, bowl);
  CrossEntropyState stored = first;  // what a file would hold
  for (int g = 0; g < 3; ++g) advance_cross_entropy(stored, settings, kSeed, bowl);
  EXPECT_EQ(whole.mean, stored.mean);
  EXPECT_EQ(whole.best, stored.best);
}

TEST(CrossEntropy, NotANumberIsWorst) {
  const EvaluateCandidates holes = [](const Eigen::MatrixXd& z) {
    std::vector<double> losses = bowl(z);
    for (std::size_t i = 0; i < losses.size(); i += 2) losses[i] = std::nan("");
    return losses;
  };
  auto state = start_cross_entropy(Eigen::Vector3d::Zero(), Eigen::Vector3d::Ones(), bowl);
  for (int g = 0; g < 10; ++g) advance_cross_entropy(state, {}, kSeed, holes);
  EXPECT_TRUE(state.best.allFinite());
  EXPECT_LT(state.best_loss, 1.0);
}

TEST(NStepLoss, IsZeroForTheModelThatMadeTheData) {
  // not a multiple of the lanes
  const auto windows = windows_of_world(model::nominal_parameters(), 11);
  const auto model = model::make_step_model(model::nominal_parameters());
  EXPECT_LT(n_step_loss(windows, model, model::make_plane(), state_weights()), 1e-12);
}

TEST(Identify, ThreadsDoNotChangeTheResult) {
  model::ModelParameters truth = model::nominal_parameters();
  truth.body[0].mass += 0.3;
  const auto windows = windows_of_world(truth, 16);
  const ParameterMap map(model::nominal_parameters());
  IdentifySettings settings;
  settings.search.generations = 2;
  settings.threads = 1;
  const auto one = identify(windows, map, model::make_plane(), state_weights(), settings, kSeed);
  settings.threads = 3;
  const auto three = identify(windows, map, model::make_plane(), state_weights(), settings, kSeed);
  EXPECT_EQ(one.z, three.z);
}

TEST(Identify, NoDataIsAnError) {
  const ParameterMap map(model::nominal_parameters());
  EXPECT_THROW(identify({}, map, model::make_plane(), state_weights(), {}, kSeed),
               std::invalid_argument);
}

Eigen::Index entry(const ParameterMap& map, const std::string& name) {
  const auto at = std::find(map.names().begin(), map.names().end(), name);
  EXPECT_NE(at, map.names().end()) << name;
  return at - map.names().begin();
}

TEST(ParameterMap, OnSkatesRollingFrictionIsAFigureOfItsOwn) {
  const ParameterMap soles(model::nominal_parameters()), skates(model::skating_parameters());
  ASSERT_EQ(skates.size(), soles.size() + 1);
  const model::ModelParameters first = skates.parameters(Eigen::VectorXd::Zero(skates.size()));
  Eigen::VectorXd z = Eigen::VectorXd::Zero(skates.size());
  z[entry(skates, "wheels:rolling")] = -1.0;  // rolls better
  const model::ModelParameters rolling = skates.parameters(z);
  EXPECT_NEAR(rolling.friction_forward / first.friction_forward, std::exp(-0.7), 1e-12);
  EXPECT_EQ(rolling.friction_sideways, first.friction_sideways);
  z.setZero();
  z[entry(skates, "ground:friction")] = 1.0;  // a rough ground
  const model::ModelParameters rough = skates.parameters(z);
  EXPECT_EQ(rough.friction_forward, first.friction_forward);
  EXPECT_GT(rough.friction_sideways, first.friction_sideways);
  EXPECT_TRUE(rough.foot.wheels) << "the shape of the feet stays";
}

TEST(ParameterMap, HowItWasPutTogetherComesLastAndMayBeLeftOut) {
  const ParameterMap all(model::nominal_parameters()),
      drawn(model::nominal_parameters(), as_drawn({}));
  ASSERT_EQ(all.size(), drawn.size() + model::kNumJoints + 2);
  for (Eigen::Index i = 0; i < drawn.size(); ++i)
    EXPECT_EQ(all.names()[static_cast<std::size_t>(i)], drawn.names()[static_cast<std::size_t>(i)]);
  const Eigen::VectorXd z = Eigen::VectorXd::LinSpaced(all.size(), -1.0, 2.0);
  const model::ModelParameters theta = all.parameters(z),
                               as_drawn = drawn.parameters(z.head(drawn.size()));
  EXPECT_EQ(theta.servo[4].stiffness, as_drawn.servo[4].stiffness);
  EXPECT_EQ(as_drawn.servo[4].zero, 0.0);
  EXPECT_EQ(as_drawn.ground_height, 0.0);
  EXPECT_EQ(as_drawn.target_lag_s, 0.0);
  EXPECT_DOUBLE_EQ(theta.servo[4].zero, 0.0122 * z[entry(all, "zero:r_ank_pitch")]);
  EXPECT_DOUBLE_EQ(theta.ground_height, 0.003 * z[entry(all, "ground:height")]);
  EXPECT_DOUBLE_EQ(theta.target_lag_s, 0.010 * z[entry(all, "servo:lag")]);
}

TEST(ParameterMap, ATargetNeverActsBeforeItWasSentNorAStepLater) {
  const ParameterMap map(model::nominal_parameters());
  Eigen::VectorXd z = Eigen::VectorXd::Zero(map.size());
  z[entry(map, "servo:lag")] = -3.0;
  EXPECT_EQ(map.parameters(z).target_lag_s, 0.0);
  z[entry(map, "servo:lag")] = 30.0;
  EXPECT_EQ(map.parameters(z).target_lag_s, model::kLongestTargetLag_s);
}

}  // namespace
}  // namespace sanso::learn
