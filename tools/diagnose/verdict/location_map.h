// Where simulation and recording part: cells joint x regime and joint x time, with share, lift and
// false-discovery rate.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "tools/diagnose/explain/regimes.h"

namespace sanso::diagnose {

struct LocationCell {
  std::string where, regime;
  double share = 0.0;    // of the residual energy beyond noise
  double lift = 0.0;     // energy density inside over outside
  double mean = 0.0;     // signed mean of the whitened residual
  double q_value = 1.0;  // false discovery rate at which this cell is called
  double rows = 0.0;     // samples in the cell
};

struct LocationMap {
  std::vector<LocationCell> cells;  // joint x regime, strongest first
  // [joint][regime]: mean squared whitened error; NaN: no rows
  std::vector<std::vector<double>> heat;
  std::vector<std::vector<double>> time_strip;  // [joint][shot]: mean squared whitened error
  // s from the first recording's start, recordings one after the other
  std::vector<double> shot_time;
};

/// `projected`: position errors in noise levels with starts (and nuisances) taken out, stacked.
LocationMap locate(const Comparison& comparison, const Regimes& regimes,
                   const Eigen::VectorXd& projected);

/// The called cells of the joint where it shows most, in words: "l_knee, reversal and high load".
std::string location_sentence(const LocationMap& map);

}  // namespace sanso::diagnose
