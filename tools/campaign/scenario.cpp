// Multiplies the cells by the motions, and adds the rows of arming.
#include "tools/campaign/scenario.h"

#include <algorithm>
#include <utility>

namespace sanso::campaign {

std::string Scenario::name() const {
  std::string text = std::string(name_of(motion)) + "/" + device + "/" + name_of(word);
  if (direction != Direction::none) text += std::string("/") + name_of(direction);
  if (!what.empty()) text += "/" + what;
  std::replace(text.begin(), text.end(), ' ', '_');
  return text;
}

std::vector<Scenario> scenarios() {
  std::vector<Scenario> all;
  for (const Cell& cell : cells())
    for (const Motion motion : kMotions)
      all.push_back({cell.word, cell.device, cell.direction, cell.what, motion, cell.trouble,
                     motion == Motion::walk ? cell.walk : cell.calm});
  for (Scenario& scenario : arming_scenarios()) all.push_back(std::move(scenario));
  return all;
}

const char* name_of(Word word) {
  constexpr std::array kNames{"off",  "stuck",   "garbage",     "wrong",
                              "slow", "delayed", "intermittent"};
  return kNames[static_cast<std::size_t>(word)];
}
const char* name_of(Direction direction) {
  constexpr std::array kNames{"none", "request", "reply"};
  return kNames[static_cast<std::size_t>(direction)];
}
const char* name_of(Motion motion) {
  constexpr std::array kNames{"stand", "squat", "walk_forward", "arming"};
  return kNames[static_cast<std::size_t>(motion)];
}
const char* name_of(Ending ending) {
  constexpr std::array kNames{"completes", "held", "lowered", "limp", "fell", "refused"};
  return kNames[static_cast<std::size_t>(ending)];
}

}  // namespace sanso::campaign
