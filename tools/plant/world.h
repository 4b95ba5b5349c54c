// A world: everything about the emulated robot and its surroundings that the controller does not
// know. Read from a TOML file (worlds/*.toml), or drawn by a seed. Every figure that is zero in a
// world costs that world no random number: what is added here changes no world that lacks it.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "tools/plant/vec.h"

namespace sanso::plant {

/// Body: offsets from the maker's figures (data/op3_*.csv).
struct BodyParameters {
  // cables, covers, skin: the maker's list is 0.35 kg short of the scales
  double torso_extra_mass_kg = 0.0;
  Vec3 torso_com_offset_m{0, 0, 0};  // shift of the torso's centre of mass, body axes
  double leg_mass_scale = 1.0;
  bool self_collision = false;  // legs and feet meet those of the other side
  // in the air on a stand: the trunk is fixed, links move each by itself, nothing touches. Costs a
  // hundredth of the physics; for programs and long runs, not for motion
  bool hung = false;
};

/// Motor, gear train and position loop: one set for all servos, with a spread between them.
struct ServoParameters {
  double resistance_ohm = 5.217;          // 12 V / 2.3 A at stall (data sheet)
  double torque_constant_Nm_A = 1.783;    // at the output: 4.1 N m / 2.3 A (data sheet)
  double back_emf_V_s = 2.491;            // at the output: 12 V / 4.82 rad/s (data sheet)
  double motor_inertia_kgm2 = 0.027;      // rotor, seen at the output
  double output_inertia_kgm2 = 0.003;     // last gear and horn, on the link side of the play
  double gear_stiffness_Nm_rad = 1500.0;  // between motor and link
  double gear_damping_Nms_rad = 1.2;
  double backlash_rad = 0.0;  // full width of the play between motor and link
  double coulomb_Nm = 0.0;
  double stribeck_extra_Nm = 0.0;  // static friction above Coulomb
  double stribeck_velocity_rad_s = 0.1;
  double load_friction = 0.0;  // friction per transmitted torque
  double viscous_Nms_rad = 0.0;
  // relative standard deviation between servos, on friction, backlash, torque
  double spread = 0.0;
  std::uint64_t spread_seed = 1;  // draws the spread; one robot keeps it for life
  // standard deviation of a horn's zero: what a servo reports is its joint's angle plus this
  double zero_offset_rad = 0.0;
  double gain_spread = 0.0;      // of the position loop's gain, relative standard deviation
  double left_gain_scale = 1.0;  // of the position loop's gain in the left limbs
  // PWM counts per position count = P gain / divisor (undisclosed: 128 or 256)
  double p_divisor = 128.0;
  double loop_period_s = 0.001;  // of the position loop
  double command_delay_s = 0.0;  // from the last byte of a goal to the loop using it
  // age of position, velocity, current when they reach the registers
  double sensor_delay_s = 0.0;
  double velocity_filter_s = 0.01;  // time constant of Present Velocity
  // relative rise of the winding's resistance per kelvin above 25 degrees (copper: 0.0039); 0: heat
  // changes nothing
  double copper_per_K = 0.0;
};

struct SupplyParameters {
  double voltage_V = 12.0;    // open circuit
  double internal_ohm = 0.0;  // battery and cables: sag per ampere
  double charge_Ah = 0.0;     // of a full battery; 0: it never empties
  double empty_V = 9.9;       // open circuit, without any charge; in between on a straight line
};

/// What a robot keeps from one trial to the next.
struct Condition {
  std::array<double, 20> temperature_C{};  // of the servos, index = servo id - 1
  double used_Ah = 0.0;                    // of the battery's charge
};

struct GroundParameters {
  // "plane", a profile of shared/grounds by name, or the path of a profile file
  std::string profile = "plane";
  double friction = 0.8;
  // plane: turned about x and y, rad
  double tilt_roll_rad = 0.0, tilt_pitch_rad = 0.0;
  // plane: so many plates of 0.1 m x 0.1 m lie around, none where the robot starts
  std::uint64_t plates = 0;
  double plate_height_m = 0.004;
  double contact_time_s = 0.004;  // of the contact's spring; rubber soles have a longer one
};

/// Feet: soles, or wheels for the skating motions.
enum class FeetKind : std::uint8_t { soles, wheels };

/// A skate: four passive wheels on two axles under a foot. Chosen; no public figures.
struct WheelParameters {
  double radius_m = 0.012;
  double wheelbase_m = 0.085;
  double track_m = 0.055;
  double skate_mass_kg = 0.050;  // with its wheels
  double wheel_mass_kg = 0.006;
  // Coulomb friction of one bearing: eight of them hold a robot of 3.25 kg back like a rolling
  // friction of 0.0105
  double bearing_Nm = 5e-4;
};

struct ImuParameters {
  double accel_noise_m_s2 = 0.05;    // standard deviation of one sample
  double gyro_noise_rad_s = 0.0035;  // 0.2 deg/s
  double orientation_noise_rad = 0.001;
  Vec3 accel_bias_m_s2{0, 0, 0};
  Vec3 gyro_bias_rad_s{0, 0, 0};
  Vec3 orientation_bias_rad{0, 0, 0};  // mounting error, roll pitch yaw
  double yaw_drift_rad_s = 0.0;
  // the filter takes the felt force for gravity with this time constant; 0 = never
  double gravity_filter_s = 0.0;
};

struct PoseParameters {
  double period_s = 0.005;  // tracking camera: 200 Hz
  double delay_s = 0.008;
  double position_noise_m = 0.001;
  double velocity_noise_m_s = 0.02;
  double orientation_noise_rad = 0.004;
  double drift_m = 0.0;         // of the position, standard deviation after one second
  double dropouts_per_s = 0.0;  // on average
  double dropout_s = 0.1;       // how long one lasts
};

struct World {
  std::string name = "nominal";
  BodyParameters body;
  ServoParameters servo;
  SupplyParameters supply;
  GroundParameters ground;
  FeetKind feet = FeetKind::soles;
  WheelParameters wheels;
  ImuParameters imu;
  PoseParameters pose;
  double rest_s = 30.0;  // from the end of a trial to the next robot: servos cool, with torque off

