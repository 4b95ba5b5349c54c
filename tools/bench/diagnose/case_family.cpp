// Names of the families.
#include "tools/bench/diagnose/case_family.h"

namespace sanso::bench {

const char* to_string(CaseFamily family) {
  switch (family) {
    case CaseFamily::ambiguous:
      return "ambiguous";
    case CaseFamily::decoy:
      return "decoy";
    case CaseFamily::clean:
      return "clean";
    case CaseFamily::outside:
      return "outside";
    case CaseFamily::pair:
      return "pair";
    case CaseFamily::single:
      return "single";
  }
  return "clean";
}

const char* in_answers(CaseFamily family) {
  return family == CaseFamily::clean ? "null" : to_string(family);
}

std::optional<CaseFamily> family_from_string(const std::string& name) {
  for (const CaseFamily family : {CaseFamily::ambiguous, CaseFamily::decoy, CaseFamily::clean,
                                  CaseFamily::outside, CaseFamily::pair, CaseFamily::single}) {
    if (name == to_string(family) || name == in_answers(family)) return family;
  }
  return std::nullopt;
}

}  // namespace sanso::bench
