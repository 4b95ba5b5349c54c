// Words and units that several sections of the diagnosis report use.
#pragma once

#include <string>
#include <vector>

#include "tools/diagnose/run/diagnose.h"

namespace sanso::diagnose {

/// Lines of at most `width` characters, broken at spaces; ends with a line's end.
std::string wrapped(const std::string& text, std::size_t width);

/// The parts with commas between; `empty` where there is none.
std::string joined(const std::vector<std::string>& parts, const char* empty);

/// The library's name of an effect in words, with the id that model.toml and verdict.json use.
std::string in_words(const std::string& id);

/// Unit of an error over all joints.
std::string position_unit(const Diagnosis& d);

/// Whether a joint is prismatic; a name that is no joint is not.
bool slides_of(const Diagnosis& d, const std::string& joint);

}  // namespace sanso::diagnose
