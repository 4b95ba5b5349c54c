// Compares sets of names and places, then parameters; writes the score as JSON and prints what a
// person wants to know.
#include "tools/conceal/reveal.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "shared/files/atomic_file.h"
#include "shared/files/input_error.h"
#include "tools/conceal/seal.h"
#include "tools/plant/world_error.h"

namespace sanso::conceal {
namespace {

using nlohmann::json;

std::vector<std::uint8_t> bytes_of(const std::string& path) {
  try {
    return files::read_file(path);
  } catch (const files::InputError& error) {
    throw plant::WorldError(error.what());
  }
}

std::vector<std::string> strings(const json& object, const char* key) {
  return object.contains(key) ? object.at(key).get<std::vector<std::string>>()
                              : std::vector<std::string>{};
}

/// Effect ids that a finding stands for: its own and its set's.
std::set<std::string> set_of(const json& finding) {
  const auto others = strings(finding, "one_of");
  std::set<std::string> ids(others.begin(), others.end());
  ids.insert(finding.at("effect").get<std::string>());
  return ids;
}

bool same_place(const std::vector<std::string>& truth, const std::vector<std::string>& said) {
  return truth.empty() ||
         std::set(truth.begin(), truth.end()) == std::set(said.begin(), said.end());
}

void compare_parameters(const json& effect, const json& finding, Score& score) {
  if (!finding.contains("parameters")) return;
  for (const auto& [name, value] : effect.at("parameters").items()) {
    if (!finding.at("parameters").contains(name)) continue;
    const double truth = value.get<double>();
    const json& fitted = finding.at("parameters").at(name);
    const std::string key = effect.at("id").get<std::string>() + "." + name;
    if (truth != 0)
      score.relative_error[key] =
          std::abs(fitted.at("value").get<double>() - truth) / std::abs(truth);
    if (!fitted.contains("low") || !fitted.at("low").is_number() || !fitted.at("high").is_number())
      continue;
    const auto low = fitted.at("low").get<double>(), high = fitted.at("high").get<double>();
    // a form or an order that was chosen is told without an interval
    if (low < high) score.covered[key] = low <= truth && truth <= high;
  }
}

bool holds(const std::vector<std::string>& ids, const std::string& id) {
  return std::find(ids.begin(), ids.end(), id) != ids.end();
}

void count_confirmed(const json& findings, Score& score) {
  for (const json& finding : findings) {
    if (finding.value("status", "") != "CONFIRMED") continue;
    const std::string id = finding.at("effect").get<std::string>();
    ++score.confirmed;
    score.wrong_confirmed += !holds(score.truth, id) && !holds(score.beside, id);
  }
}

void score_effects(const json& answer, const json& findings, Score& score) {
  score.in_set = score.where_exact = !score.truth.empty();
  std::size_t hits = 0;
  for (const json& effect : answer.at("effects")) {
    const std::string id = effect.at("id").get<std::string>();
    const json* match = nullptr;
    bool by_name = false;
    for (const json& finding : findings) {
      const bool exact = finding.at("effect").get<std::string>() == id;
      if (exact || (!match && set_of(finding).contains(id))) {
        match = &finding;
        by_name = exact;
        if (exact) break;
      }
    }
    hits += by_name;
    score.in_set = score.in_set && match != nullptr;
    score.where_exact = score.where_exact && match &&
                        same_place(strings(effect, "where"), strings(*match, "where"));
    if (match && by_name) compare_parameters(effect, *match, score);
  }
  double sizes = 0;
  for (const json& finding : findings) sizes += static_cast<double>(set_of(finding).size());
  score.set_size = findings.empty() ? 0 : sizes / static_cast<double>(findings.size());
  score.named_first = !score.named.empty() && holds(score.truth, score.named[0]);
  const auto brought_along = std::count_if(
      score.named.begin(), score.named.end(),
      [&](const std::string& id) { return holds(score.beside, id) && !holds(score.truth, id); });
  const double total = static_cast<double>(score.truth.size() + score.named.size()) -
                       static_cast<double>(brought_along);
  score.f1 = total > 0 ? 2.0 * static_cast<double>(hits) / total : 0;
}

void score_decoy(const json& answer, const json& verdict, Score& score) {
  if (!verdict.contains("refused")) return;
  for (const json& refused : verdict.at("refused")) {
    const std::string file = refused.value("file", "");
    const bool same_file = file.ends_with(answer.at("decoy").at("file").get<std::string>());
    // a copy shows in two files; either may be called the copy
    const std::string defect = answer.at("decoy").at("defect").get<std::string>();
    score.refused_by_name =
        score.refused_by_name ||
        (refused.value("defect", "") == defect && (same_file || defect == "copy of another file"));
  }
}

/// Outside the library: said so, and pointed at the right joint.
void score_outside(const json& answer, const json& verdict, Score& score) {
  const std::string joint = answer.at("effects").at(0).at("where").at(0).get<std::string>();
  const bool placed_by_rest = verdict.contains("unexplained") &&
                              verdict.at("unexplained").is_object() &&
                              verdict.at("unexplained").value("where", "") == joint;
  const bool placed_by_map = verdict.contains("locations") && !verdict.at("locations").empty() &&
                             verdict.at("locations").at(0).value("where", "") == joint;
  score.where_exact = placed_by_rest || placed_by_map;
  score.unnamed = score.status == "PRESENT_UNNAMED" && score.where_exact;
}

Family family_of(const json& answer) {
  const std::string name = answer.at("family").get<std::string>();
  const std::optional<Family> family = family_from_string(name);
  if (!family) {
    throw plant::WorldError("answer.sealed: family \"" + name +
                            "\" is none that conceal makes; was the case made by another version?");
  }
  return *family;
}

bool right_answer(const Score& score) {
  switch (score.family) {
    case Family::clean:
      return !score.detected && score.status == "ABSENT";
    case Family::decoy:
      return score.status == "REFUSED" && score.refused_by_name;
    case Family::outside:
      return score.unnamed;
    case Family::ambiguous:
      return score.in_set && score.status == "ONE_OF";
    case Family::single:
    case Family::pair:
      break;
  }
  return score.in_set;
}

}  // namespace

Score reveal(const std::string& directory, const std::string& verdict_file) {
  const std::vector<std::uint8_t> bytes = bytes_of(directory + "/answer.sealed");
  const json answer = json::parse(open_seal(bytes));
  json verdict;
  Score score;
  score.hash = seal_hash(bytes);
  try {
    verdict = json::parse(bytes_of(verdict_file));
    score.status = verdict.at("status").get<std::string>();
    score.detected = verdict.at("mismatch").get<bool>();
    const json findings = verdict.value("findings", json::array());
    for (const json& finding : findings)
      score.named.push_back(finding.at("effect").get<std::string>());
    score.robot = answer.at("robot").get<std::string>();
    score.family = family_of(answer);
    score.ratio_target = answer.at("ratio_target").get<double>();
    for (const json& effect : answer.at("effects")) {
      score.truth.push_back(effect.at("id").get<std::string>());
      score.ratios.push_back(effect.at("ratio").get<double>());
      const json beside = effect.value("beside", json::object());
      for (const auto& [id, size] : beside.items()) score.beside.push_back(id);
    }
    score_effects(answer, findings, score);
    count_confirmed(findings, score);
    if (answer.contains("decoy")) score_decoy(answer, verdict, score);
    if (score.family == Family::outside) score_outside(answer, verdict, score);
  } catch (const json::exception& error) {
    throw plant::WorldError(verdict_file + ": no verdict as diagnose writes it: " + error.what());
  }
  score.right = right_answer(score);
  return score;
}

std::string to_json(const Score& s) {
  json out{{"robot", s.robot},
           {"family", to_string(s.family)},
           {"ratio_target", s.ratio_target},
           {"truth", s.truth},
           {"ratios", s.ratios},
           {"status", s.status},
           {"beside", s.beside},
           {"named", s.named},
           {"confirmed", s.confirmed},
           {"wrong_confirmed", s.wrong_confirmed},
           {"detected", s.detected},
           {"named_first", s.named_first},
           {"in_set", s.in_set},
           {"set_size", s.set_size},
           {"where_exact", s.where_exact},
           {"f1", s.f1},
           {"refused_by_name", s.refused_by_name},
           {"unnamed", s.unnamed},
           {"right", s.right},
           {"relative_error", s.relative_error},
           {"covered", s.covered},
           {"hash", s.hash}};
  return out.dump(2);
}

}  // namespace sanso::conceal
