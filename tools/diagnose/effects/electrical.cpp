// Servo firmware and electrical supply: E1 to E11 of the method page.
#include <algorithm>

#include "tools/diagnose/effects/families.h"

namespace sanso::diagnose {
namespace {

Effect firmware(Effect effect) {
  return of_chapter({Family::electrical, Port::firmware, Scope::joint, kR2 | kR4},
                    std::move(effect));
}
Effect winding(Effect effect) {
  return of_chapter({Family::electrical, Port::electrical, Scope::joint, kR2 | kR4},
                    std::move(effect));
}
Effect supply(Effect effect) {
  return of_chapter({Family::electrical, Port::electrical, Scope::robot, kR2 | kR4},
                    std::move(effect));
}

Effect servo_p_gain() {
  return firmware({
      .id = "servo_p_gain",
      .code = "E1",
      .name = "P gain of the servo",
      .form = "p_gain (kp) times gain",
      .parameters = {{"gain", "-", 1, 0.4, 2.5, 0.2}},
      .probes = {{1.2}},
      .needs = kPositionLoop,
      .cluster = "AH",
      .confounders = {"torque_constant", "battery_drift", "link_mass", "supply_sag",
                      "current_limit", "thermal_derating"},
      .regimes = {"high load", "standstill", "near command step"},
      .signature = "static error in proportion to load, in all regimes",
      .experiments = {kHalveGain, kLogDuty},
      .settings = {multiplied({&JointSettings::p_gain, &JointSettings::kp})},
      .identified = {Identified::always},
      .tolerances = {{.name = "gain",
                      .order = 5,
                      .deviation = &ToleranceSettings::gain,
                      .direction = driven_by({Actuator::dc_servo, Actuator::position_pd}, {1.0})}},
      .drive = DriveQuestion{JointFigure::gain, true},
      .apply = multiplies(&JointParams::p_scale),
  });
}

Effect servo_d_gain() {
  return firmware({
      .id = "servo_d_gain",
      .code = "E2",
      .name = "D gain or output filter of the servo",
      .form =
          "-damping dq by the servo (on_error: damping (d goal/dt - dq)); first order `filter` on "
          "its output (of_rate: on that speed alone)",
      .parameters = {{"damping", "N m s/rad", 0, 0, 2, 0.1, Unit::viscous},
                     {"filter", "s", 0, 0, 0.03, 0.005},
                     {"on_error", "-", 0, 0, 1, 1, Unit::none, true},
                     {"of_rate", "-", 0, 0, 1, 1, Unit::none, true}},
      .probes = {{0.1, 0, 0, 0}, {0, 0.005, 0, 0}, {0.1, 0, 1, 0}, {0.1, 0.005, 0, 1}},
      .sign = 1,
      .needs = kPositionLoop,
      .cluster = "BC",
      .confounders = {"viscous_friction", "torque_constant", "command_delay", "sensor_delay",
                      "joint_compliance", "servo_profile"},
      .regimes = {"near command step", "high speed"},
      .signature = "shows in steps",
      .experiments = {kTorqueOff, kLogDuty, kSteps},
      .apply =
          [](SimParams& p, int j, Theta x) {
            JointParams& to = joint(p, j);
            to.d_torque += x[0];
            to.output_filter += x[1];
            to.d_on_error += x[2];
            to.filters_rate = x[3] >= 0.5;
          },
  });
}

Effect servo_i_gain() {
  return firmware({
      .id = "servo_i_gain",
      .code = "E3",
      .name = "I gain or feed-forward of the servo",
      .form =
          "P gain of model.toml times (integral int(error) + feed_forward d goal/dt); while the "
          "output is limited the integral goes on up to windup",
      // what an integral does at full output is the firmware's choice: stop, stop where it
      // alone asks for full output, or wind up
      .parameters = {{"integral", "1/s", 0, 0, 20, 1},
                     {"feed_forward", "s", 0, 0, 0.1, 0.01},
                     {"windup", "of full", 0, 0, kOff, 1, Unit::none, true}},
      .probes = {{2, 0, 0}, {2, 0, 1}, {2, 0, kOff}, {0, 0.02, 0}},
      .sign = 1,
      .needs = kPositionLoop,
      .confounders = {"servo_p_gain", "coulomb_friction"},
      .regimes = {"standstill", "near command step"},
      .signature = "the static error decays",
      .experiments = {kHolds, kLogDuty},
      .apply =
          [](SimParams& p, int j, Theta x) {
            joint(p, j).integral_rate += x[0];
            joint(p, j).feed_forward += x[1];
            joint(p, j).windup = std::max(joint(p, j).windup, x[2]);
          },
  });
}

Effect torque_constant() {
  return winding({
      .id = "torque_constant",
      .code = "E4",
      .name = "torque constant or winding resistance",
      .form = "torque per current (and back-EMF) times torque, resistance times resistance",
      .parameters = {{"torque", "-", 1, 0.4, 2.5, 0.1}, {"resistance", "-", 1, 0.4, 2.5, 0.1}},
      .probes = {{1.15, 1}, {1, 1.15}},
      .needs = kCommand,
      .cluster = "AC",
      .confounders = {"servo_p_gain", "battery_drift", "link_mass", "viscous_friction"},
      .regimes = {"high load", "high speed"},
      .signature = "only their ratio, unless current or speed limits act",
      .experiments = {kAddPayload, kLogCurrent},
      .settings = {multiplied({&JointSettings::torque_constant, &JointSettings::back_emf},
                              Actuator::dc_servo),
                   multiplied({&JointSettings::resistance}, Actuator::dc_servo)},
      .identified = {Identified::under_torque, Identified::never},
      .tolerances = {{.name = "torque constant",
                      .order = 6,
                      .deviation = &ToleranceSettings::motor,
                      .direction = driven_by({Actuator::dc_servo}, {1.0, 0.0})},
                     {.name = "resistance",
                      .order = 7,
                      .deviation = &ToleranceSettings::motor,
                      .direction = driven_by({Actuator::dc_servo}, {0.0, 1.0})}},
      .effort = {.kind = EffortKind::share,
                 .most = 0.4,
                 .tolerance = within(0, &ToleranceSettings::motor)},
      .drive = DriveQuestion{JointFigure::torque},
      .apply = multiplies(&JointParams::torque_scale, &JointParams::resistance_scale),
  });
}

Effect voltage_limit() {
  return winding({
      .id = "voltage_limit",
      .code = "E5",
      .name = "limit of duty or torque, torque-speed line",
      .form = "|output| <= limit of full; torque falls to zero at no_load_speed",
      .parameters = {{"limit", "of full", 1, 0.3, 1, 0.1},
                     {"no_load_speed", "rad/s", kOff, 0.5, kOff, 1, Unit::speed}},
      .smooth = false,
      .probes = {{0.8, kOff}, {0.5, kOff}, {1, 5}},
      .sign = -1,
      .needs = kCommand | kTorqueLimit,
      .confounders = {"current_limit", "servo_profile"},
      .regimes = {"|duty| > 0.9"},
      .signature = "only near full duty",
      .experiments = {kRaiseSupply, kLogDuty},
      .apply =
          [](SimParams& p, int j, Theta x) {
            joint(p, j).output_limit = std::min(joint(p, j).output_limit, x[0]);
            if (x[1] < kOff) joint(p, j).no_load_speed = x[1];
          },
  });
}

Effect current_limit() {
  return winding({
      .id = "current_limit",
      .code = "E6",
      .name = "current limit",
      .form = "|i| <= current",
      .parameters = {{"current", "A", kOff, 0.1, kOff, 0.2, Unit::current}},
      .smooth = false,
      .probes = {{1.2}, {0.5}},
      .sign = -1,
      .needs = kMotorModel,
      .cluster = "H",
      .confounders = {"supply_sag", "servo_p_gain", "thermal_derating", "battery_drift",
                      "voltage_limit"},
      .regimes = {"|i| near limit", "high load"},
      .signature = "a plateau that does not depend on speed",
      .experiments = {kRaiseSupply, kLogCurrent},
      .apply =
          [](SimParams& p, int j, Theta x) {
            if (x[0] < kOff) joint(p, j).current_limit = std::min(joint(p, j).current_limit, x[0]);
          },
  });
}

Effect supply_sag() {
  return supply({
      .id = "supply_sag",
      .code = "E7",
      .name = "supply sag",
      .form = "V = V0 - resistance sum |i duty| over all joints",
      .parameters = {{"resistance", "ohm", 0, 0, 3, 0.3}},
      .probes = {{0.5}},
      .sign = 1,
      .needs = kMotorModel,
      .cluster = "H",
      .confounders = {"current_limit", "servo_p_gain", "thermal_derating", "battery_drift"},
      .regimes = {"voltage low", "high load"},
      .signature = "many joints loaded",
      .experiments = {kLogVoltage, kAddPayload},
      .apply = [](SimParams& p, int, Theta x) { p.supply_resistance += x[0]; },
  });
}

Effect battery_drift() {
  return supply({
      .id = "battery_drift",
      .code = "E8",
      .name = "supply level or drift",
      .form = "V = V0 (1 + level + slope t/60 s)",
      .parameters = {{"level", "-", 0, -0.2, 0.2, 0.05}, {"slope", "1/min", 0, -0.1, 0.1, 0.01}},
      .probes = {{0.05, 0}, {0, 0.02}},
      .needs = kPositionLoop,
      .cluster = "AH",
      .confounders = {"servo_p_gain", "torque_constant", "link_mass", "thermal_friction",
                      "thermal_derating", "supply_sag"},
      .regimes = {"late", "voltage low"},
      .signature = "slow",
      .experiments = {kLogVoltage, kRaiseSupply},
      .law = {&ToleranceSettings::gain, {0}},
      .apply =
          [](SimParams& p, int, Theta x) {
            p.supply_level += x[0];
            p.supply_slope += x[1];
          },
  });
}

Effect thermal_derating() {
  return winding({
      .id = "thermal_derating",
      .code = "E9",
      .name = "torque lost when hot",
      .form = "torque times 1 - rate (T - T0)",
      .parameters = {{"rate", "1/K", 0, 0, 0.05, 0.005}},
      .probes = {{0.01}},
      .sign = 1,
      .needs = kCommand | kTemperature,
      .cluster = "H",
      .confounders = {"battery_drift", "supply_sag", "current_limit", "servo_p_gain"},
      .regimes = {"hot", "late"},
      .signature = "minutes, hot",
      .experiments = {kWarm, kLogVoltage},
      .apply = adds(&JointParams::derating),
  });
}

Effect servo_deadband() {
  return firmware({
      .id = "servo_deadband",
      .code = "E10",
      .name = "dead zone of the servo's output",
      .form = "output below `zone` of full gives nothing, above it the rest",
      .parameters = {{"zone", "of full", 0, 0, 0.1, 0.005}},
      .smooth = false,
      .probes = {{0.005}, {0.02}},
      .sign = 1,
      .needs = kCommand | kTorqueLimit,
      .cluster = "D",
      .confounders = {"coulomb_friction", "backlash", "presliding_friction"},
      .regimes = {"standstill", "reversal"},
      .signature = "tiny errors are not corrected",
      .experiments = {kHalveGain, kLogDuty},
      .apply = adds(&JointParams::dead_zone),
  });
}

Effect servo_profile() {
  return firmware({
      .id = "servo_profile",
      .code = "E11",
      .name = "profile inside the servo",
      .form = "goal limited to speed and acceleration",
      .parameters = {{"speed", "rad/s", kOff, 0.2, kOff, 0.3, Unit::speed},
                     {"acceleration", "rad/s^2", kOff, 1, kOff, 5, Unit::acceleration}},
      .smooth = false,
      .probes = {{2, kOff}, {0.8, kOff}, {kOff, 20}, {kOff, 80}},
      .sign = -1,
      .needs = kPositionLoop,
      .cluster = "B",
      .confounders = {"command_delay", "sensor_delay", "servo_d_gain", "joint_compliance",
                      "voltage_limit"},
      .regimes = {"near command step", "high speed"},
      .signature = "triangular lag behind the goal",
      .experiments = {kSteps},
      .apply =
          [](SimParams& p, int j, Theta x) {
            if (x[0] < kOff) joint(p, j).profile_speed = x[0];
            if (x[1] < kOff) joint(p, j).profile_acceleration = x[1];
          },
  });
}

}  // namespace

std::vector<Effect> electrical_effects() {
  return {servo_p_gain(),     servo_d_gain(),   servo_i_gain(), torque_constant(),
          voltage_limit(),    current_limit(),  supply_sag(),   battery_drift(),
          thermal_derating(), servo_deadband(), servo_profile()};
}

}  // namespace sanso::diagnose
