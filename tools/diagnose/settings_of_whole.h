// What is asked of a robot whose base floats: what stands, falls, hits and turns, and by how much
// what nobody states may be off.
#pragma once

#include <cstddef>

namespace sanso::diagnose {

/// When the gate takes base, IMU and foot columns for what they are not. Every refusal needs that
/// what was promised does not hold, and mostly that another reading does.
struct BaseSettings {
  double unrecorded_mass = 0.2;
  double quaternion = 0.1;
  double beyond_limits = 1.0;
  double agrees = 0.1;
  double disagrees = 0.4;
  double better = 0.03;
  int compared = 20;
  double turning_window = 0.1;
  double velocity_window = 0.03;
  double least_turning = 0.2;
  double least_speed = 0.05;
  double fastest = 50.0;
  double unit_slack = 0.4;
  double pulled = 0.2;
  template <class Field>
  void visit(Field&& field) {
    field("unrecorded_mass", unrecorded_mass, "share", 0.001, 0.9,
          "of the robot behind joints that are not recorded: with more nothing can be said");
    field(
        "quaternion", quaternion, "relative", 0.001, 0.9,
        "that its length may be off one: rounding of a log is far below, a wrong column far above");
    field("beyond_limits", beyond_limits, "rad", 0.05, 10.0,
          "that a joint may read beyond twice the URDF's limits: degrees and counts read far more");
    field("agrees", agrees, "1 - correlation", 0.001, 0.45,
          "of two columns that say the same; another reading has to come twice as near");
    field("disagrees", disagrees, "1 - correlation", 0.05, 1.9,
          "of two columns that do not: from here another reading is looked for");
    field("better", better, "correlation", 0.001, 0.5,
          "by which another reading has to fit better than the promised one");
    field("compared", compared, "windows", 4, 10000, "at least, before a correlation is believed");
    field("turning_window", turning_window, "s", 0.01, 2.0,
          "over which turning is compared: gyroscope noise averages out, motion does not");
    field("velocity_window", velocity_window, "s", 0.002, 1.0,
          "over which velocity is compared: long against a camera's jitter");
    field("least_turning", least_turning, "rad/s", 0.01, 5.0,
          "RMS: less cannot tell what agrees from what does not");
    field("least_speed", least_speed, "m/s", 0.001, 2.0, "RMS: the same reason");
    field("fastest", fastest, "m/s", 5.0, 10000.0,
          "RMS: faster than any robot walked; millimetres are");
    field("unit_slack", unit_slack, "relative", 0.05, 0.9,
          "around 9.81 within which a factor may be g: gains and payloads are within it");
    field("pulled", pulled, "share of the weight", 0.01, 0.9,
          "on feet that pull: more is a sign, less an offset");
  }
};

/// How drives and links of a standing robot are compared.
struct StanceSettings {
  double window = 0.1;
  double creeping = 0.05;
  double torque_noise = 0.02;
  double drive_share = 0.05;
  double force_noise = 0.2;
  double held_friction = 0.3;
  double stiction = 1.5;
  int moved = 10;
  double acceleration_noise = 0.5;
  double acceleration = 0.3;
  double acc_bias = 0.1;
  double moment = 0.003;
  double back_emf = 0.3;
  double coulomb = 0.02;
  double centre = 0.004;
  double most_place = 0.05;
  double least_gain = 0.1;
  double most_gain = 3.0;
  double most_lag = 0.06;
  double most_load = 0.6;
  double most_zero = 0.2;
  double least_torque = 0.5;
  double most_torque = 2.0;
  double least_mass = 0.1;
  double most_mass = 3.0;
  double least_scatter = 0.5;
  int fewest_recordings = 4;
  int rounds = 3;
  double instant = 0.2;
  double strained = 2.0;
  double torn = 3.0;
  double surely_worse = 2.0;
  double pushed = 5.0;
  double jump = 0.1;
  double carries = 0.02;
  double lifted = 0.006;
  double flat = 0.003;
  double eased = 0.5;
  int maximum_terms = 6;
  template <class Field>
  void visit(Field&& field) {
    field("window", window, "s", 0.02, 1.0, "means over which torques and motion are compared");
    field("creeping", creeping, "rad/s", 0.001, 1.0,
          "slower, dry friction may be anything up to its size");
    field("torque_noise", torque_noise, "N m", 0.0001, 1.0,
          "of a joint's balance over a window: where weights begin, what is left corrects it");
    field("drive_share", drive_share, "share", 0.0, 1.0,
          "of a drive's torque and damping that no model knows");
    field("force_noise", force_noise, "N", 0.001, 10.0, "the same of the base");
    field("held_friction", held_friction, "N m", 0.001, 10.0,
          "that a joint which stands still may be held by");
    field("stiction", stiction, "factor", 0.5, 10.0,
          "times the dry friction of a moving joint, as soon as that is known: holds it, no more");
    field("moved", moved, "windows", 1, 1000,
          "in which a joint has to move before its dry friction is known");
    field("acceleration_noise", acceleration_noise, "rad/s^2", 0.001, 100.0,
          "of a joint's acceleration over a window");
    field("acceleration", acceleration, "share", 0.0, 2.0,
          "of a joint's acceleration that smoothing may take");
    field("acc_bias", acc_bias, "m/s^2", 0.001, 5.0,
          "by which the felt vertical may be off, in the balance of the whole");
    field("moment", moment, "m", 0.0001, 0.1, "by which a stated centre of mass may be off");
    field("back_emf", back_emf, "share", 0.01, 1.0,
          "of a drive's damping that may be mechanical instead of electrical");
    field("coulomb", coulomb, "N m", 0.0001, 1.0, "of dry friction that nobody states");
    field("centre", centre, "m", 0.0001, 0.1, "within which a centre of mass is stated");
    field("most_place", most_place, "kg m", 0.001, 10.0,
          "first moment about the centre of mass that a payload has: how far out it may sit");
    visit_bounds(field);
    field("least_scatter", least_scatter, "deviations", 0.01, 1.0,
          "of a balance, as known beforehand: a fit of noise is no proof of less");
    field("fewest_recordings", fewest_recordings, "recordings", 2, 1000,
          "that are left out one by one; fewer are cut into pieces");
    field("rounds", rounds, "rounds", 1, 100,
          "of choosing with new weights; most settle after two");
    field("instant", instant, "rows", 0.001, 1.0,
          "by which the instants of goals and readings are not known; smoothing moves them too");
    field("strained", strained, "tolerances", 0.5, 20.0,
          "by which a figure of the nominal model is off: from here something is looked for");
    field("torn", torn, "tolerances", 0.5, 20.0,
          "by which it is still off beside all that was found: then something has no name");
    field(
        "surely_worse", surely_worse, "factor", 0.5, 100.0,
        "times the square of what chance allows, in squared deviations: no name does as well then");
    field("pushed", pushed, "factor", 1.2, 100.0,
          "times what a force on the base is in nine of ten windows of a recording: a push");
    field("jump", jump, "share of the weight", 0.005, 1.0,
          "by which a foot's force changes from row to row where it comes down or off");
    field("carries", carries, "share of the weight", 0.001, 0.5,
          "of a foot's force: less is what a sensor reads in the air");
    field("lifted", lifted, "m", 0.0005, 0.1,
          "that a sole without a sensor is above the lowest one when it is surely in the air");
    field("flat", flat, "rad", 0.0001, 0.1,
          "by which two soles that stand on one floor lean apart: rubber, and loads at an edge");
    field("eased", eased, "share", 0.0, 1.0,
          "of what the nominal model has to be off by: names that take less are described only");
    field("maximum_terms", maximum_terms, "terms", 1, 20, "that are looked for");
  }

