// Figures that the diagnosis of a floating base depends on, declared once as in settings.h; they
// stand apart because no room below this one asks for them.
#pragma once

namespace sanso::diagnose {

struct WholeSettings {
  double clearance = 0.004;
  double impact_spread = 0.0135;
  double shortest_flight = 0.05;
  double rest_speed = 0.05;
  double rest_turning = 0.3;
  double rest_time = 0.1;
  double hit_speed = 0.3;
  double slip_speed = 0.1;
  double block = 1.0;
  double window = 0.1;
  double stance_share = 0.2;
  double mount = 0.01;
  double gyro_bias = 0.01;
  double acc_bias = 0.15;
  double sole_tilt = 0.01;
  double restitution = 0.05;
  double friction = 0.1;
  double scale = 0.005;
  double unrecorded_mass = 0.2;

  template <class Field>
  void visit(Field&& field) {
    field("clearance", clearance, "m", 0.0001, 0.1,
          "of the lowest point above the ground: higher, nothing touches");
    field("impact_spread", impact_spread, "s", 0.0, 0.1,
          "by which trackers that smooth spread an impact: left out of a flight's ends");
    field("shortest_flight", shortest_flight, "s", 0.01, 1.0,
          "without contact; a shorter one shows no acceleration");
    field("rest_speed", rest_speed, "m/s", 0.001, 1.0, "slower, the base is at rest");
    field("rest_turning", rest_turning, "rad/s", 0.01, 10.0, "slower, the base is at rest");
    field("rest_time", rest_time, "s", 0.02, 5.0, "of rest; shorter is a turning point");
    field("hit_speed", hit_speed, "m/s", 0.02, 5.0,
          "towards the ground: slower hits say nothing of restitution");
    field("slip_speed", slip_speed, "m/s", 0.01, 2.0,
          "along the ground: slower contacts may stick, and bound friction from below only");
    field("block", block, "s", 0.1, 60.0,
          "pieces of one recording that are resampled and held out");
    field("window", window, "s", 0.02, 1.0, "means over which the IMU is compared");
    field("stance_share", stance_share, "share of the weight", 0.01, 0.45,
          "on a foot: with more it stands, with a tenth of that it swings");
    field("mount", mount, "rad", 0.0005, 0.2, "within which an IMU is mounted");
    field("gyro_bias", gyro_bias, "rad/s", 0.0001, 0.5, "that gyroscopes have unasked");
    field("acc_bias", acc_bias, "m/s^2", 0.005, 5.0, "that accelerometers have unasked");
    field("sole_tilt", sole_tilt, "rad", 0.0005, 0.2,
          "of a standing sole against the vertical: zeros of the joints and bent soles make it");
    field("restitution", restitution, "-", 0.001, 0.5, "within which it is stated");
    field("friction", friction, "relative", 0.001, 0.9, "within which it is stated");
    field("scale", scale, "relative", 0.0001, 0.2, "within which a tracker knows lengths");
    field("unrecorded_mass", unrecorded_mass, "share", 0.001, 0.9,
          "of the robot behind joints that are not recorded: with more nothing can be said");
  }
};

}  // namespace sanso::diagnose
