// Statuses, and the answer in one sentence.
#pragma once

#include <string>
#include <vector>

#include "tools/diagnose/explain/select.h"
#include "tools/diagnose/verdict/predictability.h"
#include "tools/diagnose/verdict/verdict.h"

namespace sanso::diagnose {

/// What the last model leaves, by joint: is it noise? Asked of nobody's candidates.
struct Remains {
  std::vector<Predictability> torque;  // missing torque from the joint's state
  // velocity channel less the derivative of the position channel, likewise
  std::vector<Predictability> velocity;
  // Verdict::stretches repeat, and are more than what matters
  bool stretches_matter = false;
  int stretches_joint = -1;
};

/// Fills status, mismatch, answer, unexplained; needs findings, locations and stretches.
/// `location`: where the map shows what is left.
void decide(Verdict& verdict, const Problem& problem, const Library& library,
            const Selection& selection, const Remains& left, const std::string& location);

}  // namespace sanso::diagnose
