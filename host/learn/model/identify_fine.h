// Identification at the controller's own 10 ms, with the delay between a target and what is seen of
// it. The planner's model takes one step of 60 ms and keeps the delay in its damping and inertia;
// whoever computes targets tick by tick needs the servo itself.
#pragma once

#include "host/learn/model/identify.h"

namespace sanso::learn {

inline constexpr int kFineSteps = 10;  // of 10 ms: a window
inline constexpr int kMostDelayTicks = 5;

/// State, then the states of the next ticks, and the targets from kMostDelayTicks + 1 before it on.
struct FineWindow {
  std::array<model::State, kFineSteps + 1> x;
  std::array<model::Input, kFineSteps + kMostDelayTicks + 1> u;
};

/// Windows of the trial itself, every `stride_ticks` from `first_tick` on, without gaps and falls.
std::vector<FineWindow> fine_windows_of(const Episode& episode, int first_tick, int stride_ticks);

struct FineIdentification {
  model::ModelParameters parameters;
  double delay_s = 0.0;
  double loss_initial = 0.0, loss = 0.0;
};

/// Around the nominal parameters, of a robot put together as drawn. Throws std::invalid_argument
/// when there are no windows.
FineIdentification identify_fine(const std::vector<FineWindow>& windows, const ParameterMap& map,
                                 const model::Ground& ground, std::uint64_t seed);

}  // namespace sanso::learn
