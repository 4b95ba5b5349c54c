// From a recording to what drives a simulation; noise of the sensors; windows and options.
#include "tools/diagnose/sim/drive.h"

#include <gtest/gtest.h>

#include "shared/files/input_error.h"
#include "tests/support/small_world.h"
#include "tools/diagnose/stats/robust.h"

namespace sanso::diagnose {
namespace {

using namespace test;

recording::Recording columns(const std::vector<std::string>& names, std::size_t rows = 20) {
  recording::Recording r;
  r.file = "folder/swing.csv";
  for (std::size_t k = 0; k < rows; ++k) r.t.push_back(0.01 * static_cast<double>(k));
  for (std::size_t c = 0; c < names.size(); ++c)
    r.set(names[c], std::vector<double>(rows, static_cast<double>(c)));
  return r;
}

TEST(Drive, SortsColumnsByTheModelsJoints) {
  const ModelFolder model = two_links("actuator = \"position_pd\"\nkp = 1\n");
  const Drive drive = make_drive(
      columns({"q:b", "u:b", "q:a", "u:a", "dq:b", "i:a", "pwm:a", "temp:b", "volt"}), model);
  EXPECT_EQ(drive.name, "swing");
  ASSERT_EQ(drive.joints.size(), 2u);
  EXPECT_EQ(drive.joints[0].q[3], 2.0);
  EXPECT_EQ(drive.joints[1].q[3], 0.0);
  EXPECT_EQ(drive.joints[0].command[3], 3.0);
  EXPECT_EQ(drive.joints[1].dq[3], 4.0);
  EXPECT_TRUE(drive.joints[0].dq.empty());
  EXPECT_EQ(drive.joints[0].i[3], 5.0);
  EXPECT_EQ(drive.joints[0].pwm[3], 6.0);
  EXPECT_EQ(drive.joints[1].temp[3], 7.0);
  EXPECT_EQ(drive.volt[3], 8.0);
}

TEST(Drive, ATorqueSourceFollowsTorqueOrForce) {
  const ModelFolder torque = pendulum("actuator = \"torque\"\n");
  EXPECT_EQ(make_drive(columns({"q:a", "tau_cmd:a", "u:a"}), torque).joints[0].command[0], 1.0);
  EXPECT_EQ(make_drive(columns({"q:a", "u:a", "force_cmd:a"}), torque).joints[0].command[0], 2.0);
  EXPECT_THROW(make_drive(columns({"q:a", "u:a"}), torque), files::InputError);
}

TEST(Drive, APassiveJointNeedsNoCommand) {
  EXPECT_TRUE(
      make_drive(columns({"q:a"}), pendulum("actuator = \"passive\"\n")).joints[0].command.empty());
}

TEST(Drive, SaysWhichColumnIsMissingInWhichFile) {
  const ModelFolder model = two_links("actuator = \"position_pd\"\nkp = 1\n");
  for (const auto& [present, missing] :
       {std::pair{std::vector<std::string>{"q:a", "u:a", "u:b"}, "q:b"},
        {{"q:a", "q:b", "u:b"}, "u:a"}}) {
    try {
      make_drive(columns(present), model);
      FAIL() << missing;
    } catch (const files::InputError& e) {
      EXPECT_EQ(e.file, "folder/swing.csv");
      EXPECT_EQ(e.channel, missing);
      EXPECT_FALSE(e.expected.empty());
    }
  }
}

TEST(Drive, RefusesTimeThatStandsAndPositionsThatAreNone) {
  const ModelFolder model = pendulum("actuator = \"passive\"\n");
  recording::Recording still = columns({"q:a"});
  still.t[7] = still.t[6];
  EXPECT_THROW(make_drive(still, model), files::InputError);
  recording::Recording empty = columns({"q:a"});
  std::vector<double> two(20, NAN);
  two[3] = two[9] = 0.1;
  empty.set("q:a", two);
  EXPECT_THROW(make_drive(empty, model), files::InputError);
}

Prediction sine(double amplitude) {
  Prediction p;
  p.rows = 20000;
  for (std::size_t k = 0; k < p.rows; ++k) {
    p.q.push_back(amplitude * std::sin(0.01 * static_cast<double>(k)));
    p.dq.push_back(amplitude * std::cos(0.01 * static_cast<double>(k)));
  }
  return p;
}

SimParams sensor(double noise, double quantum, double jitter) {
  SimParams params = make_params(pendulum("actuator = \"passive\"\n"));
  params.joints[0].nominal.position_noise = noise;
  params.joints[0].nominal.position_quantum = quantum;
  params.joints[0].jitter = jitter;
  return params;
}

std::vector<double> difference(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> out;
  for (std::size_t k = 0; k < a.size(); ++k) out.push_back(a[k] - b[k]);
  return out;
}

TEST(SensorNoise, HasTheDeviationThatTheModelStates) {
  Prediction p = sine(1.0);
  add_sensor_noise(sensor(0.002, 0.0, 0.0), 3, p);
  const std::vector<double> noise = difference(p.q, sine(1.0).q);
  EXPECT_NEAR(standard_deviation(noise), 0.002, 5e-5);
  EXPECT_NEAR(mean(noise), 0.0, 6e-5);
  EXPECT_NEAR(correlation(noise, sine(1.0).dq), 0.0, 0.03);
}

TEST(SensorNoise, RoundsToTheEncodersStep) {
  Prediction p = sine(1.0);
  add_sensor_noise(sensor(0.0, 0.01, 0.0), 3, p);
  for (std::size_t k = 0; k < p.rows; k += 37)
    EXPECT_NEAR(p.q[k] / 0.01, std::round(p.q[k] / 0.01), 1e-9);
  EXPECT_NEAR(standard_deviation(difference(p.q, sine(1.0).q)), 0.01 / std::sqrt(12.0), 2e-4);
}

TEST(SensorNoise, IsTheSameForOneSeedAndAnotherForAnother) {
  Prediction a = sine(1.0), b = sine(1.0), c = sine(1.0);
  add_sensor_noise(sensor(0.01, 0.0, 0.0), 3, a);
  add_sensor_noise(sensor(0.01, 0.0, 0.0), 3, b);
  add_sensor_noise(sensor(0.01, 0.0, 0.0), 4, c);
  EXPECT_EQ(a.q, b.q);
  EXPECT_NE(a.q, c.q);
}

TEST(ReadingJitter, IsSpeedTimesTimeAndNothingAtStandstill) {
  Prediction p = sine(1.0);
  add_reading_jitter(sensor(0.0, 0.0, 0.003), 5, p);
  const std::vector<double> noise = difference(p.q, sine(1.0).q);
  EXPECT_NEAR(standard_deviation(noise), 0.003 / std::sqrt(2.0), 5e-5);
  Prediction rest = sine(0.0);
  add_reading_jitter(sensor(0.0, 0.0, 0.003), 5, rest);
  EXPECT_EQ(rest.q, sine(0.0).q);
}

TEST(VelocityFilter, DelaysTheVelocityChannelAndNothingElse) {
  const ModelFolder model = pendulum("actuator = \"position_pd\"\nkp = 5\nkd = 0.2\n");
  const Drive drive =
      make_test_drive(model, 3.0, 0.01, [](int, double t) { return 0.5 * std::sin(3 * t); });
  SimParams params = make_params(model);
  const std::vector windows{whole_from_rest(drive)};
  const Prediction plain = simulate(params, drive, windows).front();
  params.joints[0].velocity_filter = 0.03;
  const Prediction filtered = simulate(params, drive, windows).front();
  EXPECT_EQ(plain.q, filtered.q);
  for (std::size_t r = 100; r < plain.rows; ++r)
    EXPECT_NEAR(filtered.dq[r], plain.dq[r - 3], 0.06) << r;
}

TEST(Payload, ThatComesLaterWeighsFromThenOn) {
  const ModelFolder model = pendulum("actuator = \"position_pd\"\nkp = 40\nkd = 2\n");
  const Drive drive = make_test_drive(model, 4.0, 0.01, [](int, double) { return 1.57; });
  SimParams params = make_params(model);
  params.late_payloads.push_back({0, {0.4, {0, 0, -0.1}, {}}, 2.0});
  const Prediction p = simulate(params, drive, std::vector{whole(drive, {1.57}, {0})}).front();
  const double weight = 9.81 * 0.1;
  EXPECT_NEAR(p.tau[199], 0.5 * weight * std::sin(p.q[199]), 1e-2);
  EXPECT_NEAR(p.tau.back(), 0.9 * weight * std::sin(p.q.back()), 1e-3);
}

TEST(WorldForce, ActsBetweenItsTwoInstantsOnly) {
  ModelFolder model = pendulum("actuator = \"passive\"\n");
  model.gravity = {0, 0, 0};
  const Drive drive = make_test_drive(model, 1.0, 0.01, [](int, double) { return 0.0; });
  SimParams params = make_params(model);
  params.forces.push_back({0, {-0.2, 0, 0}, 0.3, 0.4});
  const Prediction p = simulate(params, drive, std::vector{whole_from_rest(drive)}).front();
  EXPECT_EQ(p.dq[30], 0.0);
  // 0.2 N at 0.1 m for 0.1 s: 0.002 N m s over 0.005 kg m^2
  EXPECT_NEAR(p.dq.back(), 0.2 * 0.1 * 0.1 / (0.005 + 1e-6), 0.01);
  EXPECT_NEAR(p.dq[45], p.dq.back(), 1e-9);
}

TEST(Supply, OneThatSagsWeakensEveryJointThatDrawsFromIt) {
  const ModelFolder model = two_links("actuator = \"dc_servo\"\narmature = 0.01\n");
  const Drive drive =
      make_test_drive(model, 1.0, 0.01, [](int j, double t) { return j == 0 ? 1.0 : 0.1 * t; });
  SimParams params = make_params(model);
  const std::vector windows{whole_from_rest(drive)};
  const Prediction strong = simulate(params, drive, windows).front();
  params.supply_resistance = 1.0;
  const Prediction weak = simulate(params, drive, windows).front();
  EXPECT_LT(*std::min_element(weak.volt.begin() + 5, weak.volt.end()), 11.5);
  EXPECT_EQ(*std::min_element(strong.volt.begin(), strong.volt.end()), 12.0);
  EXPECT_LT(weak.of(weak.q, 0)[20], strong.of(strong.q, 0)[20]);
}

TEST(Divergence, IsHeldAtTheLastFiniteValue) {
  const ModelFolder model = pendulum("actuator = \"torque\"\ntorque_limit = 0\n");
  const Drive drive = make_test_drive(model, 1.0, 0.01, [](int, double) { return 1e6; });
  const Prediction p =
      simulate(make_params(model), drive, std::vector{whole_from_rest(drive)}).front();
  for (const double q : p.q) ASSERT_TRUE(std::isfinite(q));
  EXPECT_EQ(p.q[p.rows - 1], p.q[p.rows - 2]);
}

}  // namespace
}  // namespace sanso::diagnose
