// Height and slope of the ground for one double or lanes; the scalar twin is ground.cpp.
#pragma once

#include "shared/model/ground.h"
#include "shared/model/kernel/pack.h"

namespace sanso::model::SANSO_ISA {

template <class T>
struct GroundPoint {
  T z;          // m
  T sin_slope;  // of the surface along x
  T cos_slope;
};

template <class T>
inline GroundPoint<T> ground_at(const Ground& ground, T x) {
  const GroundSegment& first = ground.segment[0];
  if (ground.num_segments == 1 && first.sin_slope == 0.0 && first.curvature == 0.0)
    return {T(first.z), T(0.0), T(1.0)};
  T x0 = first.x_start, z0 = first.z, sin0 = first.sin_slope, curvature = first.curvature;
  for (int i = 1; i < ground.num_segments; ++i) {
    const GroundSegment& s = ground.segment[i];
    x0 = select_less(x, T(s.x_start), x0, T(s.x_start));
    z0 = select_less(x, T(s.x_start), z0, T(s.z));
    sin0 = select_less(x, T(s.x_start), sin0, T(s.sin_slope));
    curvature = select_less(x, T(s.x_start), curvature, T(s.curvature));
  }
  const T dx = x - x0;
  const T sin1 = min_of(max_of(sin0 + curvature * dx, T(-0.99)), T(0.99));
  const T cos0 = sqrt_of(1.0 - sin0 * sin0), cos1 = sqrt_of(1.0 - sin1 * sin1);
  // tan((a + b) / 2) = (sin a + sin b) / (cos a + cos b)
  return {z0 + dx * (sin0 + sin1) / (cos0 + cos1), sin1, cos1};
}

}  // namespace sanso::model::SANSO_ISA
