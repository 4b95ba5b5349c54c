// The robot of a case: its nominal figures, and how far the one that was built is off them. Every
// case has tolerances, clean ones too, and nearly every one dry friction.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "tools/conceal/hidden_world.h"

namespace sanso::conceal {

/// The nominal joint of a case: 9 in 10 have dry friction of 0.04 to 0.16 N m, the others nearly
/// none.
JointTruth nominal_joint(Random& random);

/// Formulas by which the hidden world moves, each drawn by itself.
Formulas draw_formulas(Random& random);
/// As the answer says them.
nlohmann::json to_json(const Formulas& formulas);

/// The robot as it was really built: every figure of the nominal model uniformly inside its
/// tolerance.
WorldTruth built_world(const RobotSpec& nominal, const JointTruth& joint, Random& random);

/// By how much, relative to the nominal model (zero: rad, lag: s): lists by link and joint.
nlohmann::json tolerances(const WorldTruth& built, const RobotSpec& nominal,
                          const JointTruth& joint);

}  // namespace sanso::conceal
