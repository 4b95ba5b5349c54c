// Known settings come back from a recording of a robot that has them; what the data cannot show
// stays as it was.
#include <gtest/gtest.h>

#include <random>

#include "tests/support/small_world.h"
#include "tools/diagnose/run/identify.h"

namespace sanso::diagnose {
namespace {

recording::Recording recorded(const ModelFolder& model, const char* file, double phase,
                              std::uint64_t seed) {
  const Drive drive = test::make_test_drive(model, 8.0, 0.005, [phase](int, double t) {
    return 0.6 * std::sin(4 * t + phase) + 0.4 * std::sin(7.3 * t);
  });
  recording::Recording r = test::record(model, drive, {.file = file, .noise_seed = seed});
  r.condition = file;
  return r;
}

TEST(Identify, FindsTheSettingsOfAServo) {
  const char* base = "actuator = \"dc_servo\"\nposition_noise = 5e-4\n";
  const ModelFolder truth =
      test::pendulum(std::string(base) + "coulomb = 0.15\nviscous = 0.1\narmature = 0.02\n");
  const ModelFolder nominal = test::pendulum(base);
  LoadedRecordings loaded;
  loaded.recordings = {recorded(truth, "a.csv", 0, 11), recorded(truth, "b.csv", 1, 12),
                       recorded(truth, "c.csv", 2, 13)};
  std::vector<GateRecording> views;
  for (const auto& r : loaded.recordings) views.push_back(gate_view(r));
  loaded.gate = inspect(views, gate_joints(nominal));
  ASSERT_FALSE(loaded.gate.refused());
  const Identification found = identify(nominal, loaded, Settings{}, [](const std::string&) {});
  const JointSettings& s = found.model.joints[0];
  EXPECT_NEAR(s.coulomb, 0.15, 0.02);
  EXPECT_NEAR(s.viscous, 0.1, 0.05);
  EXPECT_NEAR(s.armature, 0.02, 0.003);
  EXPECT_NEAR(s.p_gain / nominal.joints[0].p_gain, 1.0, 0.05);
  EXPECT_LT(found.error_left, 0.02);
  for (const IdentifiedParameter& p : found.parameters) {
    EXPECT_FALSE(p.at_bound) << p.effect;
    const double truth_value = p.effect == "coulomb_friction"   ? 0.15
                               : p.effect == "viscous_friction" ? 0.1
                               : p.effect == "rotor_inertia"    ? 0.02
                                                                : p.nominal;
    // beyond the spread, shots start from smoothed motion, which rounds off the kink of every
    // reversal: 3 % of friction
    EXPECT_LT(std::abs(p.value - truth_value), 5 * p.sigma + 0.03 * std::abs(truth_value))
        << p.effect << " = " << p.value << " +- " << p.sigma;
  }
}

}  // namespace
}  // namespace sanso::diagnose
