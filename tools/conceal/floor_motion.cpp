// Knees bend twice what hips and ankles do, hips and ankles roll against each other. A leg is up
// while the sway rests over the other one; both hips go past each other then.
#include "tools/conceal/floor_motion.h"

#include <algorithm>
#include <cmath>

#include "tools/plant/vec.h"

namespace sanso::conceal {
namespace {

constexpr double kStandBend = 0.15;  // rad, of hip and ankle
// chosen: the sway rests for a third of a cycle at either side, and a foot is up in most of that
constexpr double kOver = 1.6, kUp = 0.75;

double smooth(double x) {
  const double s = std::clamp(x, 0.0, 1.0);
  return s * s * (3 - 2 * s);
}

/// Phase of the cycle in [0, 2 pi).
double phase_of(const FloorMotion& m, double t) {
  return std::fmod(2 * plant::kPi * m.rate_hz * std::max(0.0, t), 2 * plant::kPi);
}

/// 0: on the ground, 1: up; the left leg in the first half of the cycle.
double up(double phase, bool left) {
  return smooth(((left ? 1 : -1) * std::sin(phase) - kUp) / (1 - kUp));
}

/// Of the left leg: -1 behind, 1 ahead.
double ahead(double phase) {
  const double half = std::acos(kUp), quarter = 0.5 * plant::kPi;
  return 2 * smooth((phase - quarter + half) / (2 * half)) -
         2 * smooth((phase - 3 * quarter + half) / (2 * half)) - 1;
}

}  // namespace

double goal_of(const LinkSpec& l, const FloorMotion& m, double t) {
  const double phase = phase_of(m, t);
  const bool left = l.joint[0] == 'l', steps = m.lift > 0;
  const double wave = 0.5 - 0.5 * std::cos(phase), side = std::sin(phase);
  const double roll = m.sway * (steps ? std::clamp(kOver * side, -1.0, 1.0) : side);
  const double bend = kStandBend + m.squat * wave + (steps ? m.lift * up(phase, left) : 0);
  const double reach = m.stride > 0 ? m.stride * (left ? 1 : -1) * ahead(phase) : 0;
  const double pitch_sign = l.axis[1] > 0 ? 1 : -1, roll_sign = l.axis[0] > 0 ? 1 : -1;
  const std::string part = l.joint.substr(2);
  if (part == "hip_pitch") return (-bend - reach) * pitch_sign;
  if (part == "ank_pitch") return (-bend + reach) * pitch_sign;
  if (part == "knee") return 2 * bend * pitch_sign;
  if (part == "hip_roll") return roll * roll_sign;
  if (part == "ank_roll") return -roll * roll_sign;
  return 0;
}

}  // namespace sanso::conceal
