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
