// The controlled OP3 as a generic tree: the second witness of the specialised dynamics, and a start
// for tools that work on any robot.
#pragma once

#include "shared/model/step_model.h"
#include "tests/oracle/tree.h"

namespace sanso::model {

/// Floating base, twelve leg joints in the order of joints.h; armature from the servo parameters.
Tree op3_tree(const ModelParameters& theta);

}  // namespace sanso::model
