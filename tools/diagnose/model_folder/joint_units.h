// Units are written for turning joints throughout; a sliding joint has m for rad, N for N m, kg for
// kg m^2.
#pragma once

#include <string>
#include <string_view>
#include <utility>

namespace sanso::diagnose {

/// The unit or axis title as it reads at a joint: "rad/s" -> "m/s", "missing torque [N m]" ->
/// "missing force [N]".
inline std::string at_joint(std::string text, bool slides) {
  constexpr std::pair<std::string_view, std::string_view> sliding[] = {
      {"kg m^2", "kg"}, {"N m", "N"}, {"rad", "m"}, {"torque", "force"}};
  for (const auto& [turns, other] : sliding) {
    const std::size_t at = slides ? text.find(turns) : std::string::npos;
    if (at != std::string::npos) text.replace(at, turns.size(), other);
  }
  return text;
}

/// The unit of a figure where torque (force) is told in `unit`: "N m s/rad" in "A" -> "A s/rad".
inline std::string with_effort_in(std::string text, const std::string& unit) {
  for (const std::string_view newtons : {"N m", "N"})
    if (const std::size_t at = text.find(newtons); at != std::string::npos)
      return text.replace(at, newtons.size(), unit);
  return text;
}

}  // namespace sanso::diagnose