  /// Heat or charge make a difference from trial to trial.
  bool tires() const { return servo.copper_per_K > 0.0 || supply.charge_Ah > 0.0; }
};

/// "nominal", "lab", "hard", "back", "worst", "tired", "hung" (files of worlds/), "seed:17" or
/// "honest:17" (drawn), "honest:17x1.5" (drawn and widened by 1.5), or the path of a TOML file;
/// "lab+ramp" is lab on the ground `ramp` (or a profile file), "lab+ramp+wheels" on wheels as well.
/// Throws WorldError.
World load_world(const std::string& name_or_path);

/// A world drawn by `seed` inside the ranges of docs/howto/emulator.md.
World draw_world(std::uint64_t seed);

/// Drawn by `seed` so that nothing cancels by design: signs of centre of mass, stiffness, friction
/// and delay are independent, every joint has its own zero and gain, the floor is not level and the
/// sensors drift. Ranges: docs/howto/emulator.md.
World draw_honest_world(std::uint64_t seed);

/// Between these widths a drawn world stays one that a file may hold.
inline constexpr double kNarrowest = 0.1, kWidest = 2.5;
/// `world` with whatever it differs in from the maker's figures `width` times as far from them:
/// what is a ratio in its logarithm, the horn in its compliance, the time in which the IMU's up
/// follows the felt force in its inverse. The bits of `world` at 1.
World widened(World world, double width);

/// A world file with all that `world` says; parse_world() gives it back to the last bit.
std::string to_toml(const World& world);

/// Parses a world file's text; `origin` names it in messages. Unknown keys are errors. Throws
/// WorldError.
World parse_world(const std::string& toml_text, const std::string& origin);

}  // namespace sanso::plant
