// Worlds by seed: one draw of everything that a lab's robot may differ in. Ranges:
// docs/howto/emulator.md.
#include <fmt/format.h>

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

}  // namespace sanso::plant
