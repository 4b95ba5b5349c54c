// Laws of the coupled oscillators: fixed lags from any phases, equal to the closed solution of two.
#include "host/motion/make/oscillators.h"

#include <gtest/gtest.h>

#include <cmath>

#include "shared/files/input_error.h"

namespace sanso::motion {
namespace {

constexpr double kPi = 3.14159265358979323846;

RecordRecipe two(double lag_rad, double coupling) {
  RecordRecipe r;
  r.like = "skate_ramp";
  r.coupling = coupling;
  r.oscillators.resize(2);
  r.oscillators[1].lag_rad = lag_rad;
  r.oscillators[0].amplitude_rad[1] = 0.1;
  r.oscillators[1].amplitude_rad[5] = -0.2;
  return r;
}

TEST(Oscillators, SettleAtTheirLagsFromAnyPhases) {
  for (const double first : {-2.5, -1.0, 0.3, 2.9}) {
    Oscillators o(two(0.7, 5.0), {first, 0.0});
    for (int k = 0; k < 500; ++k) o.step(0.01);
    EXPECT_NEAR(std::remainder(o.phase_rad()[1] - o.phase_rad()[0] - 0.7, 2 * kPi), 0.0, 1e-6);
  }
}

TEST(Oscillators, ApproachThemAsTheClosedSolutionSays) {
  // psi' = -2 K sin(psi) for the error psi of two: tan(psi / 2) decays with 2 K
  Oscillators o(two(0.0, 3.0), {0.0, 1.2});
  for (int k = 0; k < 20; ++k) o.step(0.01);
  const double psi = o.phase_rad()[1] - o.phase_rad()[0];
  EXPECT_NEAR(psi, 2.0 * std::atan(std::tan(0.6) * std::exp(-2.0 * 3.0 * 0.2)), 2e-3);
}

TEST(Oscillators, GrowFromThePostureToTheirAmplitudes) {
  Oscillators o(two(kPi, 5.0));
  EXPECT_EQ(o.offset(), model::Input::Zero());
  for (int k = 0; k < 300; ++k) o.step(0.01);
  double largest = 0.0;
  for (int k = 0; k < 100; ++k) {
    o.step(0.01);
    largest = std::max(largest, std::abs(o.offset()[5]));
    // in antiphase with a negative amplitude: both joints move alike
    EXPECT_NEAR(o.offset()[5], 2.0 * o.offset()[1], 1e-6);
  }
  EXPECT_NEAR(largest, 0.2, 1e-3);
}

TEST(RecordRecipe, ReadsItsExampleAndRefusesWhatItDoesNotKnow) {
  const std::string example = kExampleRecordRecipe;
  const RecordRecipe r = parse_record_recipe(example, "example");
  EXPECT_EQ(r.like, "skate_ramp");
  EXPECT_EQ(r.oscillators.size(), 2u);
  EXPECT_NEAR(r.oscillators[1].lag_rad, kPi / 2, 1e-12);
  EXPECT_THROW(parse_record_recipe("like = \"squat\"\n", "none"), files::InputError);
  EXPECT_THROW(parse_record_recipe("tempo = 3\n" + example, "key"), files::InputError);
  const std::string head = "like = \"sway\"\nkind = \"rhythmic\"\n[[oscillator]]\n";
  const std::string joint = "amplitude_deg = { l_knee = 3 }\n";
  EXPECT_NO_THROW(parse_record_recipe(head + "frequency_Hz = 1.25\n" + joint, "whole"));
  EXPECT_THROW(parse_record_recipe(head + "frequency_Hz = 1.3\n" + joint, "part"),
               files::InputError);
  EXPECT_THROW(parse_record_recipe(head + "frequency_Hz = 1\namplitude_deg = { tail = 3 }\n", "j"),
               files::InputError);
}

}  // namespace
}  // namespace sanso::motion
