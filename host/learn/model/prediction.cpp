// Windows are rolled out eight at a time, in the lanes of step_batch.
#include "host/learn/model/prediction.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "host/model/residual_network.h"
#include "shared/model/step_batch.h"

namespace sanso::learn {
namespace {

using model::InputLanes;
using model::kLanes;
using model::StateLanes;

model::State state_in_lane(const StateLanes& lanes, int lane) {
  model::State x;
  for (int i = 0; i < model::kNx; ++i) x[i] = lanes.v[i][lane];
  return x;
}
void set_lane(StateLanes& lanes, int lane, const model::State& x) {
  for (int i = 0; i < model::kNx; ++i) lanes.v[i][lane] = x[i];
}
void set_lane(InputLanes& lanes, int lane, const model::Input& u) {
  for (int i = 0; i < model::kNu; ++i) lanes.v[i][lane] = u[i];
}

// Calls see(lane, step, predicted state) for the windows first .. first + lanes - 1, lanes <= 8.
template <class See>
void predict_group(const PredictionWindow* first, int lanes, const model::StepModel& step_model,
                   const model::Ground& ground, const host::ResidualNetwork* residual,
                   const See& see) {
  StateLanes x, next;
  InputLanes u;
  for (int lane = 0; lane < kLanes; ++lane)
    set_lane(x, lane, first[std::min(lane, lanes - 1)].x[0]);
  for (int k = 0; k < kPredictionSteps; ++k) {
    for (int lane = 0; lane < kLanes; ++lane)
      set_lane(u, lane, first[std::min(lane, lanes - 1)].input(k, step_model.target_lag_s));
    model::step_batch(step_model, ground, &x, &u, {kStep_s, 1, false}, &next, nullptr, 1);
    for (int lane = 0; lane < lanes; ++lane) {
      model::State predicted = state_in_lane(next, lane);
      if (residual != nullptr) {
        predicted = model::plus(
            predicted, host::residual_tangent(*residual, state_in_lane(x, lane),
                                              first[lane].input(k, step_model.target_lag_s)));
        set_lane(next, lane, predicted);
      }
      if (k < first[lane].steps) see(lane, k, predicted);
    }
    x = next;
  }
}

using TicksByNumber = std::map<std::uint64_t, const wire::Observation*>;

/// The same; nothing also when the state after them is missing or the base leans too far there.
std::optional<model::Input> step_input(const TicksByNumber& at, std::uint64_t tick,
                                       double tilt_limit_rad) {
  std::optional<model::Input> u = mean_target(at, tick);
  if (!u) return std::nullopt;
  const auto next = at.find(tick + kTicksPerStep);
  if (next == at.end() || tilt_of(next->second->x) > tilt_limit_rad) return std::nullopt;
  return u;
}

/// The window that begins at `start`, with as many steps as there are; false for none.
bool fill_window(const TicksByNumber& at, std::uint64_t start, double tilt_limit_rad,
                 PredictionWindow& w) {
  const auto first = at.find(start);
  if (first == at.end() || tilt_of(first->second->x) > tilt_limit_rad) return false;
  w.x[0] = first->second->x;
  for (w.steps = 0; w.steps < kPredictionSteps; ++w.steps) {
    const std::uint64_t tick = start + static_cast<std::uint64_t>(w.steps * kTicksPerStep);
    const std::optional<model::Input> u = step_input(at, tick, tilt_limit_rad);
    if (!u) break;
    w.u[w.steps] = *u;
    w.x[w.steps + 1] = at.at(tick + kTicksPerStep)->x;
  }
  if (w.steps == 0) return false;
  // the lanes roll all windows out to the end: numbers, never compared
  // numbers that wrap below zero are never found
  w.u_before = mean_target(at, start - kTicksPerStep).value_or(w.u[0]);
  std::fill(w.u + w.steps, w.u + kPredictionSteps, w.u[w.steps - 1]);
  std::fill(w.x + w.steps + 1, w.x + kPredictionSteps + 1, w.x[w.steps]);
  return true;
}

}  // namespace

std::vector<PredictionWindow> windows_of(const Episode& episode, int stride_ticks) {
  std::map<int, const wire::Observation*> at;
  for (const wire::Observation& o : episode.ticks) at[o.trial_tick] = &o;
  std::vector<PredictionWindow> windows;
  if (at.empty()) return windows;
  for (int start = at.begin()->first; start + kSpanTicks <= at.rbegin()->first;
       start += stride_ticks) {
    PredictionWindow w;
    w.trial = episode.trial;
    bool whole = true;
    for (int tick = start; tick <= start + kSpanTicks && whole; ++tick) {
      const auto found = at.find(tick);
      whole = found != at.end();
      if (!whole) break;
      const int step = (tick - start) / kTicksPerStep, within = (tick - start) % kTicksPerStep;
      if (within == 0) w.x[step] = found->second->x;
      if (step == kPredictionSteps) break;
      if (within == 0) w.u[step].setZero();
      w.u[step] += found->second->u_out / kTicksPerStep;
    }
    w.u_before = mean_target(at, start - kTicksPerStep).value_or(w.u[0]);
    if (whole) windows.push_back(w);
  }
  return windows;
}

double tilt_of(const model::State& x) {
  return std::acos(std::clamp(math::rotation_matrix(model::base_quat(x))(2, 2), -1.0, 1.0));
}

std::vector<PredictionWindow> upright_windows_of(const Episode& episode, double tilt_limit_rad,
                                                 int stride_ticks) {
  std::vector<PredictionWindow> windows = windows_of(episode, stride_ticks);
  std::erase_if(windows, [tilt_limit_rad](const PredictionWindow& w) {
    return std::any_of(std::begin(w.x), std::end(w.x), [tilt_limit_rad](const model::State& x) {
      return tilt_of(x) > tilt_limit_rad;
    });
  });
  return windows;
}

std::vector<PredictionWindow> cut_windows_of(const std::vector<wire::Observation>& ticks,
                                             std::uint32_t trial, double tilt_limit_rad,
                                             int stride_ticks) {
  std::map<std::uint64_t, const wire::Observation*> at;
  for (const wire::Observation& o : ticks) at[o.tick] = &o;
  std::vector<PredictionWindow> windows;
  if (at.empty()) return windows;
  const auto stride = static_cast<std::uint64_t>(stride_ticks);
  for (std::uint64_t start = at.begin()->first; start < at.rbegin()->first; start += stride) {
    PredictionWindow w;
    w.trial = trial;
    if (fill_window(at, start, tilt_limit_rad, w)) windows.push_back(w);
  }
  return windows;
}

std::vector<PredictionWindow> thinned(const std::vector<PredictionWindow>& windows,
                                      std::size_t count) {
  if (windows.size() <= count) return windows;
  std::vector<PredictionWindow> kept;
  for (std::size_t i = 0; i < count; ++i) kept.push_back(windows[i * windows.size() / count]);
  return kept;
}

double n_step_loss(const std::vector<PredictionWindow>& windows, const model::StepModel& step_model,
                   const model::Ground& ground, const model::Tangent& weights,
                   const host::ResidualNetwork* residual) {
  if (windows.empty()) return 0.0;
  double sum = 0.0, steps = 0.0;
  for (const PredictionWindow& w : windows) steps += w.steps;
  for (std::size_t first = 0; first < windows.size(); first += kLanes) {
    const int lanes = static_cast<int>(std::min<std::size_t>(kLanes, windows.size() - first));
    predict_group(&windows[first], lanes, step_model, ground, residual,
                  [&](int lane, int k, const model::State& x) {
                    const model::Tangent e =
                        model::minus(windows[first + static_cast<std::size_t>(lane)].x[k + 1], x);
                    sum += e.dot(weights.cwiseProduct(e));
                  });
  }
  const double loss = sum / steps;
  return std::isfinite(loss) ? loss : std::numeric_limits<double>::infinity();
}

Eigen::MatrixXd n_step_errors(const std::vector<PredictionWindow>& windows,
                              const model::StepModel& step_model, const model::Ground& ground,
                              const model::Tangent& weights) {
  Eigen::Index steps = 0;
  std::vector<Eigen::Index> first_column;
  for (const PredictionWindow& w : windows) {
    first_column.push_back(steps);
    steps += w.steps;
  }
  Eigen::MatrixXd errors(model::kNdx, steps);
  const model::Tangent scale = (weights / static_cast<double>(steps)).cwiseSqrt();
  for (std::size_t first = 0; first < windows.size(); first += kLanes) {
    const int lanes = static_cast<int>(std::min<std::size_t>(kLanes, windows.size() - first));
    predict_group(&windows[first], lanes, step_model, ground, nullptr,
                  [&](int lane, int k, const model::State& x) {
                    const std::size_t window = first + static_cast<std::size_t>(lane);
                    errors.col(first_column[window] + k) =
                        scale.cwiseProduct(model::minus(windows[window].x[k + 1], x));
                  });
  }
  return errors;
}

std::vector<model::State> predicted(const PredictionWindow& window,
                                    const model::StepModel& step_model, const model::Ground& ground,
                                    const host::ResidualNetwork* residual) {
  std::vector<model::State> states{window.x[0]};
  predict_group(&window, 1, step_model, ground, residual,
                [&](int, int, const model::State& x) { states.push_back(x); });
  return states;
}

}  // namespace sanso::learn
