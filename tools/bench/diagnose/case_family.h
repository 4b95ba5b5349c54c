// What a case hides.
#pragma once

#include <optional>
#include <string>

namespace sanso::bench {

/// In the order of the tables: one of several that the data cannot tell apart, a defect of the
/// recordings, nothing, what the library does not have, two effects, one effect.
enum class CaseFamily { ambiguous, decoy, clean, outside, pair, single };

const char* to_string(CaseFamily family);
/// The same in the words of answer.json by other generators, to whom nothing is "null".
const char* in_answers(CaseFamily family);
/// From either spelling.
std::optional<CaseFamily> family_from_string(const std::string& name);

}  // namespace sanso::bench
