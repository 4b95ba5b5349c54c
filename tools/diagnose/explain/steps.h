// The steps of the search, in the order in which select() takes them. Each leaves the state as
// search_state.h says.
#pragma once

#include <cstddef>

#include "tools/diagnose/explain/search_state.h"

namespace sanso::diagnose {

/// What a step forward came to.
enum class Forward {
  none,   // no candidate passes
  ended,  // one was accepted at its bound: it describes, and is no ground to go on from
  found,
};

/// Accepts the best candidate that passes every gate, or two together where none does alone. `step`
/// counts from 0.
Forward forward(SearchState& state, int step);

/// Accepts the best pair (fit/pairs.h) that passes every gate; false: none does. `singles`: what
/// was fitted alone at this step.
bool accept_pair(SearchState& state, int step, const Screening& screening,
                 const std::vector<Alternative>& singles, double least_energy);

/// Drops what the others have made superfluous; the last `just_judged` effects are left alone.
void backward(SearchState& state, std::size_t just_judged);

/// Tied effects and what takes them back at some of their joints, each joint for itself; all of
/// them have to be needed.
void untie(SearchState& state);

/// Effects that say no more than what they contain (rivals.h) leave, or give it their place. True:
/// one did.
bool simplify(SearchState& state);

/// One effect in the place of two at the same joint, where it is documented to look like both, has
/// no more numbers, and the two do not predict better.
void one_for_two(SearchState& state);

/// Two effects in the place of one that has at least two numbers more than both, where it does not
/// predict better.
void two_for_one(SearchState& state);

/// Puts another effect, the last of its own fit's model, in the place of the i-th.
void take_place(SearchState& state, std::size_t i, const Alternative& other);

/// Every accepted effect against its rivals, everything else refitted; the better one stays, the
/// others are kept as rivals. True: one was replaced.
bool swap_for_better(SearchState& state);

/// Rivals of the i-th name that were left far behind after a few steps and yet are so by no more
/// than chance are followed to their end: the data do not tell them from it. So are those that were
/// judged beside other names than stand beside it now.
void follow_level_rivals(SearchState& state, std::size_t i);

/// With everything else refitted, an effect whose own residual contradicts it is no explanation.
/// One without which predictions would be far worse stays as a description of the data. True: one
/// left.
bool drop_refuted(SearchState& state);

/// An effect of a model that predicts its joints worse, beyond chance, than constant velocity does
/// (going_on.h) describes them and names nothing.
void describe_what_going_on_beats(SearchState& state);

/// Effects that are chance, by the scatter that everything else leaves. Asked only where more than
/// noise is left, and named only where no more than noise is left with it: an explanation that is
/// complete, or none. True: one was named.
bool judge_chance(SearchState& state);

}  // namespace sanso::diagnose
