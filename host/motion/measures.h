// The measures that success clauses name. One function each: an episode and its reference in, a
// number out.
#pragma once

#include <string>
#include <vector>

#include "host/motion/success.h"

namespace sanso::motion {

struct MeasureInput {
  const MotionEpisode& episode;
  const Trajectory& reference;
  const Window& window;
  const model::Ground& ground;
};

struct Measure {
  const char* name;
  const char* meaning;  // with unit
  double (*of)(const MeasureInput&);
};

const std::vector<Measure>& measures();
const Measure* find_measure(const std::string& name);

}  // namespace sanso::motion
