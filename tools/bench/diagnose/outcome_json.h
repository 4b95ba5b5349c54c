// Outcomes of cases as JSON and back: what a stopped run goes on with, and what scripts read.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>

#include "tools/bench/diagnose/folder_bench.h"

namespace sanso::diagnose {

inline void to_json(nlohmann::json& out, VerdictStatus status) { out = to_string(status); }
/// Throws std::out_of_range for a status that there is not.
inline void from_json(const nlohmann::json& in, VerdictStatus& status) {
  const auto word = in.get<std::string>();
  const std::optional<VerdictStatus> known = status_from_string(word);
  if (!known) throw std::out_of_range("unknown status \"" + word + "\"");
  status = *known;
}

}  // namespace sanso::diagnose

namespace sanso::bench {

inline void to_json(nlohmann::json& out, CaseFamily family) { out = in_answers(family); }
/// Throws std::out_of_range for a family that there is not.
inline void from_json(const nlohmann::json& in, CaseFamily& family) {
  const auto name = in.get<std::string>();
  const std::optional<CaseFamily> known = family_from_string(name);
  if (!known) throw std::out_of_range("unknown family \"" + name + "\"");
  family = *known;
}
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(CaseJudgement, status, named, detected, named_first, in_set,
                                   place_right, refused, unnamed, right, wrong_confirmed, f1,
                                   set_size, relative_error, covered)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(CaseOutcome, name, family, robot, ratio, seconds, cpu_seconds,
                                   truth, said, proved, explained, explained_bounded,
                                   oracle_explained)

}  // namespace sanso::bench
