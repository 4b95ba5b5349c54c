// What a number depends on that its own question does not ask: terms that were found before it and
// may be others, or nothing, and what counts as a contact. Each is taken in turn.
#pragma once

#include <string>
#include <vector>

#include "tools/diagnose/wholebody/questions.h"

namespace sanso::diagnose {

/// The robot, its recordings and what is known, under one choice.
struct Choice {
  std::string name;
  WholeBody body;
  std::vector<WholeRecording> recordings;
  Known known;
  WholeSettings settings;
};

/// Other choices than `asking`: the pace of falling, `fall`, left out or let in, at both ends of
/// its interval, as each of the names that it may have; then what counts as a contact, halved and
/// doubled. `fall`: recorded lengths over true ones where that is what it is; nothing: nobody fell.
std::vector<Choice> other_choices(const Asking& asking, const Known& before,
                                  const std::optional<Measured>& fall);

}  // namespace sanso::diagnose
