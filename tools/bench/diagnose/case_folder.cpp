// Reads cases that another generator made: the answers are data, no rule knows a case.
#include "tools/bench/diagnose/case_folder.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "shared/files/atomic_file.h"
#include "shared/files/input_error.h"

namespace sanso::bench {
namespace {

namespace fs = std::filesystem;
using diagnose::VerdictStatus;
using nlohmann::json;
using Names = std::vector<std::string>;

Names names_at(const json& object, const char* key) {
  return object.contains(key) && object.at(key).is_array() ? object.at(key).get<Names>() : Names{};
}

/// Of a verdict or a finding.
VerdictStatus status_at(const json& said) {
  const auto word = said.at("status").get<std::string>();
  const std::optional<VerdictStatus> status = diagnose::status_from_string(word);
  if (!status)
    throw files::InputError("verdict.json", 0, "status", "unknown status", word,
                            "a verdict as `sanso diagnose` writes it");
  return *status;
}

/// A number of an answer; 0 where it is missing or null: what a generator could not tell.
double number_at(const json& object, const char* part, const char* key) {
  if (!object.contains(part) || !object.at(part).is_object()) return 0.0;
  const json& of = object.at(part);
  return of.contains(key) && of.at(key).is_number() ? of.at(key).get<double>() : 0.0;
}

TrueParameter parameter_of(const std::string& name, const json& said) {
  TrueParameter out{{name}, {said.at("value").get<double>()}};
  for (const std::string& alias : names_at(said, "aliases")) out.names.push_back(alias);
  // another form is [value, null]
  const json forms = said.value("other_forms", json::array());
  for (const json& form : forms) out.values.push_back(form.at(0).get<double>());
  return out;
}

TrueEffect effect_of(const json& said) {
  TrueEffect out;
  out.id = said.at("id").get<std::string>();
  out.also = names_at(said, "also");
  if (!said.value("global", false)) {
    out.where_accept = names_at(said, "where_accept");
    if (out.where_accept.empty()) out.where_accept = names_at(said, "where");
  }
  const json parameters = said.value("parameters", json::object());
  for (const auto& [name, parameter] : parameters.items())
    if (parameter.value("compare", true)) out.parameters.push_back(parameter_of(name, parameter));
  return out;
}

[[noreturn]] void bad_file(const std::string& file, const std::string& why) {
  throw files::InputError(file, 0, "", why, "", "a case as docs/howto/conceal.md describes it");
}

CaseAnswer answer_of(const json& said, const std::string& file) {
  CaseAnswer out;
  const std::string family = said.at("family").get<std::string>();
  const std::optional<CaseFamily> known = family_from_string(family);
  if (!known) bad_file(file, "unknown family \"" + family + "\"");
  out.family = *known;
  out.robot = said.at("robot").get<std::string>();
  if (said.value("variant", "") == "torque") out.robot += "/torque";
  out.ratio = number_at(said, "severity", "achieved_snr");
  for (const json& effect : said.at("effects")) out.effects.push_back(effect_of(effect));
  out.one_of = names_at(said, "one_of");
  if (said.contains("decoy") && said.at("decoy").is_object())
    out.decoy_channels = names_at(said.at("decoy"), "channels");
  out.noise = number_at(said, "noise", "rms");
  out.oracle_explained = number_at(said, "oracle", "explained");
  return out;
}

bool is_recording(const fs::path& path) {
  const std::string name = path.filename().string();
  return name.starts_with("rec_") && (name.ends_with(".csv") || name.ends_with(".csv.gz"));
}

Names recordings_in(const fs::path& folder) {
  Names out;
  if (!fs::is_directory(folder)) return out;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder))
    if (is_recording(entry.path())) out.push_back(entry.path().string());
  std::sort(out.begin(), out.end());
  return out;
}

// --- judging -------------------------------------------------------------------------------------

