// How loud an effect is: RMS of what it changes after the nuisances are refitted, over noise RMS,
// in the loudest channel.
#pragma once

#include "tools/conceal/hideable.h"

namespace sanso::conceal {

/// Measures the ratio of effects against one nominal world.
class SeverityMeter {
 public:
  /// Nuisances: one encoder offset, mass and length of the links, viscous and dry friction, one
  /// lag; each channel refits them by itself. The offset is the servo's too: one of the record
  /// alone is heard in full.
  SeverityMeter(const WorldTruth& without, std::vector<Experiment> experiments, std::uint64_t seed);

  /// Ratio of a world that has the effects; 0 = nothing to see.
  double ratio(const WorldTruth& with) const;

 private:
  struct Channel {
    double noise;                                // standard deviation of one sample
    double record_offset;                        // positions: of the world without effects
    std::vector<double> baseline;                // over all experiments
    std::vector<std::vector<double>> nuisances;  // orthonormal
  };
  std::vector<std::vector<double>> channels_of(const WorldTruth& world) const;

  std::vector<Experiment> experiments_;
  std::uint64_t seed_;
  std::vector<Channel> channels_;
};

/// Size of the effect at which it has the target ratio, within 10 % where its range allows.
/// `reached` tells the ratio.
double size_for_ratio(const Hideable& effect, int at, const WorldTruth& without,
                      const SeverityMeter& meter, double target, const Random& random,
                      double& reached);

}  // namespace sanso::conceal
