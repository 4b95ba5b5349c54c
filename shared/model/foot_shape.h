// What the robot stands on: its soles, or skates below them. Plain figures for kernels, estimator
// and references alike.
#pragma once

#include "shared/model/op3_table.h"

namespace sanso::model {

/// Four points below each foot, symmetric about the sole's centre, ankle-roll axes.
struct FootShape {
  double height;        // m, of the points: where soles or wheels touch
  double half_length;   // m, of a skate: half its wheelbase
  double half_width;    // m, of a skate: half its track
  bool wheels = false;  // roll along the foot's x axis
};

/// Centre of the points of the left foot [m]; of the right one with -y.
inline constexpr double kSoleCentreX = 0.5 * (kSoleFront + kSoleBack);
inline constexpr double kSoleCentreY = 0.5 * (kSoleOuter + kSoleInner);

inline constexpr FootShape kSoles{kSoleHeight, 0.5 * (kSoleFront - kSoleBack),
                                  0.5 * (kSoleOuter - kSoleInner)};

/// Skates as one would screw them on: wheels of 12 mm radius, wheelbase 85 mm, track 55 mm, 50 g a
/// foot.
inline constexpr double kWheelRadius = 0.012;  // m
inline constexpr double kSkateMass = 0.050;    // kg
inline constexpr FootShape kSkates{kSoleHeight - 2 * kWheelRadius, 0.0425, 0.0275, true};

}  // namespace sanso::model
