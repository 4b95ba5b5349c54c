// docs/faults.md, made from the numbers, the reactions and the table of states in the code.
#pragma once

#include <string>

namespace sanso::firmware {

std::string faults_page();

}  // namespace sanso::firmware
