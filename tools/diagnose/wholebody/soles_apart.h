// Two soles on one floor lie alike, whatever the floor, the attitude and the weights: only joints
// that read wrong turn one against the other.
#pragma once

#include <optional>

#include "tools/diagnose/wholebody/floating_tree.h"
#include "tools/diagnose/wholebody/whole_data.h"

namespace sanso::diagnose {

/// How far two soles lean apart, rad, about two axes across their common normal, and what a radian
/// at each joint would make of it: 2 x joints.
struct SolesApart {
  Eigen::Vector2d lean = Eigen::Vector2d::Zero();
  Eigen::MatrixXd by_zero;
};

/// Nothing where a foot has no flat face below. Leaves `tree` at `motion`.
std::optional<SolesApart> soles_apart(const WholeBody& body, FloatingTree& tree,
                                      const FloatingMotion& motion, const FootForce& one,
                                      const FootForce& other);

}  // namespace sanso::diagnose
