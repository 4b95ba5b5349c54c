// Channels that are read more often than they are refreshed: a register that changes every n rows
// only, logged in every row.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "tools/diagnose/gate/gate.h"

namespace sanso::diagnose {

/// Rows between two refreshes of x; 1 where every row can be new, or too little moves to tell. Only
/// changes of more than one step of the channel count: slow motion changes rarely by itself.
int rows_between_refreshes(std::span<const double> x, const GateSettings& settings);

/// x with one row for each refresh and the others empty; `rows` from rows_between_refreshes.
std::vector<double> one_row_per_refresh(std::span<const double> x, int rows);

/// A channel whose rows are held, as it is said to a person and kept.
struct HeldChannel {
  std::string channel;
  int rows = 1;
  int late = 0;        // rows after `before` at which it changes; 0: with it, or not told
  std::string before;  // the held channel that changes first
};

/// What a cycle of the bus reads, by a channel's name: q, dq, tau, i or pwm.
bool is_reading(const std::string& channel);

/// The measured channels (q, dq, tau, i, pwm) of a recording that are held. Commands may be.
std::vector<HeldChannel> held_channels(const GateRecording& r, const GateSettings& settings);

}  // namespace sanso::diagnose
