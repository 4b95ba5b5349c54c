// CONFIRMED, or a set whose names are the same figures: any other set would put one of its names
// where another may be right.
#include "host/app/adopt.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "host/learn/model/named_figures.h"
#include "shared/files/json.h"

namespace sanso::app {
namespace {

using Json = nlohmann::json;

[[noreturn]] void no_verdict(const std::filesystem::path& file, const std::string& why) {
  throw std::runtime_error(fmt::format(
      "{}: {}; expected the verdict.json that sanso diagnose --out wrote", file.string(), why));
}

Json read(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file)) no_verdict(file, "no such file");
  Json verdict = files::json_or_null(file);
  if (!verdict.is_object() || !verdict.contains("findings") || !verdict["findings"].is_array())
    no_verdict(file, "no findings in it");
  return verdict;
}

learn::NamedFigure figure_of(const Json& finding) {
  learn::NamedFigure out;
  out.effect = finding.at("effect").get<std::string>();
  out.where = finding.at("where").get<std::vector<std::string>>();
  for (const auto& [name, parameter] : finding.at("parameters").items())
    out.parameters[name] = parameter.at("value").get<double>();
  return out;
}

std::string text_of(const learn::NamedFigure& figure) {
  std::string out = figure.effect;
  for (std::size_t i = 0; i < figure.where.size(); ++i)
    out += (i == 0 ? " at " : ", ") + figure.where[i];
  const char* before = ": ";
  for (const auto& [name, value] : figure.parameters)
    out += fmt::format("{}{} {:.6g}", before, name, value), before = ", ";
  return out;
}

/// Names for the same kilograms at the same place: whichever is right, the model is the same one.
bool alike(const Json& finding) {
  const auto elsewhere = [&](const Json& rival) { return rival.at("where") != finding["where"]; };
  const Json none = Json::array();
  const Json rivals = finding.value("rivals", none), names = finding.value("one_of", none);
  const auto kilograms = [](const Json& name) {
    const learn::KnownFigure* known =
        name.is_string() ? learn::known_figure(name.get<std::string>()) : nullptr;
    return known != nullptr && known->kilograms;
  };
  return names.size() > 1 && std::none_of(rivals.begin(), rivals.end(), elsewhere) &&
         std::all_of(names.begin(), names.end(), kilograms);
}

}  // namespace

Adoption adopt(const std::filesystem::path& file, model::ModelParameters& theta) {
  Adoption out;
  const Json verdict = read(file);
  for (const Json& finding : verdict["findings"]) {
    try {
      const learn::NamedFigure figure = figure_of(finding);
      const std::string status = finding.at("status").get<std::string>();
      const std::string why = status == "CONFIRMED" || (status == "ONE_OF" && alike(finding))
                                  ? put_figure(figure, theta)
                                  : "its status is " + status;
      if (why.empty())
        out.adopted.push_back(text_of(figure));
      else
        out.left.push_back(text_of(figure) + " (" + why + ")");
    } catch (const Json::exception& error) {
      no_verdict(file, error.what());
    }
  }
  return out;
}

std::string told(const Adoption& adoption) {
  std::string out;
  for (const std::string& line : adoption.adopted) out += "adopted: " + line + "\n";
  for (const std::string& line : adoption.left) out += "not adopted: " + line + "\n";
  return out.empty() ? "nothing to adopt: the verdict has no findings\n" : out;
}

}  // namespace sanso::app
