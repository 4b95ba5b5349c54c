// What a verdict needs of a search that is done.
#include "tools/diagnose/verdict/evidence.h"

#include <algorithm>

namespace sanso::diagnose {

SearchRecord record_of(const Library& library, const Selection& selection) {
  SearchRecord out;
  const std::vector<ProbeScore>& probes = selection.first.probes;
  const double level = selection.around->settings().decisions.family_wise;
  out.detected = std::any_of(probes.begin(), probes.end(),
                             [level](const ProbeScore& p) { return p.p_family < level; });
  for (const Accepted& entry : selection.accepted) {
    if (!entry.contradicted.empty())
      out.described.push_back(library[entry.candidate].title() + " (" + entry.contradicted + ")");
  }
  out.refuted = selection.refuted;
  if (!probes.empty()) out.nearest_effect = library[selection.first.ranking().front()].effect;
  return out;
}

}  // namespace sanso::diagnose
