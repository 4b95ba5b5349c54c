// Gauss-Newton finds what made the data where the model has a place for it, and only there.
#include "host/learn/model/refine.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/host/learn/model/identify_windows.h"

namespace sanso::learn {
namespace {

const model::Ground kFloor = model::make_plane();
const model::Tangent kWeights = state_weights();

model::ModelParameters put_together_by_hand() {
  model::ModelParameters truth = model::nominal_parameters();
  truth.servo[2].zero = 0.02;   // right hip pitch
  truth.servo[9].zero = -0.03;  // left knee
  truth.servo[11].zero = 0.02;  // left ankle roll
  truth.ground_height = 0.004;
  truth.target_lag_s = 0.013;
  return truth;
}

TEST(Refine, FindsZerosHeightAndLagThatMadeTheData) {
  const model::ModelParameters truth = put_together_by_hand();
  const auto windows = windows_of_world(truth, 48);
  const ParameterMap map(model::nominal_parameters());
  RefineSettings settings;
  settings.steps = 20;
  const auto loss = [&](const model::ModelParameters& theta) {
    return n_step_loss(windows, model::make_step_model(theta), model::make_plane(),
                       state_weights());
  };
  const double before = loss(model::nominal_parameters());
  const Eigen::VectorXd z = refined({windows, map, kFloor, kWeights}, 1e-6 * before,
                                    Eigen::VectorXd::Zero(map.size()), settings, 2);
  const model::ModelParameters found = map.parameters(z);
  EXPECT_LT(loss(found), 1e-3 * before);
  EXPECT_NEAR(found.ground_height, truth.ground_height, 5e-4);
  EXPECT_NEAR(found.target_lag_s, truth.target_lag_s, 5e-4);
  for (int j = 0; j < model::kNumJoints; ++j)
    EXPECT_NEAR(found.servo[j].zero, truth.servo[j].zero, 0.004) << "joint " << j;
}

TEST(Refine, WithoutTheirEntriesTheyStayUnexplained) {
  const auto windows = windows_of_world(put_together_by_hand(), 48);
  const ParameterMap map(model::nominal_parameters(), as_drawn({}));
  RefineSettings settings;
  settings.steps = 20;
  const double before = n_step_loss(windows, model::make_step_model(model::nominal_parameters()),
                                    model::make_plane(), state_weights());
  const Eigen::VectorXd z = refined({windows, map, kFloor, kWeights}, 1e-6 * before,
                                    Eigen::VectorXd::Zero(map.size()), settings, 1);
  const double after = n_step_loss(windows, model::make_step_model(map.parameters(z)),
                                   model::make_plane(), state_weights());
  EXPECT_LT(after, before) << "never to a larger loss";
  EXPECT_GT(after, 0.05 * before);
}

TEST(Refine, WhereNothingCanBePredictedItStays) {
  auto windows = windows_of_world(model::nominal_parameters(), 4);
  windows[1].x[3][0] = std::nan("");
  const ParameterMap map(model::nominal_parameters());
  const Eigen::VectorXd z = Eigen::VectorXd::Constant(map.size(), 0.1);
  EXPECT_EQ(refined({windows, map, kFloor, kWeights}, 1e-3, z, {}, 1), z);
}

TEST(NStepLoss, IsTheSumOfTheSquaredErrors) {
  auto windows = windows_of_world(put_together_by_hand(), 11);
  windows[3].steps = 2;
  const auto model = model::make_step_model(model::nominal_parameters());
  const double loss = n_step_loss(windows, model, model::make_plane(), state_weights());
  const Eigen::MatrixXd errors =
      n_step_errors(windows, model, model::make_plane(), state_weights());
  EXPECT_EQ(errors.cols(), 10 * kPredictionSteps + 2);
  EXPECT_NEAR(errors.squaredNorm(), loss, 1e-12 * loss);
}

}  // namespace
}  // namespace sanso::learn
