// Worlds by seed: one draw of everything that a lab's robot may differ in. Ranges:
// docs/howto/emulator.md.
#include <fmt/format.h>

#include <cmath>

#include "tools/plant/random.h"
#include "tools/plant/world.h"

namespace sanso::plant {

World draw_world(std::uint64_t seed) {
  Random random(seed ^ 0x5A4E50u);
  World w;
  w.name = fmt::format("seed:{}", seed);
  w.body.torso_extra_mass_kg = random.uniform(0.0, 0.4);
  w.body.torso_com_offset_m = {random.uniform(-0.030, 0.030), random.uniform(-0.008, 0.008),
                               random.uniform(-0.015, 0.015)};
  w.body.leg_mass_scale = random.uniform(0.95, 1.08);
  w.servo.motor_inertia_kgm2 = random.uniform(0.012, 0.042);
  w.servo.coulomb_Nm = random.uniform(0.03, 0.15);
  w.servo.stribeck_extra_Nm = random.uniform(0.0, 0.06);
  w.servo.load_friction = random.uniform(0.05, 0.22);
  w.servo.viscous_Nms_rad = random.uniform(0.0, 0.2);
  w.servo.backlash_rad = random.uniform(0.0, 0.0075);
  w.servo.p_divisor = random.chance(0.5) ? 128.0 : 256.0;
  // up to 30 ms in all, shared between the two ways
  const double delay = random.uniform(0.0, 0.030);
  w.servo.command_delay_s = delay * random.uniform(0.3, 0.7);
  w.servo.sensor_delay_s = delay - w.servo.command_delay_s;
  w.servo.spread = random.uniform(0.0, 0.08);
  w.servo.spread_seed = seed;
  w.supply.voltage_V = random.uniform(11.4, 12.6);
  w.supply.internal_ohm = random.uniform(0.0, 0.2);
  w.ground.friction = random.uniform(0.4, 1.0);
  for (double& bias : w.imu.accel_bias_m_s2) bias = 0.06 * random.normal();
  for (double& bias : w.imu.gyro_bias_rad_s) bias = 0.002 * random.normal();
  w.imu.orientation_bias_rad = {0.005 * random.normal(), 0.005 * random.normal(), 0.0};
  return w;
}

namespace {

void draw_floor_and_sensors(Random& random, World& w) {
  constexpr double kDegree = kPi / 180.0;
  w.ground.friction = random.uniform(0.4, 1.0);
  w.ground.tilt_roll_rad = kDegree * random.uniform(-1.0, 1.0);
  w.ground.tilt_pitch_rad = kDegree * random.uniform(-1.0, 1.0);
  w.ground.plates = random.chance(0.5) ? 40 : 0;
  w.ground.contact_time_s = random.uniform(0.004, 0.012);
  for (double& bias : w.imu.accel_bias_m_s2) bias = 0.06 * random.normal();
  for (double& bias : w.imu.gyro_bias_rad_s) bias = 0.002 * random.normal();
  w.imu.orientation_bias_rad = {0.005 * random.normal(), 0.005 * random.normal(), 0.0};
  w.imu.yaw_drift_rad_s = 0.0005 * random.normal();
  w.imu.gravity_filter_s = random.uniform(3.0, 10.0);
  w.pose.delay_s = random.uniform(0.005, 0.020);
  w.pose.drift_m = random.uniform(0.0, 0.002);
  w.pose.dropouts_per_s = random.uniform(0.0, 0.2);
}

}  // namespace

World draw_honest_world(std::uint64_t seed) {
  Random random(seed ^ 0x484F4E45u);
  const auto sign = [&random] { return random.chance(0.5) ? 1.0 : -1.0; };
  World w;
  w.name = fmt::format("honest:{}", seed);
  w.body.self_collision = true;
  w.body.torso_extra_mass_kg = random.uniform(0.0, 0.4);
  w.body.torso_com_offset_m = {sign() * random.uniform(0.008, 0.025), random.uniform(-0.008, 0.008),
                               random.uniform(-0.015, 0.015)};
  w.body.leg_mass_scale = random.uniform(0.95, 1.08);
  w.servo.motor_inertia_kgm2 = random.uniform(0.012, 0.042);
  // stiffer than the data sheet by up to 1.25, or softer down to a half
  const bool stiffer = random.chance(0.5);
  const double share = random.uniform(0.2, 1.0);
  w.servo.p_divisor = 128.0 * std::exp2(stiffer ? -0.32 * share : share);
  w.servo.gain_spread = 0.05;
  w.servo.left_gain_scale = 1.0 + sign() * random.uniform(0.0, 0.08);
  w.servo.zero_offset_rad = 0.7 * kPi / 180.0;
  w.servo.gear_stiffness_Nm_rad = random.uniform(150.0, 1500.0);  // the horn gives
  const bool rough = random.chance(0.5);
  w.servo.coulomb_Nm = rough ? random.uniform(0.09, 0.15) : random.uniform(0.02, 0.06);
  w.servo.stribeck_extra_Nm = random.uniform(0.0, 0.06);
  w.servo.load_friction = rough ? random.uniform(0.14, 0.22) : random.uniform(0.03, 0.10);
  w.servo.viscous_Nms_rad = random.uniform(0.0, 0.2);
  w.servo.backlash_rad = random.uniform(0.0, 0.0075);
  const double delay =
      random.chance(0.5) ? random.uniform(0.016, 0.030) : random.uniform(0.0, 0.008);
  w.servo.command_delay_s = delay * random.uniform(0.3, 0.7);
  w.servo.sensor_delay_s = delay - w.servo.command_delay_s;
  w.servo.spread = random.uniform(0.0, 0.08);
  w.servo.spread_seed = seed;
  w.supply.voltage_V = random.uniform(11.4, 12.6);
  w.supply.internal_ohm = random.uniform(0.0, 0.2);
  draw_floor_and_sensors(random, w);
  return w;
}

namespace {

/// Moves a drawn figure away from the maker's, which it was drawn around.
class Widening {
 public:
  explicit Widening(double width) : width_(width) {}
  void difference(double& value, double maker) const { value = maker + width_ * (value - maker); }
  void ratio(double& value, double maker) const { value = maker * std::pow(value / maker, width_); }
  void inverse(double& value, double maker) const {
    value = 1.0 / (1.0 / maker + width_ * (1.0 / value - 1.0 / maker));
  }
  void size(double& value) const { value *= width_; }
  void size(Vec3& value) const {
    for (double& entry : value) size(entry);
  }

