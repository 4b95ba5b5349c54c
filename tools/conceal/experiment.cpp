// Draws the commands joint by joint from one generator: adding a draw changes every case of that
// seed.
#include "tools/conceal/experiment.h"

#include <algorithm>
#include <cmath>

namespace sanso::conceal {
namespace {

constexpr int kRows = 2000;  // 20 s

/// Hold, multisine, slow triangle, steps, hold: reversals, standstill, slow and fast motion in
/// every recording.
std::vector<double> joint_command(double centre, double amplitude, Random& random) {
  constexpr int kSines = 4;
  double frequency[kSines], phase[kSines];
  for (int k = 0; k < kSines; ++k) {
    frequency[k] = 0.15 * std::pow(10.0, random.uniform(0.0, 0.9));
    phase[k] = random.uniform(0, 2 * plant::kPi);
  }
  const double slope = random.uniform(0.12, 0.3);
  std::vector<double> u(kRows, centre);
  double step_to = centre;
  for (int row = 0; row < kRows; ++row) {
    const double t = row * kControlPeriod_s;
    if (t >= 1 && t < 11) {
      double s = 0;
      for (int k = 0; k < kSines; ++k) s += std::sin(2 * plant::kPi * frequency[k] * t + phase[k]);
      u[row] = centre + std::min(1.0, t - 1) * amplitude * 0.45 * s;
    } else if (t >= 11 && t < 15) {
      const double x = std::fmod((t - 11) * slope, 4 * 0.35 * amplitude);
      const double leg = 0.35 * amplitude;
      u[row] = centre + (x < leg ? x : x < 3 * leg ? 2 * leg - x : x - 4 * leg);
    } else if (t >= 15 && t < 19) {
      if (row % 50 == 0) step_to = centre + amplitude * random.uniform(-0.7, 0.7);
      u[row] = step_to;
    }
    u[row] = std::clamp(u[row], -2.2, 2.2);
  }
  return u;
}

}  // namespace

std::vector<Experiment> make_experiments(const RobotSpec& robot, Random& random) {
  std::vector<Experiment> experiments;
  for (int i = 0; i < 6; ++i) {
    Experiment e;
    e.name = "rec_" + std::to_string(i + 1);
    if (i < 2) {
      e.condition = "usual";
    } else if (i < 4) {
      e.condition = "half gain";
      e.gain_scale = 0.5;
    } else if (robot.payload_kg > 0) {
      e.condition = "payload";
      e.payload_kg = robot.payload_kg;
    } else {
      e.condition = "tilted stand";
      e.gravity = {-9.81 * std::sin(0.26), 0, -9.81 * std::cos(0.26)};
    }
    std::vector<std::vector<double>> by_joint;
    for (int j = 0; j < robot.size(); ++j) {
      by_joint.push_back(
          joint_command(robot.posture[static_cast<std::size_t>(j)], robot.amplitude_rad, random));
    }
    for (int row = 0; row < kRows; ++row) {
      std::vector<double> u;
      for (const auto& joint : by_joint) u.push_back(joint[static_cast<std::size_t>(row)]);
      e.command.push_back(std::move(u));
    }
    experiments.push_back(std::move(e));
  }
  return experiments;
}

}  // namespace sanso::conceal
