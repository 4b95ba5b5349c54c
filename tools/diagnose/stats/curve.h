// Shape curves: the mean of a residual as a function of one quantity, with bands. What a person
// looks at first.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace sanso::diagnose {

/// One point of a shape curve.
struct CurvePoint {
  double x = 0.0;      // centre of the bin (mean of the regressor there)
  double mean = 0.0;   // mean of the residual
  double error = 0.0;  // standard error, corrected for dependence between neighbouring samples
  int count = 0;
};

struct ShapeCurve {
  std::string name;  // e.g. "torque residual vs dq"
  std::string x_unit, y_unit;
  std::vector<CurvePoint> points;
  double explained = 0.0;  // share of the residual's variance that the curve explains
};

/// Means of y in `bins` bins of x with equal counts. `dependence`: autocorrelation time of y in
/// samples (1 = white).
/// Rows with a NaN on either side are left out; bins with fewer than 5 rows are merged into their
/// neighbour.
ShapeCurve shape_curve(std::span<const double> x, std::span<const double> y, int bins,
                       double dependence);

}  // namespace sanso::diagnose
