// The first screening in the words of the library.
#include "tools/diagnose/run/first_look.h"

namespace sanso::diagnose {

FirstLook first_look(const Library& library, const Screening& first,
                     const ToleranceSettings& tolerances) {
  FirstLook out;
  for (const ProbeScore& p : first.probes) {
    const Candidate& c = library[p.candidate];
    out.effect.push_back(c.effect);
    out.family.push_back(find_effect(c.effect)->family);
    out.z.push_back(p.z);
  }
  out.correlation.assign(first.correlation.data(),
                         first.correlation.data() + first.correlation.size());
  out.critical = first.critical;
  out.by_group = first.by_group;
  out.nuisances = first.known;
  out.nuisance_precision = tolerances.precision;
  return out;
}

}  // namespace sanso::diagnose
