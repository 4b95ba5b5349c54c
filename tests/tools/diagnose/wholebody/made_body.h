// Recordings of floating bodies by formulas that share nothing with tools/diagnose/wholebody.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "tools/diagnose/stats/random.h"
#include "tools/diagnose/wholebody/diagnose_whole.h"

namespace sanso::diagnose::test {

inline constexpr const char* kBall = R"(<robot name="ball"><link name="ball">
<inertial><mass value="0.5"/><inertia ixx="5e-4" ixy="0" ixz="0" iyy="5e-4" iyz="0" izz="5e-4"/>
</inertial><collision><geometry><sphere radius="0.05"/></geometry></collision></link></robot>)";

/// A trunk on two legs that slide, each with a flat foot.
inline constexpr const char* kTwoLegs = R"(<robot name="two"><link name="trunk"><inertial>
<origin xyz="0.01 0 0.1"/><mass value="4"/>
<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.01"/></inertial></link>
<joint name="l" type="prismatic"><parent link="trunk"/><child link="l_foot"/>
<origin xyz="0 0.1 -0.3"/><axis xyz="0 0 1"/>
<limit lower="-0.2" upper="0.2" effort="50" velocity="2"/></joint>
<link name="l_foot"><inertial><mass value="0.5"/>
<inertia ixx="1e-3" ixy="0" ixz="0" iyy="1e-3" iyz="0" izz="1e-3"/></inertial>
<collision><geometry><box size="0.2 0.1 0.02"/></geometry></collision></link>
<joint name="r" type="prismatic"><parent link="trunk"/><child link="r_foot"/>
<origin xyz="0 -0.1 -0.3"/><axis xyz="0 0 1"/>
<limit lower="-0.2" upper="0.2" effort="50" velocity="2"/></joint>
<link name="r_foot"><inertial><mass value="0.5"/>
<inertia ixx="1e-3" ixy="0" ixz="0" iyy="1e-3" iyz="0" izz="1e-3"/></inertial>
<collision><geometry><box size="0.2 0.1 0.02"/></geometry></collision></link></robot>)";

inline WholeBody body_of(const std::string& more, const char* urdf) {
  return parse_whole_body("format = 1\n[robot]\nbase = \"floating\"\n" + more, urdf, "model.toml");
}

inline void put(recording::Recording& r, const std::string& kind, const std::string& parts,
                const std::function<double(std::size_t row, std::size_t part)>& value) {
  for (std::size_t i = 0; i < parts.size(); ++i) {
    std::vector<double> column(r.rows());
    for (std::size_t k = 0; k < r.rows(); ++k) column[k] = value(k, i);
    r.set(kind + ":" + parts[i], column);
  }
}

inline double part_of(const Eigen::Quaterniond& q, std::size_t i) {
  return i == 0 ? q.w() : i == 1 ? q.x() : i == 2 ? q.y() : q.z();
}

inline WholeDiagnosis diagnosed(const WholeBody& body,
                                const std::vector<recording::Recording>& recordings) {
  const WholeOptions options;
  return diagnose_whole(options, body, judge_whole(recordings, body, options.settings),
                        [](const std::string&) {});
}

inline const Finding* find(const Verdict& v, const std::string& effect) {
  for (const Finding& f : v.findings) {
    if (f.effect == effect) return &f;
  }
  return nullptr;
}

/// For messages of failures.
inline std::string told(const Verdict& v) {
  std::string out = v.answer;
  for (const std::string& note : v.notes) out += "\n  " + note;
  return out;
}

/// What it is of a finding, and whether its interval holds it.
inline bool holds(const VerdictParameter& p, double truth) {
  // the interval is of 95 %; one draw more is forgiven
  const double wider = 0.5 * (p.high - p.low);
  return p.low - wider <= truth && truth <= p.high + wider;
}

}  // namespace sanso::diagnose::test
