// What a judged term says to a person: its coefficients as numbers with intervals, and the other
// name for the same kilograms.
#pragma once

#include <optional>

#include "tools/diagnose/wholebody/drive_choice.h"

namespace sanso::diagnose {

/// The term with its coefficients as numbers that a person reads, and with what the size of it all
/// is sure by. `x`, `s`: coefficients and their standard deviations, in the term's own units.
JudgedDriveTerm with_numbers(const DriveTerm& t, const Eigen::VectorXd& x,
                             const Eigen::VectorXd& s);

/// A kilogram more of a link, and a kilogram that it carries no further from its centre than that
/// may be off, are the same.
std::optional<WholeFigure> twin_of(const DriveTerm& t, const JudgedDriveTerm& j);

}  // namespace sanso::diagnose
