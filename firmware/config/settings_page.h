// docs/settings.md, made from the settings structs.
#pragma once

#include <string>

namespace sanso::firmware {

std::string settings_page();

}  // namespace sanso::firmware