 private:
  // further off, it is another drive or another robot
  template <class Field>
  void visit_bounds(Field& field) {
    field("least_gain", least_gain, "factor", 0.001, 1.0,
          "of a position loop's stiffness; softer, no robot stands");
    field("most_gain", most_gain, "factor", 1.0, 100.0, "of it; stiffer is another servo");
    field("most_lag", most_lag, "s", 0.001, 1.0, "of a command: six cycles of a slow bus");
    field("most_load", most_load, "share", 0.01, 2.0,
          "of the load that friction takes: from here a gear locks itself");
    field("most_zero", most_zero, "rad", 0.001, 3.0,
          "of a joint's zero: a tooth of a horn is 0.25, and is seen");
    field("least_torque", least_torque, "factor", 0.01, 1.0,
          "of a torque constant: a gear of half the ratio");
    field("most_torque", most_torque, "factor", 1.0, 100.0, "of it: of twice the ratio");
    field("least_mass", least_mass, "shares", 0.001, 0.9, "of its mass that a link has at least");
    field("most_mass", most_mass, "shares", 0.1, 100.0,
          "that a link may have more, and a payload of the whole robot");
  }
};

/// What the questions to a floating base take for standing, falling, turning; and tolerances.
struct WholeSettings {
  double clearance = 0.004;
  double touching = 0.05;
  double left_ground = 0.25;
  double one_corner = 1.5;
  double opposes = 0.6435;
  double impact_spread = 0.0135;
  double shortest_flight = 0.05;
  double falls = 0.25;
  int before_hit_rows = 10;
  int after_hit_rows = 3;
  double rest_speed = 0.05;
  double rest_turning = 0.3;
  double rest_time = 0.1;
  double hit_speed = 0.3;
  double slip_speed = 0.1;
  double block = 1.0;
  int recordings = 8;
  double window = 0.1;
  double stance_share = 0.2;
  double stance_edge = 0.2;
  double enough_turning = 0.2;
  double surely_mounted = 0.3;
  double same_frame = 0.1;
  double mount = 0.01;
  double gyro_bias = 0.01;
  double acc_bias = 0.15;
  double sole_tilt = 0.01;
  double level = 0.005;
  double leans = 0.2;
  double restitution = 0.05;
  double friction = 0.1;
  double scale = 0.005;
  double sinking = 0.0005;
  int least_groups = 4;
  int imu_groups = 6;
  int draws = 999;
  int imu_draws = 199;
  double imu_outlier = 3.0;
  int questions = 24;
  int parts = 3;
  int rim_points = 12;

