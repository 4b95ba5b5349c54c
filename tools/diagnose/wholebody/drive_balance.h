// Rows of drives and links, and the terms they need, made again about what was found.
#pragma once

#include "tools/diagnose/wholebody/drive_choice.h"

namespace sanso::diagnose {

/// Whether a joint moves in enough windows (stance.moved) to show its friction.
bool moves(const Asking& asking, const DriveRows& rows, Eigen::Index joint);

/// By the figures of a fit: what rows are made again with.
DriveGuess guess_of(const Asking& asking, const DriveRows& rows, const Eigen::VectorXd& figures);

struct DriveBalance {
  DriveRows rows;
  DriveChoice choice;  // nothing where rows say why not
};
/// Rows and the terms they need; both again with what moving joints said of their friction, which
/// is all that may hold them when they stand, and where terms scale the torques, or shift the
/// goals, that rows were made with.
DriveBalance balance_drives(const Asking& asking);

}  // namespace sanso::diagnose
