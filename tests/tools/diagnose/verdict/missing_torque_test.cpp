// The missing torque of a torque that is known, and experiments that separate what they promise.
#include "tools/diagnose/verdict/missing_torque.h"

#include <gtest/gtest.h>

#include "tests/support/noisy_world.h"
#include "tools/diagnose/explain/select.h"
#include "tools/diagnose/stats/robust.h"
#include "tools/diagnose/verdict/experiment.h"

namespace sanso::diagnose {
namespace {

using namespace test;

/// Missing torque of one joint when `effects` are hidden in two links.
std::vector<TorqueSample> missing_of(const std::vector<EffectEntry>& effects, std::size_t joint) {
  const SmallComparison c = compared(two_links(kNoisyServo), effects, {"coulomb_friction"}, 1);
  std::vector<TorqueSample> out;
  for (const TorqueSample& s : missing_torque(c.problem->sources, noise_of(two_links(kNoisyServo)),
                                              c.library, nominal(c), Settings{})) {
    if (s.joint == joint) out.push_back(s);
  }
  return out;
}

std::vector<double> torques(const std::vector<TorqueSample>& samples) {
  std::vector<double> out;
  for (const TorqueSample& s : samples) out.push_back(s.missing);
  return out;
}

TEST(MissingTorque, OfAKnownTorqueIsThatTorqueAtItsJoint) {
  for (const double torque : {0.15, -0.15}) {
    for (const auto& [joint, index] : {std::pair{"a", 0}, {"b", 1}}) {
      const EffectEntry push =
          hidden("cable_spring", joint, {{"stiffness", 0.0}, {"torque", torque}});
      EXPECT_NEAR(median(torques(missing_of({push}, index))), torque, 0.03) << joint;
    }
  }
}

TEST(MissingTorque, OfDryFrictionGoesAgainstTheMotion) {
  std::vector<double> forwards, backwards;
  for (const TorqueSample& s :
       missing_of({hidden("coulomb_friction", "b", {{"coulomb", 0.1}})}, 1)) {
    if (std::abs(s.dq) > 0.4) (s.dq > 0 ? forwards : backwards).push_back(s.missing);
  }
  EXPECT_NEAR(median(forwards), -0.1, 0.03);
  EXPECT_NEAR(median(backwards), 0.1, 0.03);
}

TEST(MissingTorque, OfTheTrueModelIsWhatItsDeviationSays) {
  const std::vector<TorqueSample> samples = missing_of({}, 0);
  ASSERT_GT(samples.size(), 50u);
  std::vector<double> in_deviations;
  for (const TorqueSample& s : samples) {
    EXPECT_GT(s.sigma, 0.0);
    in_deviations.push_back(s.missing / s.sigma);
  }
  EXPECT_NEAR(robust_sigma(in_deviations), 1.0, 0.5);
}

/// Two models of a pendulum whose spring of the cable may as well be a heavier arm.
struct TwoNames {
  TwoNames()
      : c(compared(pendulum(kNoisyServo), {hidden("cable_spring", "a", {{"stiffness", 0.1}})},
                   {"cable_spring", "payload"}, 1)) {
    const Surroundings around = make_surroundings(c.problem, c.library, nominal(c));
    selection.final = fitted(around, "cable_spring");
    Accepted a;
    a.candidate = c.of("cable_spring");
    Alternative other;
    other.candidate = c.of("payload");
    other.fit = fitted(around, "payload");
    a.alternatives.push_back(other);
    selection.accepted.push_back(a);
    finding.effect = "cable_spring";
    finding.one_of = {"cable_spring", "payload"};
  }
  FitResult fitted(const Surroundings& around, const std::string& name) const {
    const std::size_t i = c.of(name);
    return fit(around, with(c, i, c.library[i].probes[0]), 7);
  }
  SmallComparison c;
  Selection selection;
  Finding finding;
};

TEST(NextExperiment, NamesASettingUnderWhichTheTwoDiffer) {
  const TwoNames two;
  const auto e = next_experiment(two.c.problem, two.c.library, two.selection, {two.finding});
  ASSERT_TRUE(e.has_value());
  EXPECT_EQ(e->separates, two.finding.one_of);
  EXPECT_GT(e->nats_per_second, 0.0);
  EXPECT_NEAR(e->seconds_to_100_to_1, std::log(100.0) / e->nats_per_second, 1e-9);
  EXPECT_FALSE(e->what.empty());
}

TEST(NextExperiment, IsNoneWhereOneNameIsLeft) {
  TwoNames two;
  two.finding.one_of = {"cable_spring"};
  EXPECT_FALSE(next_experiment(two.c.problem, two.c.library, two.selection, {two.finding}));
  EXPECT_FALSE(next_experiment(two.c.problem, two.c.library, two.selection, {}));
}

TEST(NextExperiment, IsNoneWhereTheTwoAreTheSame) {
  TwoNames two;
  two.selection.accepted[0].alternatives[0].fit = two.selection.final;
  two.selection.accepted[0].alternatives[0].candidate = two.c.of("cable_spring");
  two.finding.one_of = {"cable_spring", "cable_spring"};
  EXPECT_FALSE(next_experiment(two.c.problem, two.c.library, two.selection, {two.finding}));
}

}  // namespace
}  // namespace sanso::diagnose
