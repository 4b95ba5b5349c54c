#include "tools/diagnose/effects/twins.h"

#include <algorithm>

#include "tools/diagnose/effects/effect.h"

namespace sanso::diagnose {
namespace {

bool lists(const std::vector<std::string_view>& ids, std::string_view id) {
  return std::find(ids.begin(), ids.end(), id) != ids.end();
}

}  // namespace

bool documented_twin(std::string_view name, std::string_view truth) {
  const Effect* named = find_effect(name);
  const Effect* there = find_effect(truth);
  if (named == nullptr || there == nullptr) return false;
  return lists(there->confounders, name) || lists(named->contains, truth);
}

std::vector<std::string_view> documented_twins(std::string_view truth) {
  std::vector<std::string_view> out;
  for (const Effect& e : library()) {
    if (documented_twin(e.id, truth)) out.push_back(e.id);
  }
  return out;
}

}  // namespace sanso::diagnose