bool contains(const Names& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

bool is_name_of(const TrueEffect& truth, const std::string& name) {
  return name == truth.id || contains(truth.also, name);
}

/// Ids that a finding stands for: its own and its set's.
Names set_of(const json& finding) {
  Names out = names_at(finding, "one_of");
  const std::string own = finding.at("effect").get<std::string>();
  if (!contains(out, own)) out.push_back(own);
  return out;
}

bool stands_at(const TrueEffect& truth, const json& finding) {
  const Names said = names_at(finding, "where");
  return truth.where_accept.empty() ||
         std::all_of(said.begin(), said.end(),
                     [&](const std::string& w) { return contains(truth.where_accept, w); });
}

/// The finding that names the effect; else one whose set holds it; else none.
const json* finding_of(const TrueEffect& truth, const json& findings) {
  for (const json& f : findings)
    if (is_name_of(truth, f.at("effect").get<std::string>())) return &f;
  for (const json& f : findings) {
    const Names ids = set_of(f);
    if (std::any_of(ids.begin(), ids.end(),
                    [&](const std::string& id) { return is_name_of(truth, id); }))
      return &f;
  }
  return nullptr;
}

/// Of the forms in which the truth may be written the one nearest to what was fitted counts.
void compare_parameters(const TrueEffect& truth, const json& finding, CaseJudgement& out) {
  const json fitted = finding.value("parameters", json::object());
  for (const TrueParameter& parameter : truth.parameters) {
    const auto name = std::find_if(parameter.names.begin(), parameter.names.end(),
                                   [&](const std::string& n) { return fitted.contains(n); });
    if (name == parameter.names.end()) continue;
    const json& value = fitted.at(*name);
    const double said = value.at("value").get<double>();
    const double wanted = *std::min_element(
        parameter.values.begin(), parameter.values.end(),
        [&](double a, double b) { return std::abs(said - a) < std::abs(said - b); });
    const std::string key = truth.id + "." + parameter.names.front();
    if (wanted != 0.0) out.relative_error[key] = std::abs(said - wanted) / std::abs(wanted);
    if (value.contains("low") && value.at("low").is_number() && value.at("high").is_number())
      out.covered[key] =
          value.at("low").get<double>() <= wanted && wanted <= value.at("high").get<double>();
  }
}

void judge_findings(const CaseAnswer& answer, const json& findings, CaseJudgement& out) {
  std::size_t hits = 0;
  out.in_set = out.place_right = !answer.effects.empty();
  for (const TrueEffect& truth : answer.effects) {
    const json* found = finding_of(truth, findings);
    out.in_set = out.in_set && found != nullptr;
    out.place_right = out.place_right && found != nullptr && stands_at(truth, *found);
    if (found == nullptr || !is_name_of(truth, found->at("effect").get<std::string>())) continue;
    ++hits;
    if (found->at("effect").get<std::string>() == truth.id) compare_parameters(truth, *found, out);
  }
  double sizes = 0.0;
  for (const json& f : findings) {
    sizes += static_cast<double>(set_of(f).size());
    const std::string name = f.at("effect").get<std::string>();
    const bool true_name = std::any_of(answer.effects.begin(), answer.effects.end(),
                                       [&](const TrueEffect& t) { return is_name_of(t, name); });
    out.wrong_confirmed +=
        f.contains("status") && status_at(f) == VerdictStatus::confirmed && !true_name;
    if (out.named.empty()) out.named_first = true_name;
    std::string places;
    for (const std::string& w : names_at(f, "where")) places += (places.empty() ? "" : ",") + w;
    out.named.push_back(name + "@" + places);
  }
  const double count = static_cast<double>(findings.size());
  const double total = static_cast<double>(answer.effects.size()) + count;
  out.set_size = findings.empty() ? 0.0 : sizes / count;
  out.f1 = total > 0.0 ? 2.0 * static_cast<double>(hits) / total : 0.0;
}

/// A channel of an answer ends in ":" where it means every joint.
bool names_channel(const Names& channels, const std::string& said) {
  return std::any_of(channels.begin(), channels.end(), [&](const std::string& c) {
    return said == c || (c.ends_with(":") && said.starts_with(c));
  });
}

bool right_answer(const CaseAnswer& answer, const json& findings, const CaseJudgement& j) {
  if (answer.family == CaseFamily::clean) return !j.detected && j.status == VerdictStatus::absent;
  if (answer.family == CaseFamily::decoy) return j.refused;
  if (answer.family == CaseFamily::ambiguous) {
    const Names set = findings.empty() ? Names{} : set_of(findings.front());
    return j.status == VerdictStatus::one_of && j.place_right && findings.size() == 1 &&
           std::all_of(answer.one_of.begin(), answer.one_of.end(),
                       [&](const std::string& id) { return contains(set, id); });
  }
  if (answer.family == CaseFamily::single || answer.family == CaseFamily::pair)
    return j.f1 == 1.0 && j.named_first && j.place_right;
  return j.unnamed;
}

}  // namespace

CaseAnswer parse_answer(const std::string& text, const std::string& file) {
  try {
    return answer_of(json::parse(text), file);
  } catch (const json::exception& error) {
    bad_file(file, error.what());
  }
}

std::vector<CaseFiles> read_cases(const std::string& folder) {
  std::vector<CaseFiles> out;
  if (!fs::is_directory(folder)) bad_file(folder, "no such folder");
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const fs::path answer = entry.path() / "answer.json";
    if (!fs::exists(answer)) continue;
    CaseFiles c;
    c.name = entry.path().filename().string();
    c.folder = entry.path().string();
    c.model = (entry.path() / "model").string();
    c.recordings = recordings_in(entry.path());
    c.heldout = recordings_in(entry.path() / "heldout");
    c.answer = parse_answer(files::read_text(answer), answer.string());
    if (c.recordings.empty()) bad_file(c.folder, "no rec_*.csv or rec_*.csv.gz");
    out.push_back(std::move(c));
  }
  if (out.empty()) bad_file(folder, "no sub-folder with an answer.json");
  std::sort(out.begin(), out.end(),
            [](const CaseFiles& a, const CaseFiles& b) { return a.name < b.name; });
  return out;
}

CaseJudgement judge(const CaseAnswer& answer, const std::string& verdict) {
  CaseJudgement out;
  try {
    const json said = json::parse(verdict);
    out.status = status_at(said);
    out.detected = said.at("mismatch").get<bool>();
    const json findings = said.value("findings", json::array());
    judge_findings(answer, findings, out);
    const json refusals = said.value("refused", json::array());
    for (const json& refused : refusals)
      out.refused =
          out.refused || (out.status == VerdictStatus::refused &&
                          names_channel(answer.decoy_channels, refused.value("channel", "")));
    out.unnamed = out.status == VerdictStatus::present_unnamed && out.wrong_confirmed == 0;
    out.right = right_answer(answer, findings, out);
  } catch (const json::exception& error) {
    throw files::InputError("verdict.json", 0, "", error.what(), "",
                            "a verdict as `sanso diagnose` writes it");
  }
  return out;
}

}  // namespace sanso::bench
