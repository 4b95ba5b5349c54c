// The IMU's readings as a rotation of what the base's motion predicts, plus biases.
#pragma once

#include <optional>
#include <vector>

#include "tools/diagnose/settings_of_whole.h"
#include "tools/diagnose/wholebody/kinematics.h"

namespace sanso::diagnose {

/// Means over one window, in the axes in which the IMU is assumed.
struct ImuWindow {
  V3 acc_predicted = V3::Zero(), acc = V3::Zero();    // specific force, m/s^2
  V3 gyro_predicted = V3::Zero(), gyro = V3::Zero();  // rad/s
  bool with_gyro = false;
  std::size_t group = 0;
};

struct ImuMount {
  M3 turn = M3::Identity();  // reading = turn * predicted + bias
  V3 acc_bias = V3::Zero(), gyro_bias = V3::Zero();
  double acc_rms = 0.0, gyro_rms = 0.0;  // of what is left
};

/// What may be off; the gyroscope's bias always may.
struct ImuParts {
  bool turn = true, acc_bias = true;
};

/// Least squares with outliers (`imu_outlier`) weighed down. A bias is drawn to zero as far as it
/// is usually found (`acc_bias`, `gyro_bias`): at one attitude nothing else tells it from a tilt.
ImuMount fit_mount(const std::vector<ImuWindow>& windows, const WholeSettings& settings,
                   const ImuParts& parts = {});

/// Standard deviations of what a mount leaves, one axis of a window: m/s^2, rad/s.
struct ImuNoise {
  double acc = 1.0, gyro = 1.0;
};
/// Robust (median of the sizes); no less than 1e-6 m/s^2, 1e-7 rad/s; 1 where there are no windows.
ImuNoise noise_of(const std::vector<ImuWindow>& windows, const ImuMount& mount);

/// What a mount leaves of a window, in squared deviations; beyond `outlier` deviations it grows
/// with the size alone (Huber).
double loss_of(const ImuWindow& window, const ImuMount& mount, const ImuNoise& noise,
               double outlier);

/// What is left by a mount, RMS over windows: specific force, m/s^2.
double acc_error(const std::vector<ImuWindow>& windows, const ImuMount& mount);

}  // namespace sanso::diagnose
