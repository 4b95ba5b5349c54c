// What the report shows of recordings and model: which joints, their roll-outs on held-out data,
// and the shape of their missing torque.
#pragma once

#include <string>
#include <vector>

#include "tools/diagnose/run/shown_motion.h"
#include "tools/diagnose/verdict/evidence.h"
#include "tools/diagnose/verdict/verdict.h"

namespace sanso::diagnose {

/// One roll-out on held-out data: measured, nominal, patched position of a joint. Shots one after
/// the other, a NaN between them.
struct RollOut {
  std::string recording, joint;
  std::vector<double> t, measured, nominal, patched;
  double noise = 0.0;
};

/// The joints worth showing: those of findings and of what is unexplained, at most three; else the
/// one where the map is strongest.
std::vector<std::size_t> joints_to_show(const Verdict& verdict, const RobotTree& tree);

/// Roll-outs of 2 s from the measured state, the first four of the first recording held out, by
/// joint of `joints`; empty when the held-out part is too short.
std::vector<RollOut> roll_outs(const Simulated& simulated, const std::vector<std::size_t>& joints);

/// Shape curves of a model's missing torque, by joint of `joints`.
std::vector<std::vector<ShapeCurve>> curves_of(const std::vector<TorqueSample>& missing,
                                               const std::vector<std::size_t>& joints);

}  // namespace sanso::diagnose
