// Documented twins: the names that may rightly stand for an effect. Data in which only one of the
// two acts need not tell them apart.
#pragma once

#include <string_view>
#include <vector>

namespace sanso::diagnose {

/// `name` for what is `truth`: the library lists it among the look-alikes of `truth`
/// (Effect::confounders), or it is `truth` for some of its parameters (Effect::contains). Not the
/// other way round: a special case is no twin of what contains it unless it is listed. Library ids;
/// unknown ones have no twins.
bool documented_twin(std::string_view name, std::string_view truth);

/// All documented twins of an effect, in the order of the library.
std::vector<std::string_view> documented_twins(std::string_view truth);

}  // namespace sanso::diagnose
