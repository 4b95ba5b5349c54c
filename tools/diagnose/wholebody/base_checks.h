// What can be wrong with the channels of a floating base: units, orders and axes are told from
// each other by what must agree.
#pragma once

#include <vector>

#include "tools/diagnose/wholebody/whole_data.h"

namespace sanso::diagnose {

/// Base, IMU and foot columns before anything is made of them: whole sets, finite, known links.
std::vector<Defect> check_base_columns(const recording::Recording& r, const WholeBody& body,
                                       const Settings& settings);

/// Quaternion against angular velocity, position against velocity, forces against weight.
std::vector<Defect> check_base_agreement(const recording::Recording& r, const WholeRecording& made,
                                         const WholeBody& body, const Settings& settings);

/// Joints without a q: column, and the share of the robot's mass behind them.
struct Unrecorded {
  std::vector<std::string> joints;
  double mass_share = 0.0;
};
/// A link is behind a joint that lies anywhere between it and the base.
Unrecorded unrecorded_joints(const recording::Recording& r, const WholeBody& body);

}  // namespace sanso::diagnose
