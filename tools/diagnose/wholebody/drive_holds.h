// How often joints stand in one posture: friction that holds them there is one and the same.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tools/diagnose/wholebody/drive_track.h"

namespace sanso::diagnose {

/// By window, by joint: in how many windows the joint stands (a share of one where it moves in
/// part) within `zero` rad of where it is in this one; 1 at least. So often what holds it is
/// counted, and however long it stands it tells no more.
std::vector<Eigen::VectorXd> holds_alike(const std::vector<StandingWindow>& windows, double zero);

}  // namespace sanso::diagnose
