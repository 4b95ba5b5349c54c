// Which of turn and bias what an IMU reads needs. Gravity alone shows either as the other, and both
// together as nothing: sizes of a fit of all do not decide it.
#pragma once

#include "tools/diagnose/wholebody/answers.h"
#include "tools/diagnose/wholebody/imu_mount.h"

namespace sanso::diagnose {

struct ImuChoice {
  ImuParts parts;            // neither: nothing is named
  bool turn_rivals = false;  // a turn alone predicts what was left out as well
  bool bias_rivals = false;  // a bias alone does
};

/// By left-out groups, each third in its turn: one part first, by itself, and the other beside it
/// only where that predicts better still. Two faults that cancel each other are a coincidence that
/// nothing but themselves speaks for.
ImuChoice choose_parts(const std::vector<ImuWindow>& windows, const Chance& chance);

}  // namespace sanso::diagnose
