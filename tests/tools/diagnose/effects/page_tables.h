// The library as the tables of docs/model-folder.md.
#pragma once

#include <string>

namespace sanso::diagnose {

/// One row an effect: id, formula, where, parameters with unit, null and bounds.
std::string effect_table_markdown();
/// One row a setting of [joint_default] and [joint.<name>]: key, unit, default, range.
std::string settings_table_markdown();

}  // namespace sanso::diagnose
