// Duty is judged where the joint really was: what drifts in simulation contradicts no explanation.
#include "tools/diagnose/explain/effort_law.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/small_comparison.h"
#include "tools/diagnose/explain/incidence.h"
#include "tools/diagnose/fit/fit.h"

namespace sanso::diagnose {
namespace {

constexpr const char* kServo =
    "actuator = \"dc_servo\"\np_gain = 4.0\narmature = 0.01\ncoulomb = 0.02";

/// 6 s at 100 Hz of a servo with `effects` that its model does not know; duty recorded.
recording::Recording record(const std::vector<EffectEntry>& effects) {
  const ModelFolder world = test::hiding(test::pendulum(kServo), effects);
  const Drive drive = test::make_test_drive(world, 6.0, 0.01, [](int, double t) {
    return 0.7 * std::sin(2.1 * t) + 0.3 * std::sin(5.3 * t);
  });
  return test::record(world, drive, {.duty = true});
}

class EffortLaw : public testing::Test {
 protected:
  void observe(const std::vector<EffectEntry>& effects) {
    const test::SmallComparison compared(test::pendulum(kServo), {record(effects)},
                                         {{"q:a", 2e-4, 0.0, {}}, {"pwm:a", 2e-3, 0.0, {}}}, {});
    problem_ = compared.problem;
    library_ = compared.library;
  }
  Model with(const std::string& effect, const std::vector<double>& theta) const {
    for (std::size_t i = 0; i < library_.candidates.size(); ++i) {
      if (library_.candidates[i].effect == effect) return Model{{{i, theta}}, {}};
    }
    ADD_FAILURE() << effect;
    return {};
  }
  /// RMS of the duty rows, in units of the channel's scale.
  double duty_rms(const Eigen::VectorXd& error) const {
    double square = 0.0, rows = 0.0;
    for (const Shot& shot : problem_->shots) {
      for (std::size_t c = 0; c < problem_->channels.size(); ++c) {
        if (problem_->channels[c].signal != Signal::pwm) continue;
        square += rows_of(error, shot, c).squaredNorm();
        rows += static_cast<double>(shot.rows);
      }
    }
    return std::sqrt(square / rows);
  }
  /// Row of the table of promises; 0 when the promise was too small to be told.
  double promised_duty(const Model& model) const {
    const Surroundings around = make_surroundings(problem_, library_, Model{});
    const Regimes regimes = find_regimes(*problem_);
    for (const IncidenceRow& row :
         incidence(around, regimes, fit(around, Model{}, 0), fit(around, model, 0))) {
      if (row.residual.signal == Signal::pwm) return row.slope;
    }
    return 0.0;
  }
  Problem problem_;
  Library library_;
};

TEST_F(EffortLaw, FrictionDriftsTheSimulatedDutyAndNotTheLaw) {
  observe({{"coulomb_friction", {"a"}, {{"coulomb", 0.6}}, 0}});
  const double simulated = duty_rms(prediction_error(problem_, library_, Model{}));
  const double law = duty_rms(effort_error(*problem_, library_, Model{}));
  EXPECT_GT(simulated, 1.0);
  EXPECT_LT(law, 0.2 * simulated);
  EXPECT_EQ(promised_duty(with("coulomb_friction", {0.6})), 0.0)
      << "friction promises nothing about the duty";
}

TEST_F(EffortLaw, AWrongGainIsContradictedWhereItsDutyDidNotChange) {
  observe({{"coulomb_friction", {"a"}, {{"coulomb", 0.6}}, 0}});
  const Surroundings around = make_surroundings(problem_, library_, Model{});
  const FitResult nominal = fit(around, Model{}, 0),
                  gain = fit(around, with("servo_p_gain", {0.6}), 0);
  const std::string said =
      refuted_by(incidence(around, find_regimes(*problem_), nominal, gain), DecisionSettings{});
  EXPECT_NE(said, "");
  EXPECT_LT(std::abs(promised_duty(with("servo_p_gain", {0.6}))), 0.3);
}

TEST_F(EffortLaw, ARightGainKeepsItsPromise) {
  observe({{"servo_p_gain", {"a"}, {{"gain", 0.6}}, 0}});
  EXPECT_NEAR(promised_duty(with("servo_p_gain", {0.6})), 1.0, 0.1);
}

/// A late reading shows an old duty beside an old position: both belong to the command of then.
TEST_F(EffortLaw, ASensorDelayOfTheWorldIsNoErrorOfTheLawThatKnowsIt) {
  observe({{"sensor_delay", {"a"}, {{"delay", 0.03}}, 0}});
  const double without = duty_rms(effort_error(*problem_, library_, Model{}));
  const double known = duty_rms(effort_error(*problem_, library_, with("sensor_delay", {0.03})));
  EXPECT_LT(known, 0.3 * without);
}

}  // namespace
}  // namespace sanso::diagnose
