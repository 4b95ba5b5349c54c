// What of a robot whose base floats an effect changes. The questions of the room wholebody/ ask for
// these figures; which effect a figure is, and what it is called, stands with the effect.
#pragma once

namespace sanso::diagnose {

/// Those that a model folder can say come first, as an error message lists them.
enum class WholeFigure {
  none,
  mass_share,   // of a link
  centre,       // of mass, of a link
  payload,      // at a link
  pose_scale,   // of recorded base positions
  pose_tilt,    // of the recorded poses' vertical
  force_scale,  // of recorded foot forces
  imu_bias,     // of accelerometer and gyroscope
  slope,        // of the floor
  imu_turn,     // how the IMU is mounted
  restitution,  // of a hit
  friction,     // of the ground
  compliance,   // of a contact
  sole_shape,   // of what touches
  rolling,      // resistance of wheels
  push          // of somebody
};

/// What may be off at a joint's drive: of one unit each.
enum class JointFigure : int { gain, lag, speed, dry, load, rotor, torque, zero };
inline constexpr int kJointFigures = 8;

/// An effect as a figure of a drive.
struct DriveQuestion {
  JointFigure figure{};
  // balances of a standing robot were shown to place it right; others stand in for it only
  bool placed = false;
};

}  // namespace sanso::diagnose
