// Recordings for the tests of the gate: two servos that lag and sag behind two different commands.
#pragma once

#include <algorithm>
#include <cmath>
#include <deque>
#include <string>
#include <utility>
#include <vector>

#include "tools/diagnose/gate/gate.h"
#include "tools/diagnose/stats/random.h"

namespace sanso::diagnose::test {

inline constexpr double kQuantum = 6.283185307179586 / 4096.0;
inline constexpr double kDegrees = 57.29577951308232;

/// A recording that owns its columns.
struct Data {
  std::string file = "a.csv";
  std::vector<double> t;
  std::deque<std::pair<std::string, std::vector<double>>> columns;
  std::vector<double>& operator[](const std::string& name) {
    for (auto& [key, values] : columns) {
      if (key == name) return values;
    }
    return columns.emplace_back(name, std::vector<double>(t.size(), NAN)).second;
  }
  GateRecording view() const {
    GateRecording r{file, "", t, {}};
    for (const auto& [name, values] : columns) r.channels.push_back({name, values});
    return r;
  }
};

/// How a recording is made: the encoder's step (0: none), rows about `period` apart.
struct Making {
  std::uint64_t seed = 3;
  double quantum = kQuantum;
  double period = 0.0055;
  double seconds = 8.0;
  double largest_command = 1e9;  // the servo is asked for no more, rad
};

inline double command_of(int joint, double t, std::uint64_t seed) {
  return joint == 0 ? 0.6 * std::sin(2 * t + 0.1 * static_cast<double>(seed))
                    : 0.4 * std::sin(3.1 * t) + 0.3 * std::sin(0.9 * t);
}

/// Columns u, q, dq, pwm of `hip` and `knee`, sampled unevenly.
inline Data made(const Making& how) {
  Data d;
  Random random(how.seed);
  for (double t = 0; t < how.seconds; t += how.period * (0.91 + 0.18 * random.uniform()))
    d.t.push_back(t);
  const char* names[] = {"hip", "knee"};
  for (int j = 0; j < 2; ++j) {
    const std::string name = names[j];
    auto& u = d["u:" + name];
    auto& q = d["q:" + name];
    auto& dq = d["dq:" + name];
    auto& pwm = d["pwm:" + name];
    double x = 0, v = 0;
    for (std::size_t k = 0; k < d.t.size(); ++k) {
      const double h = k > 0 ? d.t[k] - d.t[k - 1] : 0.0;
      u[k] = std::clamp(command_of(j, d.t[k], how.seed), -how.largest_command, how.largest_command);
      const double duty = std::clamp(4.6 * (u[k] - x), -1.0, 1.0);
      v += h * (90 * duty - 20 * v - 9 * std::sin(x));
      x += h * v;
      q[k] = how.quantum > 0.0 ? how.quantum * std::round(x / how.quantum) : x;
      dq[k] = 0.024 * std::round(v / 0.024);
      pwm[k] = std::round(885 * duty) / 885;
    }
  }
  return d;
}

inline Data healthy(std::uint64_t seed = 3) { return made({seed}); }

inline std::vector<GateJoint> joints() {
  return {{"hip", false, -1.5, 1.5, 4.8, 2.3, 4.1, 12.0},
          {"knee", false, 0, 0, 4.8, 2.3, 4.1, 12.0}};
}

inline void scale(std::vector<double>& x, double factor) {
  for (double& v : x) v *= factor;
}

/// The first reason to refuse it; an empty one when it is let through.
inline Defect first_defect(const Data& d) {
  const GateReport report = inspect({d.view()}, joints());
  return report.refused() ? report.defects.front() : Defect{};
}

}  // namespace sanso::diagnose::test
