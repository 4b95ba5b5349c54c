// That the emulated robot and the planner's model, each with code of its own, stand on the same
// ground: heights, normals and curvature of every profile, measured on what MuJoCo collides with.
#include "tools/plant/ground_profile.h"

#include <gtest/gtest.h>

#include <cmath>

#include "shared/files/input_error.h"
#include "shared/grounds/ground_file.h"
#include "tools/plant/plant.h"
#include "tools/plant/world_error.h"

namespace sanso {
namespace {

constexpr double kTenth_mm = 1e-4;
constexpr double kWheelbase_m = 0.085;
// a chord of a centimetre on an arc of 0.8 m leans by up to half its turn
constexpr double kChordLean_rad = 0.5 * 0.01 / 0.8;

double sagitta(double left, double middle, double right) { return middle - 0.5 * (left + right); }

/// Away from vertical steps, where a hair's breadth decides.
bool near_step(const model::Ground& g, double x) {
  for (int i = 0; i < g.num_segments; ++i) {
    const double at = g.segment[i].x_start;
    const bool step =
        std::abs(model::ground_height(g, at + 1e-9) - model::ground_height(g, at - 1e-9)) > 1e-6;
    if (step && std::abs(x - at) < 1e-3) return true;
  }
  return false;
}

class Profile : public testing::TestWithParam<std::string> {};

TEST_P(Profile, IsTheSameForPlantAndModel) {
  plant::World world = plant::load_world("nominal");
  world.ground.profile = GetParam();
  const plant::Plant plant(world);
  const model::Ground g = grounds::load_ground(GetParam());
  const auto height = [&](double x) { return plant.ground(x, 0.1).z; };
  int compared = 0;
  for (double x = -1.5; x < 4.5; x += 0.00731) {
    if (near_step(g, x)) continue;
    const plant::Plant::Surface surface = plant.ground(x, -0.2);
    ASSERT_NEAR(surface.z, model::ground_height(g, x), kTenth_mm) << "x " << x;
    const double lean = std::atan2(surface.normal[0], surface.normal[2]);
    ASSERT_NEAR(lean, -std::atan(model::ground_slope(g, x)), kChordLean_rad + 1e-6) << "x " << x;
    if (near_step(g, x - 0.5 * kWheelbase_m) || near_step(g, x + 0.5 * kWheelbase_m)) continue;
    const double left = x - 0.5 * kWheelbase_m, right = x + 0.5 * kWheelbase_m;
    ASSERT_NEAR(sagitta(height(left), height(x), height(right)),
                sagitta(model::ground_height(g, left), model::ground_height(g, x),
                        model::ground_height(g, right)),
                kTenth_mm)
        << "x " << x;
    ++compared;
  }
  EXPECT_GT(compared, 500);
}

INSTANTIATE_TEST_SUITE_P(All, Profile,
                         testing::Values("slope3", "ramp", "ramp_high", "jump_ramp", "plates",
                                         "stairs"));

/// 1/m at x, positive where the model's ground turns upwards.
double curvature(const model::Ground& ground, double x) {
  int at = 0;
  while (at + 1 < ground.num_segments && ground.segment[at + 1].x_start <= x) ++at;
  return ground.segment[at].curvature;
}

TEST(Profile, TheRampIsWhatItsFileSays) {
  for (const auto& [name, height] : {std::pair{"ramp", 0.10}, std::pair{"ramp_high", 0.15}}) {
    const model::Ground g = grounds::load_ground(name);
    double steepest = 0.0, sharpest = 0.0, flattest = 0.0;
    for (double x = -1.0; x < 3.0; x += 1e-3) {
      steepest = std::min(steepest, model::ground_slope(g, x));
      sharpest = std::min(sharpest, curvature(g, x));
      flattest = std::max(flattest, curvature(g, x));
    }
    EXPECT_NEAR(std::atan(steepest), -12.0 * M_PI / 180.0, 1e-4) << name;
    EXPECT_NEAR(sharpest, -1.0 / 0.8, 1e-12) << name;
    EXPECT_NEAR(flattest, 1.0, 1e-12) << name;
    EXPECT_NEAR(model::ground_height(g, 3.0), -height, 1e-6) << name;
  }
}

TEST(Profile, TheKickerEndsStraightInADrop) {
  const model::Ground g = grounds::load_ground("jump_ramp");
  double lip = 0.0;
  for (double x = 0.5; x < 3.0; x += 1e-4)
    if (model::ground_height(g, x) - model::ground_height(g, x + 1e-4) > 0.01) lip = x;
  ASSERT_GT(lip, 0.0);
  EXPECT_NEAR(model::ground_height(g, lip) - model::ground_height(g, lip + 1e-3), 0.025, 1e-4);
  for (double back = 1e-3; back < 0.0885; back += 0.01) {  // 90 mm along the slope
    EXPECT_NEAR(std::atan(model::ground_slope(g, lip - back)), 10.0 * M_PI / 180.0, 1e-4);
    EXPECT_EQ(curvature(g, lip - back), 0.0) << back;
  }
}

TEST(Profile, PatchesChangeFrictionWhereTheyLie) {
  const plant::GroundProfile p = plant::parse_profile(
      "format = 1\n[[point]]\nx_m = -1\nz_m = 0\n[[point]]\nx_m = 2\nz_m = 0\n"
      "[[patch]]\nfrom_x_m = 0.25\nto_x_m = 0.5\nfriction_factor = 0.5\n",
      "test");
  double patch = 0.0, end = -1e9;
  for (const plant::Facet& f : p.facets) {
    if (f.friction_factor == 0.5) patch += f.x1 - f.x0;
    if (end > -1e8) {
      EXPECT_NEAR(f.x0, end, 1e-12) << "no gap between facets";
    }
    end = f.x1;
  }
  EXPECT_NEAR(patch, 0.25, 1e-12);
}

/// What both readers must refuse, and the line that they must name.
TEST(Profile, BothReadersRefuseWhatIsNoGround) {
  const std::string start = "format = 1\n[[point]]\nx_m = -1\nz_m = 0\n";
  const std::pair<const char*, const char*> bad[] = {
      {"[[point]]\nx_m = -2\nz_m = 0\n", "out of order"},
      {"[[point]]\nx_m = 0.5\nz_m = 2\n", "too steep"},
      {"[[point]]\nx_m = 1\nz_m = 0\nradius_m = 50\n[[point]]\nx_m = 2\nz_m = -0.5\n",
       "does not fit"},
      {"[[point]]\nx_m = 1\nz_m = 0.2\n", "not level"},
      {"[[point]]\nx_m = 1\nz_m = 0\nradius = 1\n", "unknown key"},
      {"", "too few points"}};
  for (const auto& [points, defect] : bad) {
    std::string of_plant, of_model;
    try {
      plant::parse_profile(start + points, "bad.toml");
    } catch (const plant::WorldError& error) {
      of_plant = error.what();
    }
    try {
      grounds::parse_ground(start + points, "bad.toml");
    } catch (const files::InputError& error) {
      of_model = error.what();
    }
    for (const std::string& said : {of_plant, of_model}) {
      EXPECT_NE(said.find("bad.toml"), std::string::npos) << points;
      EXPECT_NE(said.find(defect), std::string::npos) << defect << " not in: " << said;
    }
  }
}

TEST(Profile, TheRobotStandsWhereItIsPut) {
  for (const std::string name : {"lab+ramp", "lab+slope3", "lab+stairs"}) {
    plant::Plant plant(plant::load_world(name));
    std::array<double, plant::kNumServos> q{};
    plant.place(q, 0, 0, 0);
    plant.hold(true);
    for (int i = 0; i < 20; ++i) plant.step();
    const auto feet = plant.feet();
    EXPECT_GT(feet[0].contacts, 2) << name;
    EXPECT_GT(feet[1].contacts, 2) << name;
    EXPECT_EQ(plant.other_contacts(), 0) << name;
  }
}

TEST(World, APlusPutsItOnAnotherGround) {
  const plant::World w = plant::load_world("hard+ramp+wheels");
  EXPECT_EQ(w.ground.profile, "ramp");
  EXPECT_EQ(w.feet, plant::FeetKind::wheels);
  EXPECT_EQ(w.servo.p_divisor, plant::load_world("hard").servo.p_divisor);
  EXPECT_THROW(plant::load_world("hard+nowhere"), plant::WorldError);
}

}  // namespace
}  // namespace sanso