 private:
  double width_;
};

void widen_servo(const Widening& widen, ServoParameters& s) {
  const ServoParameters maker;
  widen.ratio(s.motor_inertia_kgm2, maker.motor_inertia_kgm2);
  widen.ratio(s.p_divisor, maker.p_divisor);
  widen.inverse(s.gear_stiffness_Nm_rad, maker.gear_stiffness_Nm_rad);
  widen.difference(s.left_gain_scale, maker.left_gain_scale);
  for (double* figure :
       {&s.gain_spread, &s.zero_offset_rad, &s.coulomb_Nm, &s.stribeck_extra_Nm, &s.load_friction,
        &s.viscous_Nms_rad, &s.backlash_rad, &s.spread, &s.command_delay_s, &s.sensor_delay_s})
    widen.size(*figure);
}

}  // namespace

World widened(World w, double width) {
  if (width == 1.0) return w;
  const World maker;
  const Widening widen(width);
  widen.size(w.body.torso_extra_mass_kg);
  widen.size(w.body.torso_com_offset_m);
  widen.difference(w.body.leg_mass_scale, maker.body.leg_mass_scale);
  widen_servo(widen, w.servo);
  widen.difference(w.supply.voltage_V, maker.supply.voltage_V);
  widen.size(w.supply.internal_ohm);
  widen.ratio(w.ground.friction, maker.ground.friction);
  widen.size(w.ground.tilt_roll_rad);
  widen.size(w.ground.tilt_pitch_rad);
  widen.size(w.ground.plate_height_m);
  widen.difference(w.ground.contact_time_s, maker.ground.contact_time_s);
  widen.size(w.imu.accel_bias_m_s2);
  widen.size(w.imu.gyro_bias_rad_s);
  widen.size(w.imu.orientation_bias_rad);
  widen.size(w.imu.yaw_drift_rad_s);
  w.imu.gravity_filter_s /= width;
  widen.difference(w.pose.delay_s, maker.pose.delay_s);
  widen.size(w.pose.drift_m);
  widen.size(w.pose.dropouts_per_s);
  w.name += fmt::format("x{}", width);
  return w;
}

}  // namespace sanso::plant
