// Each group against the weighted mean of all others.
#include "tools/diagnose/torque/disagreement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/diagnose/stats/significance.h"

namespace sanso::diagnose {
namespace {

/// Weighted mean of all but `left_out`, and its deviation.
GroupValue others(const std::vector<GroupValue>& values, std::size_t left_out) {
  double weight = 0.0, sum = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i == left_out) continue;
    const double w = 1.0 / (values[i].sigma * values[i].sigma);
    weight += w, sum += w * values[i].value;
  }
  return {"", sum / weight, std::sqrt(1.0 / weight)};
}

}  // namespace

std::string disagreement(const std::string& what, const std::string& unit,
                         const std::vector<GroupValue>& all, const DecisionSettings& decisions) {
  std::vector<GroupValue> values;  // what a group does not tell is no other opinion
  for (const GroupValue& v : all) {
    if (std::isfinite(v.value) && std::isfinite(v.sigma) && v.sigma > 0.0) values.push_back(v);
  }
  if (values.size() < 2) return "";
  bool apart = false;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const GroupValue rest = others(values, i);
    const double distance = std::abs(values[i].value - rest.value);
    const double size = std::max(std::abs(values[i].value), std::abs(rest.value));
    apart = apart ||
            (distance > 2.0 * decisions.standard_errors * std::hypot(values[i].sigma, rest.sigma) &&
             distance > decisions.same_robot * size);
  }
  if (!apart) return "";
  std::string text = "recordings disagree about " + what + ":";
  for (std::size_t i = 0; i < values.size(); ++i) {
    const GroupValue& v = values[i];
    text +=
        fmt::format("{} {:.3g} [{:.3g}, {:.3g}] {} in {}", i == 0 ? "" : ";", v.value,
                    v.value - kNormal95 * v.sigma, v.value + kNormal95 * v.sigma, unit, v.group);
  }
  return text;
}

}  // namespace sanso::diagnose
