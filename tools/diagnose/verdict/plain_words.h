// The answer for a reader who knows robots and not this tool: one paragraph.
#pragma once

#include <string>
#include <vector>

#include "tools/diagnose/verdict/verdict.h"

namespace sanso::diagnose {

/// What is missing, where, how sure that is, how much better predictions become, and what to
/// record next. Says nothing that the verdict's other fields do not.
std::string plain_words(const Verdict& verdict);

/// "knee, hip"; "the whole robot" where there is no place.
std::string places(const std::vector<std::string>& where);

/// A finding in one phrase of the library's ids: "one of {backlash, joint_compliance} at knee".
std::string sentence(const Finding& finding);

}  // namespace sanso::diagnose
