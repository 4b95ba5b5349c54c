// Finds a setting by its name among all that the settings show, and scales it.
#include "tools/bench/diagnose/scaled_setting.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <stdexcept>

#include "tools/diagnose/run/settings_page.h"

namespace sanso::bench {
namespace {

void scale(double& value, double factor) { value *= factor; }
void scale(int& value, double factor) {
  value = std::max(1, static_cast<int>(std::lround(value * factor)));
}

/// Calls f(value) for the setting of that name. Throws std::invalid_argument when there is none.
template <class F>
void at(diagnose::Settings& settings, const std::string& name, F&& f) {
  bool found = false;
  settings.visit([&](const std::string& group, auto& section) {
    section.visit([&](const char* key, auto& value, auto&&...) {
      if (name != group + "." + key) return;
      f(value);
      found = true;
    });
  });
  if (!found) {
    throw std::invalid_argument("no setting '" + name +
                                "'; they stand in docs/settings-diagnose.md");
  }
}

}  // namespace

diagnose::Settings scaled(diagnose::Settings settings, const std::string& assignment) {
  const std::size_t equals = assignment.find('=');
  const std::string name = assignment.substr(0, equals);
  const double factor =
      equals == std::string::npos ? 0.0 : std::atof(assignment.c_str() + equals + 1);
  if (!(factor > 0.0) || !std::isfinite(factor)) {
    throw std::invalid_argument("'" + assignment + "': expected NAME=FACTOR with a factor above 0");
  }
  at(settings, name, [factor](auto& value) { scale(value, factor); });
  diagnose::require_in_range(settings);
  return settings;
}

std::vector<std::string> setting_names() {
  std::vector<std::string> names;
  diagnose::Settings settings;
  settings.visit([&](const std::string& group, auto& section) {
    section.visit([&](const char* key, auto&&...) { names.push_back(group + "." + key); });
  });
  return names;
}

double value_of(diagnose::Settings settings, const std::string& name) {
  double out = 0.0;
  at(settings, name, [&out](auto& value) { out = static_cast<double>(value); });
  return out;
}

}  // namespace sanso::bench
