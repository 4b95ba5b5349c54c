// Time of one roll-out of 60 s, restarted every half second: one pendulum, a two-link arm, two legs
// of six joints.
// Prints a table; figures of a machine, not a test.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <string>

#include "tools/diagnose/sim/simulator.h"

namespace {

using namespace sanso::diagnose;

/// `legs` chains of `joints` links each, hanging from the base.
std::string chains(std::size_t legs, std::size_t joints) {
  std::string urdf = "<robot name='bench'><link name='base'/>";
  const char* axes[] = {"0 0 1", "1 0 0", "0 1 0", "0 1 0", "0 1 0", "1 0 0"};
  for (std::size_t leg = 0; leg < legs; ++leg) {
    std::string parent = "base";
    for (std::size_t j = 0; j < joints; ++j) {
      const std::string id = std::to_string(leg) + "_" + std::to_string(j);
      const char* axis = joints == 1 ? axes[2] : joints == 2 ? axes[2 + j] : axes[j % 6];
      urdf +=
          "<joint name='q" + id + "' type='continuous'><parent link='" + parent +
          "'/><child link='l" + id + "'/><origin xyz='0 0.03 -0.1'/><axis xyz='" + axis +
          "'/></joint><link name='l" + id +
          "'><inertial><origin xyz='0.01 0 -0.05'/><mass value='0.2'/><inertia ixx='2e-4' ixy='0' "
          "ixz='0' "
          "iyy='2e-4' iyz='0' "
          "izz='1e-4'/></inertial></link>";
      parent = "l" + id;
    }
  }
  return urdf + "</robot>";
}

void run(const char* what, std::size_t legs, std::size_t joints, double period) {
  const ModelFolder model = parse_model(
      "format = 1\n[joint_default]\nactuator = \"dc_servo\"\narmature = 0.01\nviscous = 0.05\n"
      "coulomb = 0.05\n",
      chains(legs, joints), "bench");
  Drive drive;
  const auto rows = static_cast<std::size_t>(60.0 / period) + 1;
  for (std::size_t k = 0; k < rows; ++k) drive.t.push_back(static_cast<double>(k) * period);
  const std::size_t n = model.tree.size();
  for (std::size_t j = 0; j < n; ++j) {
    JointData data;
    data.q.assign(rows, 0.0);
    for (double t : drive.t) data.command.push_back(0.4 * std::sin(3 * t + static_cast<double>(j)));
    drive.joints.push_back(data);
  }
  std::vector<Window> windows;
  const auto step = static_cast<std::size_t>(0.5 / period);
  const std::vector<double> zero(n, 0.0);
  for (std::size_t first = 0; first + step < rows; first += step)
    windows.push_back({first, first + step, zero, zero});
  const SimParams params = make_params(model);
  double best = 1e9;
  for (int repeat = 0; repeat < 5; ++repeat) {
    const auto start = std::chrono::steady_clock::now();
    const auto out = simulate(params, drive, windows);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    if (std::isfinite(out.back().q.back())) best = std::min(best, took.count());
  }
  std::printf("%-28s %5.0f Hz   %8.2f ms   (%.0f ns a joint and step)\n", what, 1 / period,
              1e3 * best, 1e9 * best / (60.0 / 1e-3 * n));
}

}  // namespace

int main() {
  std::printf("60 s, shots of 0.5 s, steps of at most 1 ms, one thread, best of 5\n");
  run("pendulum", 1, 1, 0.005);
  run("two-link arm", 1, 2, 0.005);
  run("two legs, 12 joints", 2, 6, 0.008);
  return 0;
}
