// Laws of a robot on skates: Coulomb's way to a standstill, no slip across, energy on slope and
// ramp.
#include <gtest/gtest.h>

#include "tools/plant/mjcf.h"
#include "tools/plant/plant.h"

namespace sanso::plant {
namespace {

constexpr double kWheels = 8;

std::array<double, kNumServos> crouched() {
  std::array<double, kNumServos> q{};
  q[10] = 0.55, q[11] = -0.55, q[12] = -1.06, q[13] = 1.06, q[14] = -0.60, q[15] = 0.60;
  return q;
}

/// Holds the pose by duty = stiffness x error, as servos would.
void run(Plant& plant, double seconds) {
  const auto q = crouched();
  for (int k = 0; k < seconds / kPhysicsStep_s; ++k) {
    for (int i = 0; i < kNumServos; ++i) plant.set_duty(i, 3.223 * (q[i] - plant.link_angle(i)));
    plant.step();
  }
}

World skating(const std::string& name = "nominal") {
  World world = load_world(name);
  world.feet = FeetKind::wheels;
  return world;
}

/// Stands, is pushed along its heading and let go; at rest but for its rolling.
void start_rolling(Plant& plant, double yaw, double force_N) {
  plant.place(crouched(), 0, 0, yaw);
  run(plant, 0.5);
  plant.set_push({force_N * std::cos(yaw), force_N * std::sin(yaw), 0}, {0, 0, 0});
  run(plant, 0.3);
  plant.set_push({0, 0, 0}, {0, 0, 0});
  run(plant, 0.3);
}

double speed(const Plant& plant) { return plant.linear_momentum()[0] / plant.mass_kg(); }

/// What the bearings hold back with, N.
double resistance_N(const World& w) { return kWheels * w.wheels.bearing_Nm / w.wheels.radius_m; }

/// What has to be sped up: mass, and the spin of the wheels seen at their rims.
double rolling_mass_kg(const Plant& plant, const World& w) {
  return plant.mass_kg() + kWheels * 0.5 * w.wheels.wheel_mass_kg;
}

TEST(Skate, WeighsWhatItsFiguresSay) {
  EXPECT_NEAR(Plant(skating()).mass_kg() - Plant(load_world("nominal")).mass_kg(), 0.100, 1e-9);
}

TEST(Skate, StandsOnEightWheels) {
  Plant plant(skating("lab"));
  plant.place(crouched(), 0, 0, 0);
  run(plant, 1.0);
  const auto feet = plant.feet();
  EXPECT_EQ(feet[0].contacts, 4);
  EXPECT_EQ(feet[1].contacts, 4);
  EXPECT_EQ(plant.other_contacts(), 0);
  EXPECT_NEAR(feet[0].force_in_world[2] + feet[1].force_in_world[2], plant.mass_kg() * 9.81, 0.5);
}

TEST(Skate, CoastsAsFarAsCoulombsLawSays) {
  for (const double bearing_Nm : {5e-4, 1.5e-3}) {
    World world = skating();
    world.wheels.bearing_Nm = bearing_Nm;
    Plant plant(world);
    start_rolling(plant, 0, 5.0);
    const double v = speed(plant), from = plant.center_of_mass()[0];
    ASSERT_GT(v, 0.15);
    const double seconds = v * rolling_mass_kg(plant, world) / resistance_N(world);
    const double way = 0.5 * v * seconds;
    run(plant, 1.3 * seconds + 0.3);
    EXPECT_NEAR(plant.center_of_mass()[0] - from, way, 0.03 * way) << bearing_Nm;
    EXPECT_NEAR(speed(plant), 0, 0.02 * v) << bearing_Nm;  // it rocks on its servos' springs
  }
}

TEST(Skate, GoesWhereItPointsAndNotAcross) {
  for (const double yaw : {0.0, 0.5, -1.2}) {
    Plant plant(skating());
    plant.place(crouched(), 0, 0, yaw);
    run(plant, 0.5);
    const Vec3 from = plant.center_of_mass();
    plant.set_push({3, 0, 0}, {0, 0, 0});  // along world x, whatever the heading
    run(plant, 0.5);
    const Vec3 way = plant.center_of_mass() - from;
    const double along = way[0] * std::cos(yaw) + way[1] * std::sin(yaw);
    plant.set_push({0, 0, 0}, {0, 0, 0});
    run(plant, 0.7);  // the springs of servos and contact come back
    const Vec3 whole = plant.center_of_mass() - from;
    const double across = -whole[0] * std::sin(yaw) + whole[1] * std::cos(yaw);
    const double expected =  // of the push, what points along the wheels, less the bearings
        0.5 * (3 * std::cos(yaw) - resistance_N(skating())) / plant.mass_kg() * 0.25;
    EXPECT_NEAR(along, expected, 0.15 * expected + 0.002) << yaw;
    EXPECT_NEAR(across, 0.0, 0.002) << yaw;
  }
}

TEST(Skate, SpeedsUpOnASlopeAsEnergyAllows) {
  const World world = [] {
    World w = skating("nominal+slope3");
    return w;
  }();
  Plant plant(world);
  plant.place(crouched(), 0, 0, 0);
  run(plant, 0.2);
  const double v0 = norm(plant.linear_momentum()) / plant.mass_kg();
  run(plant, 1.0);
  const double slope = 3.0 * kPi / 180;
  const double expected = (plant.mass_kg() * 9.81 * std::sin(slope) - resistance_N(world)) /
                          rolling_mass_kg(plant, world);
  EXPECT_NEAR(norm(plant.linear_momentum()) / plant.mass_kg() - v0, expected, 0.03 * expected);
}

TEST(Skate, LosesOnTheRampWhatTheBearingsTake) {
  for (const std::string ramp : {"ramp", "ramp_high"}) {
    const World world = skating("nominal+" + ramp);
    Plant plant(world);
    plant.place(crouched(), 0.05, 0, 0);
    plant.set_push({4, 0, 0}, {0, 0, 0});
    run(plant, 0.3);
    plant.set_push({0, 0, 0}, {0, 0, 0});
    run(plant, 0.1);
    const double energy = plant.mechanical_energy_J(), from = plant.base().p_world_base[0];
    const double height = plant.base().p_world_base[2];
    while (plant.base().p_world_base[0] < from + 1.3) {
      run(plant, 0.01);
      ASSERT_EQ(plant.other_contacts(), 0) << ramp;
      ASSERT_GT(norm(plant.base().v_base_in_world), 0.1) << ramp;
    }
    const double drop = height - plant.base().p_world_base[2];
    const double lost = energy - plant.mechanical_energy_J();
    EXPECT_NEAR(drop, ramp == "ramp" ? 0.10 : 0.15, 0.004) << ramp;
    const double bearings = resistance_N(world) * 1.31;  // the way along the surface
    const double given = plant.mass_kg() * 9.81 * drop;
    EXPECT_GT(lost, 0.8 * bearings) << ramp;
    EXPECT_LT(lost, bearings + 0.10 * given) << ramp;  // servos and contacts damp the bends
    std::printf("%s: fell by %.2f J, bearings %.2f J, lost %.2f J\n", ramp.c_str(), given, bearings,
                lost);
  }
}

}  // namespace
}  // namespace sanso::plant
