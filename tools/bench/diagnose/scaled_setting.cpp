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

}  // namespace

diagnose::Settings scaled(diagnose::Settings settings, const std::string& assignment) {
  const std::size_t equals = assignment.find('=');
  const std::string name = assignment.substr(0, equals);
  const double factor =
      equals == std::string::npos ? 0.0 : std::atof(assignment.c_str() + equals + 1);
  if (!(factor > 0.0) || !std::isfinite(factor)) {
    throw std::invalid_argument("'" + assignment + "': expected NAME=FACTOR with a factor above 0");
  }
  bool found = false;
  settings.visit([&](const std::string& group, auto& section) {
    section.visit([&](const char* key, auto& value, auto&&...) {
      if (name != group + "." + key) return;
      scale(value, factor);
      found = true;
    });
  });
  if (!found) {
    throw std::invalid_argument("no setting '" + name +
                                "'; they stand in docs/settings-diagnose.md");
  }
  diagnose::require_in_range(settings);
  return settings;
}

}  // namespace sanso::bench
