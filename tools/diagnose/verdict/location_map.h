// Where simulation and recording part: cells joint x regime and joint x time, with share, lift and
// false-discovery rate.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tools/diagnose/explain/regimes.h"
#include "tools/diagnose/verdict/verdict.h"

namespace sanso::diagnose {

struct LocationMap {
  std::vector<LocationCell> cells;  // joint x regime, strongest first
  // [joint][regime]: mean squared whitened error; NaN: no rows
  std::vector<std::vector<double>> heat;
  std::vector<std::vector<double>> time_strip;  // [joint][shot]: mean squared whitened error
  // s from the first recording's start, recordings one after the other
  std::vector<double> shot_time;
};

/// `projected`: whitened position errors with starts (and nuisances) taken out, in the problem's
/// layout.
LocationMap locate(const Problem& problem, const Regimes& regimes,
                   const Eigen::VectorXd& projected);

/// The called cells of the joint where it shows most, in words: "l_knee, reversal and high load".
std::string location_sentence(const LocationMap& map);

}  // namespace sanso::diagnose
