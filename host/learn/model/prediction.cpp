// Windows are rolled out eight at a time, in the lanes of step_batch.
#include "host/learn/model/prediction.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "host/model/residual_network.h"
#include "shared/model/step_batch.h"

namespace sanso::learn {
namespace {

using model::InputLanes;
using model::kLanes;
using model::StateLanes;

constexpr double kStep_s = 0.06;

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
      set_lane(u, lane, first[std::min(lane, lanes - 1)].u[k]);
    model::step_batch(step_model, ground, &x, &u, {kStep_s, 1, false}, &next, nullptr, 1);
    for (int lane = 0; lane < lanes; ++lane) {
      model::State predicted = state_in_lane(next, lane);
      if (residual != nullptr) {
        predicted = model::plus(
            predicted, host::residual_tangent(*residual, state_in_lane(x, lane), first[lane].u[k]));
        set_lane(next, lane, predicted);
      }
      see(lane, k, predicted);
    }
    x = next;
  }
}

}  // namespace

std::vector<PredictionWindow> windows_of(const Episode& episode, int stride_ticks) {
  std::map<int, const wire::Observation*> at;
  for (const wire::Observation& o : episode.ticks) at[o.trial_tick] = &o;
  std::vector<PredictionWindow> windows;
  if (at.empty()) return windows;
  constexpr int kSpan = kPredictionSteps * kTicksPerStep;
  for (int start = at.begin()->first; start + kSpan <= at.rbegin()->first; start += stride_ticks) {
    PredictionWindow w;
    w.trial = episode.trial;
    bool whole = true;
    for (int tick = start; tick <= start + kSpan && whole; ++tick) {
      const auto found = at.find(tick);
      whole = found != at.end();
      if (!whole) break;
      const int step = (tick - start) / kTicksPerStep, within = (tick - start) % kTicksPerStep;
      if (within == 0) w.x[step] = found->second->x;
      if (step == kPredictionSteps) break;
      if (within == 0) w.u[step].setZero();
      w.u[step] += found->second->u_out / kTicksPerStep;
    }
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
  double sum = 0.0;
  for (std::size_t first = 0; first < windows.size(); first += kLanes) {
    const int lanes = static_cast<int>(std::min<std::size_t>(kLanes, windows.size() - first));
    predict_group(&windows[first], lanes, step_model, ground, residual,
                  [&](int lane, int k, const model::State& x) {
                    const model::Tangent e =
                        model::minus(windows[first + static_cast<std::size_t>(lane)].x[k + 1], x);
                    sum += e.dot(weights.cwiseProduct(e));
                  });
  }
  const double loss = sum / static_cast<double>(windows.size() * kPredictionSteps);
  return std::isfinite(loss) ? loss : std::numeric_limits<double>::infinity();
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
