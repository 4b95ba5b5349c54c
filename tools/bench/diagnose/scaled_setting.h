// What half and double of a setting of the diagnosis does to its scores: one setting is scaled
// before the cases are run.
#pragma once

#include <string>
#include <vector>

#include "tools/diagnose/settings.h"

namespace sanso::bench {

/// `settings` with one of them scaled: "decisions.family_wise=0.5" halves that level; whole numbers
/// are rounded and stay at least 1. Throws std::invalid_argument when the name is unknown, the
/// factor is no positive number, or the result leaves the setting's range.
diagnose::Settings scaled(diagnose::Settings settings, const std::string& assignment);

/// "group.name" of every setting, in the order of the settings page.
std::vector<std::string> setting_names();

/// Of the setting of that name. Throws std::invalid_argument when there is none.
double value_of(diagnose::Settings settings, const std::string& name);

}  // namespace sanso::bench
