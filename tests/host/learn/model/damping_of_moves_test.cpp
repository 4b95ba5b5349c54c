// Damping from moves: found where it is known, left alone where nothing moves, bounded.
#include "host/learn/model/damping_of_moves.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/host/learn/model/identify_windows.h"

namespace sanso::learn {
namespace {

constexpr int kWindows = 12;

/// The damping that windows of a robot with `times` the initial model's show, in prior deviations.
double found(double times, const DampingOfMovesSettings& settings = {}) {
  model::ModelParameters truth = model::nominal_parameters();
  for (auto& servo : truth.servo) servo.damping *= times;
  const auto windows = windows_of_world(truth, kWindows);
  const ParameterMap map(model::nominal_parameters());
  const auto loss = [&](const Eigen::VectorXd& z) {
    return n_step_loss(windows, model::make_step_model(map.parameters(z)), model::make_plane(),
                       state_weights());
  };
  return best_damping(map, Eigen::VectorXd::Zero(map.size()), loss, settings);
}

TEST(DampingOfMoves, IsFoundWhereItIsKnown) {
  DampingOfMovesSettings settings;
  settings.highest_damping = 2.5;
  for (const double times : {0.85, 1.0, 1.5}) {
    const double deviations = std::log(times) / ParameterPrior{}.log_damping;
    EXPECT_NEAR(found(times, settings), deviations, 0.05) << times << " times the initial model's";
  }
}

TEST(DampingOfMoves, StaysInsideItsBounds) {
  const DampingOfMovesSettings settings;
  EXPECT_NEAR(found(4.0), settings.highest_damping, 0.02);
  EXPECT_NEAR(found(0.3), settings.lowest_damping, 0.02);
}

TEST(DampingOfMoves, ARestIsNoMove) {
  std::vector<PredictionWindow> windows = windows_of_world(model::nominal_parameters(), 3);
  for (model::Input& u : windows[1].u) u = windows[1].u[0];
  EXPECT_EQ(moves_of(windows, 0.06).size(), 2U);
  // what stands beyond the steps that were recorded is no move either
  windows[2].u[0].setZero();
  windows[2].steps = 1;
  EXPECT_EQ(moves_of(windows, 0.06).size(), 1U);
}

}  // namespace
}  // namespace sanso::learn
