// A search along one entry of z.
#include "host/learn/model/damping_of_moves.h"

#include <algorithm>

namespace sanso::learn {

std::vector<PredictionWindow> moves_of(std::vector<PredictionWindow> windows, double least_rad) {
  std::erase_if(windows, [least_rad](const PredictionWindow& w) {
    model::Input low = w.u[0], high = w.u[0];
    for (int k = 1; k < w.steps; ++k) {
      low = low.cwiseMin(w.u[k]);
      high = high.cwiseMax(w.u[k]);
    }
    return (high - low).maxCoeff() < least_rad;
  });
  return windows;
}

Eigen::Index damping_entry(const ParameterMap& map) {
  const std::vector<std::string>& names = map.names();
  return std::find(names.begin(), names.end(), "damping") - names.begin();
}

double best_damping(const ParameterMap& map, Eigen::VectorXd z,
                    const std::function<double(const Eigen::VectorXd&)>& loss,
                    const DampingOfMovesSettings& settings) {
  constexpr double kExact = 0.02, kShare = 0.6180339887498949;  // the golden section's
  const Eigen::Index entry = damping_entry(map);
  const auto at = [&](double value) {
    z[entry] = value;
    return loss(z);
  };
  double low = settings.lowest_damping, high = settings.highest_damping;
  double a = high - kShare * (high - low), b = low + kShare * (high - low);
  double at_a = at(a), at_b = at(b);
  while (high - low > kExact) {
    if (at_a < at_b) {
      high = b, b = a, at_b = at_a;
      at_a = at(a = high - kShare * (high - low));
    } else {
      low = a, a = b, at_a = at_b;
      at_b = at(b = low + kShare * (high - low));
    }
  }
  return 0.5 * (low + high);
}

}  // namespace sanso::learn
