// World files: names, seeds, strict keys.
#include "tools/plant/world.h"

#include <gtest/gtest.h>

#include "tools/plant/plant.h"
#include "tools/plant/world_error.h"

namespace sanso::plant {
namespace {

std::string refusal(const std::string& text) {
  try {
    parse_world(text, "test.toml");
  } catch (const WorldError& error) {
    return error.what();
  }
  return "";
}

TEST(World, NamedWorldsDiffer) {
  EXPECT_EQ(load_world("nominal").servo.coulomb_Nm, 0.0);
  EXPECT_EQ(load_world("lab").name, "lab");
  EXPECT_GT(load_world("hard").servo.p_divisor, load_world("lab").servo.p_divisor);
  EXPECT_GT(load_world("worst").servo.p_divisor, load_world("back").servo.p_divisor);
}

/// Softer servos lean backwards; a mass in front would cancel that and hide what learning is for.
TEST(World, InBackAndWorstNothingCancelsTheLeanOfSofterServos) {
  for (const char* name : {"back", "worst"}) {
    EXPECT_LT(load_world(name).body.torso_com_offset_m[0], 0.0) << name;
    EXPECT_GT(load_world(name).servo.p_divisor, load_world("lab").servo.p_divisor) << name;
  }
}

TEST(World, SameSeedSameWorldOtherSeedOtherWorld) {
  EXPECT_EQ(load_world("seed:5").ground.friction, load_world("seed:5").ground.friction);
  EXPECT_NE(load_world("seed:5").ground.friction, load_world("seed:6").ground.friction);
}

TEST(World, DrawnWorldsStayInTheirRangesAndCompile) {
  for (int seed = 0; seed < 200; ++seed) {
    const World w = draw_world(seed);
    EXPECT_LE(w.body.torso_extra_mass_kg, 0.4);
    EXPECT_LE(std::abs(w.body.torso_com_offset_m[0]), 0.030);
    EXPECT_LE(w.servo.command_delay_s + w.servo.sensor_delay_s, 0.030);
    EXPECT_TRUE(w.servo.p_divisor == 128.0 || w.servo.p_divisor == 256.0);
    EXPECT_GE(w.ground.friction, 0.4);
    EXPECT_LE(w.ground.friction, 1.0);
    if (seed % 20 == 0) {
      EXPECT_NO_THROW(Plant{w}) << seed;
    }
  }
}

TEST(World, AWrittenWorldIsReadBackToTheLastBit) {
  for (const char* name : {"nominal", "lab", "worst", "tired", "seed:3", "honest:1", "honest:2"}) {
    const World w = load_world(name);
    const World again = parse_world(to_toml(w), name);
    EXPECT_EQ(to_toml(again), to_toml(w)) << name;
    EXPECT_EQ(again.servo.p_divisor, w.servo.p_divisor) << name;
    EXPECT_EQ(again.body.self_collision, w.body.self_collision) << name;
    EXPECT_EQ(again.imu.orientation_bias_rad, w.imu.orientation_bias_rad) << name;
  }
}

TEST(World, AWiderDrawIsTheSameRobotFurtherFromTheMakers) {
  const World maker, drawn = load_world("honest:7"), wide = load_world("honest:7x2");
  EXPECT_EQ(to_toml(load_world("honest:7x1")), to_toml(drawn));
  EXPECT_EQ(wide.name, "honest:7x2");
  EXPECT_DOUBLE_EQ(wide.body.torso_com_offset_m[0], 2.0 * drawn.body.torso_com_offset_m[0]);
  EXPECT_DOUBLE_EQ(wide.servo.load_friction, 2.0 * drawn.servo.load_friction);
  EXPECT_NEAR(wide.supply.voltage_V - maker.supply.voltage_V,
              2.0 * (drawn.supply.voltage_V - maker.supply.voltage_V), 1e-12);
  EXPECT_NEAR(wide.servo.p_divisor * maker.servo.p_divisor,
              drawn.servo.p_divisor * drawn.servo.p_divisor, 1e-9);
  const World narrow = load_world("honest:7x0.1");
  EXPECT_NEAR(1 / narrow.servo.gear_stiffness_Nm_rad - 1 / maker.servo.gear_stiffness_Nm_rad,
              0.1 * (1 / drawn.servo.gear_stiffness_Nm_rad - 1 / maker.servo.gear_stiffness_Nm_rad),
              1e-12);
  EXPECT_DOUBLE_EQ(narrow.imu.gravity_filter_s, 10.0 * drawn.imu.gravity_filter_s);
}

TEST(World, TheWidestAndNarrowestDrawsCanBeWrittenReadAndSimulated) {
  for (int k = 0; k < 800; ++k) {
    const int seed = k / 4;
    const std::string name = std::string(k % 2 == 0 ? "honest:" : "seed:") + std::to_string(seed) +
                             (k % 4 < 2 ? "x2.5" : "x0.1");
    const World w = load_world(name);
    World again;
    ASSERT_NO_THROW(again = parse_world(to_toml(w), name)) << name;
    EXPECT_EQ(to_toml(again), to_toml(w)) << name;
    if (seed % 20 == 0) {
      EXPECT_NO_THROW(Plant{w}) << name;
    }
  }
  for (const char* name : {"honest:7x", "honest:7x0", "honest:7x-1", "honest:7x2.6", "honest:7xnan",
                           "honest:x2", "honest:7x1x1", "honest:7x1 "})
    EXPECT_THROW(load_world(name), WorldError) << name;
}

/// A draw in which one sign follows another hides what learning is for. 400 draws: a share of 1/4
/// has a standard deviation of 0.022.
TEST(World, SignsOfHonestWorldsAreIndependent) {
  constexpr int kDraws = 400, kEffects = 4;
  int alike[kEffects][kEffects] = {}, positive[kEffects] = {};
  for (int seed = 0; seed < kDraws; ++seed) {
    const World w = draw_honest_world(static_cast<std::uint64_t>(seed));
    const bool high[kEffects] = {w.body.torso_com_offset_m[0] > 0.0, w.servo.p_divisor > 128.0,
                                 w.servo.coulomb_Nm > 0.075,
                                 w.servo.command_delay_s + w.servo.sensor_delay_s > 0.012};
    for (int a = 0; a < kEffects; ++a) {
      positive[a] += high[a];
      for (int b = 0; b < a; ++b) alike[a][b] += high[a] == high[b];
    }
  }
  constexpr double kTolerance = 4 * 0.025 * kDraws;  // four deviations of a share of a half
  for (int a = 0; a < kEffects; ++a) {
    EXPECT_NEAR(positive[a], 0.5 * kDraws, kTolerance) << a;
    for (int b = 0; b < a; ++b)
      EXPECT_NEAR(alike[a][b], 0.5 * kDraws, kTolerance) << a << " and " << b;
  }
}

TEST(World, HonestWorldsStandOnTheirFeet) {
  for (const char* name : {"honest:1", "honest:2", "honest:3", "honest:4"}) {
    const World w = load_world(name);
    Plant plant(w);
    plant.hold(true);
    for (int i = 0; i < 200; ++i) plant.step();
    EXPECT_EQ(plant.other_contacts(), 0) << name << ": its limbs are in each other";
    EXPECT_GT(plant.feet()[0].contacts + plant.feet()[1].contacts, 0) << name;
  }
}

TEST(World, LegsMeetWhereTheWorldSaysSoAndPassElsewhere) {
  for (const bool meet : {false, true}) {
    World w;
    w.body.self_collision = meet;
    Plant plant(w);
    std::array<double, kNumServos> q{};
    q[8] = -0.35;  // r_hip_roll, inwards as l_hip_roll
    q[9] = 0.35;
    plant.place(q, 0, 0, 0);
    const int inwards = plant.other_contacts();
    q[8] = 0.35;
    q[9] = -0.35;
    plant.place(q, 0, 0, 0);
    const int outwards = plant.other_contacts();
    EXPECT_EQ(std::max(inwards, outwards) > 0, meet);
    EXPECT_EQ(std::min(inwards, outwards), 0) << "legs apart touch nothing";
  }
}

TEST(World, UnknownKeysAndWrongValuesAreRefusedWithTheirLine) {
  EXPECT_NE(
      refusal("[servo]\ncolumb_Nm = 0.1\n").find("test.toml:2: unknown key in 'servo.columb_Nm'"),
      std::string::npos)
      << refusal("[servo]\ncolumb_Nm = 0.1\n");
  EXPECT_NE(refusal("[servo]\n\ncoulomb_Nm = -1\n")
                .find("test.toml:3: out of range in 'servo.coulomb_Nm': found '-1.0'"),
            std::string::npos)
      << refusal("[servo]\n\ncoulomb_Nm = -1\n");
  EXPECT_NE(refusal("feet = \"hooves\"").find("\"soles\" or \"wheels\""), std::string::npos);
  EXPECT_NE(refusal("x = [").find("test.toml:1"), std::string::npos);
  EXPECT_THROW(load_world("seed:x"), WorldError);
  EXPECT_THROW(load_world("/nonexistent.toml"), WorldError);
}

}  // namespace
}  // namespace sanso::plant
