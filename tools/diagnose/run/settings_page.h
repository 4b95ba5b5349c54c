// The settings of the diagnosis for people: docs/settings-diagnose.md, and what is said of a value
// outside its range.
#pragma once

#include <string>

#include "tools/diagnose/settings.h"

namespace sanso::diagnose {

/// The text of docs/settings-diagnose.md.
std::string settings_page();

/// Throws std::invalid_argument with name, value, range and unit of the first setting that is
/// outside its range or no number.
void require_in_range(Settings settings);

}  // namespace sanso::diagnose
