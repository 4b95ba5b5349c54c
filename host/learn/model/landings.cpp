// Counts ticks with and without a loaded foot. What the controller believes of its feet flickers:
// in the air where legs swing, on the ground where it bounces.
#include "host/learn/model/landings.h"

namespace sanso::learn {

std::vector<wire::Observation> without_landings(const std::vector<wire::Observation>& ticks,
                                                int flight_ticks) {
  std::vector<wire::Observation> out;
  out.reserve(ticks.size());
  int free = 0, loaded = 0;  // ticks in a row
  bool lands = false;
  for (const wire::Observation& o : ticks) {
    const bool stands = o.contact != 0;
    if (stands && flight_ticks > 0 && free >= flight_ticks) lands = true;
    free = stands ? 0 : free + 1;
    loaded = stands ? loaded + 1 : 0;
    if (loaded > flight_ticks) lands = false;
    if (!lands) out.push_back(o);
  }
  return out;
}

}  // namespace sanso::learn
