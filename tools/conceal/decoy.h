// Decoys: recordings spoiled as real ones are, which a diagnosis has to refuse by name instead of
// explaining.
#pragma once

#include <string>
#include <vector>

#include "tools/plant/random.h"
#include "tools/recording/recording.h"

namespace sanso::conceal {

struct Decoy {
  std::string defect;  // the name a refusal should use, docs/howto/find-missing-physics.md
  std::string file;    // the recording that was spoiled
};

/// Spoils one of the recordings.
Decoy spoil(std::vector<recording::Recording>& recordings, plant::Random& random);

}  // namespace sanso::conceal
