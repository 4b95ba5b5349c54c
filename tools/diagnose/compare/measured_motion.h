// The motion that a recording shows: smoothed positions and velocities, from which simulations
// start.
#pragma once

#include <vector>

#include "tools/diagnose/settings.h"
#include "tools/diagnose/sim/drive.h"
#include "tools/diagnose/sim/simulator.h"

namespace sanso::diagnose {

/// Standard deviation of a position sample: second differences (robust), at least what the
/// encoder's steps give.
double position_noise(const std::vector<double>& q);

/// Smoothed motion of every joint; isolated single-sample glitches are left out.
MeasuredMotion measured_motion(const Drive& drive, const Settings& settings);

/// Windows of `seconds` that tile the recording, each starting at the measured state; one window
/// when seconds is infinite. Pieces shorter than half a window at the end are left out unless they
/// are the only one.
std::vector<Window> tiled_windows(const Drive& drive, const MeasuredMotion& motion, double seconds);

}  // namespace sanso::diagnose