  /// Into how many parts groups are cut: one alone has no others.
  std::size_t parts_of_groups() const { return parts > 2 ? static_cast<std::size_t>(parts) : 2; }
  template <class Field>
  void visit(Field&& field) {
    visit_motion(field);
    visit_tolerances(field);
    field("least_groups", least_groups, "groups", 2, 1000,
          "of values that hang together; fewer leave nothing to fit beside a held-out third");
    field("imu_groups", imu_groups, "groups", 3, 1000,
          "of what an IMU read: nine numbers are fitted, and their spread");
    field("draws", draws, "draws", 39, 1000000, "resampled groups of an interval of 95 %");
    field("imu_draws", imu_draws, "draws", 19, 100000,
          "the same of the IMU, where each is a fit and only a deviation is taken");
    field("imu_outlier", imu_outlier, "deviations", 1.0, 100.0,
          "from where the weight of a window of the IMU falls");
    field("questions", questions, "numbers", 1, 1000,
          "two sides of a dozen that are asked: they share the level of naming");
    field("parts", parts, "parts", 1, 100,
          "of the groups, two at least: each is predicted by what was fitted to the others");
    field("rim_points", rim_points, "points", 3, 1000,
          "of either end of a cylinder that touches: between two it is 3 % of the radius wider");
  }

