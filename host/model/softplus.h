// The units of the residual network, as it is used and as it is trained.
#pragma once

#include <cmath>

namespace sanso::host {

/// log(1 + e^a) without overflow.
template <class T>
T softplus(T a) {
  return a > 0 ? a + std::log1p(std::exp(-a)) : std::log1p(std::exp(a));
}
/// Its derivative.
template <class T>
T softplus_slope(T a) {
  return T(1) / (T(1) + std::exp(-a));
}

}  // namespace sanso::host
