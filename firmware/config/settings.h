// Every setting of the controller, declared once: name, unit (suffix), default, range, meaning. The
// TOML reader and docs/settings.md walk the same visit(). Angles in rad, times in s, in every file.
#pragma once

#include <array>

#include "shared/model/joints.h"

namespace sanso::firmware {

/// By how much a servo's zero lies away from its joint's, rad, index = servo id - 1.
using JointOffsets = std::array<double, 20>;

struct BusSettings {
  double reply_timeout_s = 0.0045;
  double byte_rate_baud = 2'000'000;
  int slow_read_every_ticks = 2;
  int position_p_gain_raw = model::kPositionPGainRaw;
  int return_delay_raw = 1;
  bool fast_sync_read = true;
  bool require_opencr = true;
  double listen_s = 0.1;
  double power_up_wait_s = 0.9;
  int silent_ticks = 10;
  JointOffsets offset_rad{};  // from a file of its own (offsets_file.h)
  template <class Field>
  void visit(Field&& field) {
    field("reply_timeout_s", reply_timeout_s, 0.001, 0.008,
          "replies to the cyclic read are waited for this long");
    field("byte_rate_baud", byte_rate_baud, 57'600.0, 4'500'000.0, "speed of the servo bus");
    field("slow_read_every_ticks", slow_read_every_ticks, 1, 100,
          "one servo's voltage and temperature is read every so many ticks");
    field("position_p_gain_raw", position_p_gain_raw, 100, 1600,
          "position P gain register of every servo (560: 70 % of the default)");
    field("return_delay_raw", return_delay_raw, 0, 10, "return delay register, 2 us a unit");
    field("fast_sync_read", fast_sync_read, false, true,
          "use the fast sync read when all servos know it");
    field("require_opencr", require_opencr, false, true,
          "switch the servo supply on through the OpenCR board at start");
    field("listen_s", listen_s, 0.0, 5.0,
          "the bus has to be silent for so long before the first request");
    field("power_up_wait_s", power_up_wait_s, 0.0, 5.0,
          "time between supply on and the first ping");
    field("silent_ticks", silent_ticks, 2, 100,
          "a leg servo without a good reply for so many ticks is a fault");
  }
};

struct ImuSettings {
  double period_s = 0.005;
  double silent_s = 0.05;
  double frozen_s = 0.10;
  double late_s = 0.025;
  double quat_base_sensor_w = 1.0;
  double quat_base_sensor_x = 0.0;
  double quat_base_sensor_y = 0.0;
  double quat_base_sensor_z = 0.0;
  bool gyro_bias_at_rest = false;
  bool from_board = false;  // device.imu = "opencr": the board on the servo bus is the sensor
  template <class Field>
  void visit(Field&& field) {
    field("period_s", period_s, 0.001, 0.01, "report interval asked of the sensor");
    field("silent_s", silent_s, 0.02, 0.5, "no complete sample for so long is a fault");
    field("frozen_s", frozen_s, 0.03, 1.0, "bit-identical samples for so long are a fault");
    field("late_s", late_s, 0.01, 0.5, "a sample older than this sets the limit imu_late");
    field("quat_base_sensor_w", quat_base_sensor_w, -1.0, 1.0,
          "mounting of the sensor: rotation that turns its axes into base axes, w");
    field("quat_base_sensor_x", quat_base_sensor_x, -1.0, 1.0, "same, x");
    field("quat_base_sensor_y", quat_base_sensor_y, -1.0, 1.0, "same, y");
    field("quat_base_sensor_z", quat_base_sensor_z, -1.0, 1.0, "same, z");
    field("gyro_bias_at_rest", gyro_bias_at_rest, false, true,
          "take off what the gyro shows at rest (always for sensors without orientation)");
  }
};

struct EstimatorSettings {
  double accel_noise = 0.6;
  double foot_slip_noise = 0.02;
  double foot_swing_noise = 10.0;
  double foot_position_noise_m = 0.002;
  double foot_velocity_noise = 0.08;
  double contact_height_m = 0.004;
  double pose_noise_m = 0.002;
  double pose_velocity_noise = 0.05;
  double pose_max_age_s = 0.1;
  int pose_min_confidence = 2;
  bool flat_ground = true;
  bool wheels = false;
  double joint_rate_filter_s = 0.0;
  template <class Field>
  void visit(Field&& field) {
    field("accel_noise", accel_noise, 0.01, 10.0,
          "white noise of the base acceleration, m/s^2 in one tick");
    field("foot_slip_noise", foot_slip_noise, 1e-4, 1.0, "random walk of a loaded foot, m/s");
    field("foot_swing_noise", foot_swing_noise, 0.1, 1000.0,
          "random walk of a foot in the air, m/s");
    field("foot_position_noise_m", foot_position_noise_m, 1e-4, 0.05,
          "error of the leg kinematics");
    field("foot_velocity_noise", foot_velocity_noise, 0.005, 1.0,
          "error of the velocity of a loaded foot from joint rates, m/s");
    field("contact_height_m", contact_height_m, 0.001, 0.03,
          "a sole this far above the lower one counts as unloaded");
    field("pose_noise_m", pose_noise_m, 1e-4, 0.1, "noise of the external position");
    field("pose_velocity_noise", pose_velocity_noise, 0.005, 1.0,
          "noise of the external velocity, m/s");
    field("pose_max_age_s", pose_max_age_s, 0.02, 1.0,
          "external poses older than this are not used");
    field("pose_min_confidence", pose_min_confidence, 0, 3,
          "external poses of less confidence are not used");
    field("flat_ground", flat_ground, false, true, "loaded soles are at height 0");
    field("wheels", wheels, false, true,
          "the robot wears skates: a loaded foot rolls along its own x axis");
    field("joint_rate_filter_s", joint_rate_filter_s, 0.0, 0.1,
          "time constant of the low-pass on joint rates");
  }
};

struct GuardSettings {
  double joint_margin_rad = 0.02;
  double max_target_rate_rad_s = 15.0;
  double max_target_offset_rad = 0.6;
  double max_current_A = 2.3;
  double warm_temperature_C = 65.0;
  double max_temperature_C = 75.0;
  double low_voltage_V = 11.0;
  double min_voltage_V = 9.8;
  double max_voltage_V = 15.0;
  double voltage_time_s = 0.3;
  double tilt_limit_rad = 0.5;
  double fall_tilt_rad = 1.0;
  double fall_height_m = 0.10;
  double fall_time_s = 0.05;
  int overrun_ticks = 20;
  double max_duty = 0.9;  // leaves a tenth of the torque as what no gain and no defect can ask for
  double hot_duty = 0.5;
  double max_held_rate_rad_s = 3.0;
  double tuck_s = 0.2;
  template <class Field>
  void visit(Field&& field) {
    field("joint_margin_rad", joint_margin_rad, 0.0, 0.3,
          "targets stay this far inside the joint limits");
    field("max_target_rate_rad_s", max_target_rate_rad_s, 1.0, 60.0,
          "targets change at most this fast");
    field("max_target_offset_rad", max_target_offset_rad, 0.1, 1.5,
          "distance of a target from the joint; full duty is reached at 0.31 rad");
    field("max_current_A", max_current_A, 0.5, 3.2, "motor current that sets the limit current");
    field("warm_temperature_C", warm_temperature_C, 40.0, 80.0,
          "servo temperature that sets the limit temperature");
    field("max_temperature_C", max_temperature_C, 50.0, 85.0, "servo temperature that is a fault");
    field("low_voltage_V", low_voltage_V, 9.0, 14.0, "supply that sets the limit voltage");
    field("min_voltage_V", min_voltage_V, 8.0, 12.0, "supply that is a fault");
    field("max_voltage_V", max_voltage_V, 12.6, 16.0, "supply that is a fault");
    field("voltage_time_s", voltage_time_s, 0.05, 5.0, "supply has to be outside for so long");
    field("tilt_limit_rad", tilt_limit_rad, 0.1, 1.5,
          "tilt that sets the limit tilt, and above which arm is refused");
    field("fall_tilt_rad", fall_tilt_rad, 0.3, 1.6, "tilt that is a fall");
    field("fall_height_m", fall_height_m, 0.0, 0.25,
          "base height above the lower sole that is a fall");
    field("fall_time_s", fall_time_s, 0.01, 0.5, "a fall has to last so long");
    field("overrun_ticks", overrun_ticks, 2, 100, "so many late ticks of the last 100 are a fault");
    field("max_duty", max_duty, 0.2, 1.0,
          "motor voltage that a servo may use, share of the supply");
    field("hot_duty", hot_duty, 0.1, 1.0,
          "the same for a servo at max_temperature_C; in between from warm_temperature_C on");
    field("max_held_rate_rad_s", max_held_rate_rad_s, 0.5, 10.0,
          "targets of arms and head change at most this fast");
    field("tuck_s", tuck_s, 0.0, 1.0,
          "after a fall is certain the limbs are drawn in softly for so long, then torque off");
  }
};

struct SupervisorSettings {
  double stand_up_s = 3.0;
  double approach_s = 0.8;
  double near_pose_rad = 0.5;
  double soft_stop_s = 1.5;
  double lower_s = 3.0;
  double host_silent_s = 0.25;
  double left_alone_s = 20.0;
  double middle_ramp_s = 0.5;
  // just above m g h / (2 K) of the model: two ankles of its stiffness answer gravity's toppling
  double balance_pitch_gain = 0.25;
  double balance_roll_gain = 0.25;
  double balance_pitch_rate_s = 0.0;
  double balance_roll_rate_s = 0.0;
  template <class Field>
  void visit(Field&& field) {
    field("stand_up_s", stand_up_s, 1.0, 20.0,
          "time from the present pose to the crouch, and from the crouch to the first pose");
    field("approach_s", approach_s, 0.3, 10.0,
          "time to the first pose when the robot is near it already");
    field("near_pose_rad", near_pose_rad, 0.05, 2.0,
          "largest joint error that counts as near the first pose");
    field("soft_stop_s", soft_stop_s, 0.3, 10.0,
          "time of the blend from a stopped trial to the first pose");
    field("lower_s", lower_s, 1.0, 20.0, "time to lower into the crouch before torque off");
    field("host_silent_s", host_silent_s, 0.05, 5.0,
          "a host silent for so long in a trial ends it by a soft stop");
    field("left_alone_s", left_alone_s, 1.0, 3600.0,
          "a robot with torque on that no host talks to for so long is lowered");
    field("middle_ramp_s", middle_ramp_s, 0.0, 5.0,
          "the middle layer's first knot comes in over this time while holding");
    field("balance_pitch_gain", balance_pitch_gain, 0.0, 2.0,
          "ankle answer to pitch against the first pose while holding, rad/rad; 0 = none");
    field("balance_roll_gain", balance_roll_gain, 0.0, 2.0,
          "ankle answer to roll against the first pose while holding, rad/rad; 0 = none");
    field("balance_pitch_rate_s", balance_pitch_rate_s, 0.0, 0.5,
          "ankle answer to pitch rate while holding");
    field("balance_roll_rate_s", balance_roll_rate_s, 0.0, 0.5,
          "ankle answer to roll rate while holding");
  }
};

struct ReflexConfig {
  double gain_rad = 0.1;
  double sharpness = 10.0;
  template <class Field>
  void visit(Field&& field) {
    field("gain_rad", gain_rad, 0.0, 0.5,
          "largest push of the stretch reflex away from a joint limit");
    field("sharpness", sharpness, 1.0, 100.0, "sigmoid gain of the stretch reflex, 1/rad");
  }
};

struct Settings {
  BusSettings bus;
  ImuSettings imu;
  EstimatorSettings estimator;
  GuardSettings guard;
  SupervisorSettings supervisor;
  ReflexConfig reflex;
  /// Calls section(name, struct) for every group, in the order of the settings page.
  template <class Section>
  void visit(Section&& section) {
    section("bus", bus);
    section("imu", imu);
    section("estimator", estimator);
    section("guard", guard);
    section("supervisor", supervisor);
    section("reflex", reflex);
  }
};

}  // namespace sanso::firmware
