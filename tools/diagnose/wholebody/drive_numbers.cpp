// Scales of a torque are read as their inverse, first moments over the mass; a nominal model's
// tolerance goes into every interval.
#include "tools/diagnose/wholebody/drive_numbers.h"

#include <algorithm>
#include <cmath>

#include "tools/diagnose/stats/significance.h"

namespace sanso::diagnose {

JudgedDriveTerm with_numbers(const DriveTerm& t, const Eigen::VectorXd& x,
                             const Eigen::VectorXd& s) {
  JudgedDriveTerm j;
  j.term = t;
  // in the direction in which it is most certain that there is something
  const Eigen::Index first = t.carried ? 1 : t.size();
  const Eigen::VectorXd surest =
      x.head(first).cwiseQuotient(s.head(first).cwiseAbs2().cwiseMax(1e-300)).normalized();
  j.size = std::abs(surest.dot(x.head(first)));
  j.sigma = surest.cwiseProduct(s.head(first)).norm();
  for (Eigen::Index i = 0; i < t.size(); ++i) {
    // a nominal model is wrong by its tolerances, which go into what is found
    double value = x[i] + t.nothing, off = std::hypot(s[i], 0.5 * t.tolerance);
    if (t.inverse) {
      value = 1.0 / (1.0 - x[i]), off *= value * value;
    } else if (t.carried && i > 0) {
      value = t.centre[i - 1] + x[i] / x[0];
      off = std::hypot(s[i], s[0] * x[i] / x[0]) / x[0];
    } else if (t.mass > 0.0) {
      value /= t.mass, off /= t.mass;
    }
    j.parameters.push_back({value, value - kNormal95 * off, value + kNormal95 * off + t.steps,
                            t.units[static_cast<std::size_t>(i)], false});
  }
  return j;
}

std::optional<WholeFigure> twin_of(const DriveTerm& t, const JudgedDriveTerm& j) {
  const bool heavier = find_effect(t.effect)->whole == WholeFigure::mass_share;
  if (heavier && t.where.size() == 1 && j.parameters.front().value > 0.0)
    return WholeFigure::payload;
  if (!t.carried) return std::nullopt;
  const std::vector<EffectParameter>& limits = effect_of(WholeFigure::centre).parameters;
  for (std::size_t i = 0; i < 3; ++i) {
    const double off = j.parameters[i + 1].value - t.centre[static_cast<Eigen::Index>(i)];
    if (off < limits[i].low || off > limits[i].high) return std::nullopt;
  }
  return WholeFigure::mass_share;
}

}  // namespace sanso::diagnose