 private:
  template <class Field>
  void visit_motion(Field& field) {
    field("clearance", clearance, "m", 0.0001, 0.1,
          "of the lowest point above the ground: higher, nothing touches");
    field("touching", touching, "share of rows", 0.001, 0.5,
          "that touch a ground whose height nobody states, or nothing can be said of contact");
    field("left_ground", left_ground, "clearances", 0.01, 1.0,
          "above the ground after a hit: higher, gravity alone acts");
    field("one_corner", one_corner, "clearances", 0.1, 100.0,
          "by which the next corner is higher: less, and two share the impulse");
    field("opposes", opposes, "rad", 0.01, 1.5,
          "between friction's impulse and the opposite of slip: further off, no corner slips");
    field("impact_spread", impact_spread, "s", 0.0, 0.1,
          "by which trackers that smooth spread an impact: left out of a flight's ends");
    field("shortest_flight", shortest_flight, "s", 0.01, 1.0,
          "without contact; a shorter one shows no acceleration");
    field("falls", falls, "share of gravity", 0.01, 0.9,
          "by which a fall may miss it: wider than any scale or clock, far from other motion");
    field("before_hit_rows", before_hit_rows, "rows", 3, 1000,
          "of the flight that lead to a hit: a straight line, gravity taken out");
    field("after_hit_rows", after_hit_rows, "rows", 1, 100,
          "after it that are averaged: more, and the next corner comes down");
    field("rest_speed", rest_speed, "m/s", 0.001, 1.0, "slower, the base is at rest");
    field("rest_turning", rest_turning, "rad/s", 0.01, 10.0, "slower, the base is at rest");
    field("rest_time", rest_time, "s", 0.02, 5.0, "of rest; shorter is a turning point");
    field("hit_speed", hit_speed, "m/s", 0.02, 5.0,
          "towards the ground: slower hits say nothing of restitution");
    field("slip_speed", slip_speed, "m/s", 0.01, 2.0,
          "along the ground: slower contacts may stick, and bound friction from below only");
    field("block", block, "s", 0.1, 60.0,
          "pieces of one recording that are resampled and held out");
    field("recordings", recordings, "recordings", 3, 1000,
          "from here whole ones are resampled and held out instead of pieces");
    field("window", window, "s", 0.02, 1.0, "means over which the IMU is compared");
    field("stance_share", stance_share, "share of the weight", 0.01, 0.45,
          "on a foot: with more it stands, with a tenth of that it swings");
    field("stance_edge", stance_edge, "share", 0.01, 0.45,
          "of a stance at either end, in which a foot rolls over its edges");
    field("enough_turning", enough_turning, "rad/s", 0.01, 5.0,
          "RMS: faster tells three axes of a rotation from biases");
    field("surely_mounted", surely_mounted, "rad", 0.05, 3.0,
          "a larger turn is how the IMU is mounted: no estimate of the attitude is as wrong");
    field("same_frame", same_frame, "rad", 0.005, 0.7,
          "off a link's axes: nearer, the IMU is told to be turned as that link");
  }
  template <class Field>
  void visit_tolerances(Field& field) {
    field("mount", mount, "rad", 0.0005, 0.2, "within which an IMU is mounted");
    field("gyro_bias", gyro_bias, "rad/s", 0.0001, 0.5, "that gyroscopes have unasked");
    field("acc_bias", acc_bias, "m/s^2", 0.005, 5.0, "that accelerometers have unasked");
    field("sole_tilt", sole_tilt, "rad", 0.0005, 0.2,
          "of a standing sole against the vertical: zeros of the joints and bent soles make it");
    field("level", level, "rad", 0.0005, 0.2,
          "of a floor, or of a tracker's vertical: floors are finished to 4 mm in 1 m (DIN 18202)");
    field("leans", leans, "rad", 0.01, 1.0,
          "at most, of whatever: says how little is known where headings tell nothing");
    field("restitution", restitution, "-", 0.001, 0.5, "within which it is stated");
    field("friction", friction, "relative", 0.001, 0.9, "within which it is stated");
    field("scale", scale, "relative", 0.0001, 0.2, "within which a tracker knows lengths");
    field(
        "sinking", sinking, "m", 0.00001, 0.1,
        "of one sole against the other when all weight changes feet: links bend, vertical is off");
  }
};

}  // namespace sanso::diagnose
