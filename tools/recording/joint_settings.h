// The settings of one joint in model.toml and in sidecar files: each declared once with unit,
// default and range.
// Reader, writer, sidecar check and docs/model-folder.md all walk `visit`.
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <string_view>

namespace sanso::recording {

enum class Actuator { torque, position_pd, dc_servo, passive };
inline constexpr std::array<std::string_view, 4> kActuatorNames{"torque", "position_pd", "dc_servo",
                                                                "passive"};
constexpr std::string_view to_string(Actuator a) {
  return kActuatorNames[static_cast<std::size_t>(a)];
}
constexpr std::optional<Actuator> actuator_from(std::string_view name) {
  for (std::size_t k = 0; k < kActuatorNames.size(); ++k) {
    if (kActuatorNames[k] == name) return static_cast<Actuator>(k);
  }
  return std::nullopt;
}

/// For prismatic joints read m for rad, N for N m, kg for kg m^2. The defaults of the servo are the
/// XM430-W350 at 12 V.
struct JointSettings {
  Actuator actuator = Actuator::dc_servo;
  double kp = 0.0;                // position_pd stiffness
  double kd = 0.0;                // position_pd damping, on the joint's own velocity
  double torque_limit = 4.1;      // at the output; 0 = none
  double p_gain = 4.604;          // dc_servo, duty per rad
  double d_gain = 0.0;            // dc_servo, duty per rad/s of joint velocity
  double i_gain = 0.0;            // dc_servo, duty per rad s
  double duty_limit = 1.0;        // dc_servo
  double voltage = 12.0;          // dc_servo, at the driver
  double resistance = 5.22;       // dc_servo, winding
  double torque_constant = 1.78;  // dc_servo, at the output shaft
  double back_emf = 2.49;         // dc_servo, at the output shaft
  double current_limit = 0.0;     // dc_servo; 0 = none
  double armature = 0.0;          // rotor inertia seen at the output shaft
  double viscous = 0.0;           // friction torque per velocity
  double coulomb = 0.0;           // friction torque, any speed
  double command_delay_s = 0.0;   // from the time stamp of the command until it acts
  double sensor_delay_s = 0.0;    // age of a reading at its time stamp
  double position_quantum = 0.0;  // encoder step; 0 = continuous
  double position_noise = 0.0;    // standard deviation, on top of the quantum

  /// field(key, value, unit, low, high) for every numeric setting.
  template <class Self, class Field>
  static void visit(Self& self, Field&& field) {
    constexpr double inf = std::numeric_limits<double>::infinity();
    field("kp", self.kp, "N m/rad", 0.0, inf);
    field("kd", self.kd, "N m s/rad", 0.0, inf);
    field("torque_limit", self.torque_limit, "N m", 0.0, inf);
    field("p_gain", self.p_gain, "duty/rad", 0.0, inf);
    field("d_gain", self.d_gain, "duty s/rad", 0.0, inf);
    field("i_gain", self.i_gain, "duty/(rad s)", 0.0, inf);
    field("duty_limit", self.duty_limit, "-", 0.0, 1.0);
    field("voltage", self.voltage, "V", 0.0, inf);
    field("resistance", self.resistance, "ohm", 1e-6, inf);
    field("torque_constant", self.torque_constant, "N m/A", 0.0, inf);
    field("back_emf", self.back_emf, "V s/rad", 0.0, inf);
    field("current_limit", self.current_limit, "A", 0.0, inf);
    field("armature", self.armature, "kg m^2", 0.0, inf);
    field("viscous", self.viscous, "N m s/rad", 0.0, inf);
    field("coulomb", self.coulomb, "N m", 0.0, inf);
    field("command_delay_s", self.command_delay_s, "s", 0.0, 1.0);
    field("sensor_delay_s", self.sensor_delay_s, "s", 0.0, 1.0);
    field("position_quantum", self.position_quantum, "rad", 0.0, inf);
    field("position_noise", self.position_noise, "rad", 0.0, inf);
  }

  bool operator==(const JointSettings&) const = default;
};

/// P gain of the joint's position loop: of duty per rad, or of torque; 0: it has none.
inline double loop_gain(const JointSettings& s) {
  if (s.actuator == Actuator::dc_servo) return s.p_gain;
  return s.actuator == Actuator::position_pd ? s.kp : 0.0;
}

}  // namespace sanso::recording
