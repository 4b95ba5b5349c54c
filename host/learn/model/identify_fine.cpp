// The cross-entropy search of identify.h over one more number, the delay; windows eight at a time.
#include "host/learn/model/identify_fine.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

#include "host/mpc/cost.h"
#include "shared/base/time.h"
#include "shared/model/step_batch.h"

namespace sanso::learn {
namespace {

using model::kLanes;

constexpr int kSubsteps = 2;
constexpr std::size_t kMostWindows = 240;
constexpr double kTilt_rad = 0.4;
constexpr double kUsualDelay_ticks = 1.5;  // of the prior, with a deviation of one tick
constexpr double kPriorWeight = 0.01;

/// Servos are to be seen: joints count more than in a trial's cost, and the base's height no more
/// than its place.
model::Tangent fine_weights() {
  model::Tangent w = mpc::CostWeights::default_state();
  w.head<3>().setConstant(300.0);
  w.segment<model::kNumJoints>(model::kDJoint).setConstant(30.0);
  w.segment<model::kNumJoints>(model::kDJointRate).setConstant(0.1);
  return w;
}

double delay_ticks(double z) {
  return std::clamp(kUsualDelay_ticks + z, 0.0, static_cast<double>(kMostDelayTicks));
}

model::Input delayed(const FineWindow& w, int step, double delay) {
  const double at = step + kMostDelayTicks + 1 - delay;
  const auto i = static_cast<std::size_t>(at);
  const double s = at - std::floor(at);
  return (1.0 - s) * w.u[i] + s * w.u[std::min(i + 1, w.u.size() - 1)];
}

double loss_of_group(const FineWindow* first, int count, const model::StepModel& step_model,
                     const model::Ground& ground, double delay, const model::Tangent& weights) {
  model::StateLanes x;
  model::InputLanes u;
  const auto of = [&](int lane) -> const FineWindow& { return first[std::min(lane, count - 1)]; };
  for (int lane = 0; lane < kLanes; ++lane)
    for (int i = 0; i < model::kNx; ++i) x.v[i][lane] = of(lane).x[0][i];
  double sum = 0.0;
  for (int k = 0; k < kFineSteps; ++k) {
    for (int lane = 0; lane < kLanes; ++lane) {
      const model::Input told = delayed(of(lane), k, delay);
      for (int j = 0; j < model::kNu; ++j) u.v[j][lane] = told[j];
    }
    model::step_batch(step_model, ground, &x, &u, {kTick_s, kSubsteps, false}, &x, nullptr, 1);
    for (int lane = 0; lane < count; ++lane) {
      model::State predicted;
      for (int i = 0; i < model::kNx; ++i) predicted[i] = x.v[i][lane];
      const model::Tangent e =
          model::minus(first[lane].x[static_cast<std::size_t>(k) + 1], predicted);
      sum += e.dot(weights.cwiseProduct(e));
    }
  }
  return sum;
}

std::vector<FineWindow> thinned(const std::vector<FineWindow>& all) {
  const std::size_t n = std::min(kMostWindows, all.size());
  std::vector<FineWindow> few;
  few.reserve(n);
  for (std::size_t i = 0; i < n; ++i) few.push_back(all[i * all.size() / n]);
  return few;
}

}  // namespace

std::vector<FineWindow> fine_windows_of(const Episode& episode, int first_tick, int stride_ticks) {
  std::map<int, const wire::Observation*> at;
  for (const wire::Observation& o : episode.ticks) at[o.trial_tick] = &o;
  std::vector<FineWindow> out;
  if (at.empty()) return out;
  for (int start = first_tick; start + kFineSteps <= at.rbegin()->first; start += stride_ticks) {
    FineWindow w;
    bool whole = true;
    for (int k = -kMostDelayTicks - 1, command = 0; k <= kFineSteps && whole; ++k, ++command) {
      const auto found = at.find(start + k);
      whole = found != at.end() && tilt_of(found->second->x) < kTilt_rad;
      if (!whole) break;
      if (k >= 0) w.x[static_cast<std::size_t>(k)] = found->second->x;
      if (k < kFineSteps) w.u[static_cast<std::size_t>(command)] = found->second->u_out;
    }
    if (whole) out.push_back(w);
  }
  return out;
}

FineIdentification identify_fine(const std::vector<FineWindow>& all, const ParameterMap& whole,
                                 const model::Ground& ground, std::uint64_t seed) {
  if (all.empty())
    throw std::invalid_argument(
        "identification at 10 ms: no window of 0.1 s without a gap; record longer trials");
  // 0.1 s shows servos, not how the robot was put together
  const ParameterMap map = whole.with(as_drawn(whole.prior()));
  const std::vector<FineWindow> windows = thinned(all);
  const model::Tangent weights = fine_weights();
  const Eigen::Index n = map.size();
  const auto loss_of = [&](const Eigen::VectorXd& z) {
    const model::StepModel model = model::make_step_model(map.parameters(z.head(n)));
    double sum = 0.0;
    for (std::size_t i = 0; i < windows.size(); i += kLanes) {
      const int count = static_cast<int>(std::min<std::size_t>(kLanes, windows.size() - i));
      sum += loss_of_group(&windows[i], count, model, ground, delay_ticks(z[n]), weights);
    }
    const double loss = sum / static_cast<double>(windows.size() * kFineSteps);
    return std::isfinite(loss) ? loss : std::numeric_limits<double>::infinity();
  };
  FineIdentification out;
  out.loss_initial = loss_of(Eigen::VectorXd::Zero(n + 1));
  const double prior = kPriorWeight * out.loss_initial / static_cast<double>(n + 1);
  const EvaluateCandidates evaluate = [&](const Eigen::MatrixXd& candidates) {
    std::vector<double> losses;
    for (const auto& z : candidates.colwise())
      losses.push_back(loss_of(z) + prior * z.squaredNorm());
    return losses;
  };
  CrossEntropySettings search;
  search.population = 48;
  search.elites = 10;
  search.generations = 25;  // then the stiffness moves by less than a tenth of a per cent
  CrossEntropyState state =
      start_cross_entropy(Eigen::VectorXd::Zero(n + 1), Eigen::VectorXd::Ones(n + 1), evaluate);
  while (state.generation < search.generations)
    advance_cross_entropy(state, search, seed, evaluate);
  out.parameters = map.parameters(state.best.head(n));
  out.delay_s = kTick_s * delay_ticks(state.best[n]);
  out.loss = loss_of(state.best);
  return out;
}

}  // namespace sanso::learn
