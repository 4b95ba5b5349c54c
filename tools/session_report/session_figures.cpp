// One function a figure; each picks its series and leaves scales, ticks and colours to
// svg_chart.
#include "tools/session_report/session_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/learn/session/summary.h"
#include "shared/base/time.h"
#include "shared/model/joints.h"
#include "tools/report/svg_chart.h"

namespace sanso::report {
namespace {

using learn::Episode;
using learn::SessionState;
using learn::TrialSummary;
using wire::Observation;

constexpr double kCostLimit = 350.0;  // J_th (paper)
constexpr double kUpperPeriod_ms = kTicksPerUpper * kTickPeriod / kMillisecond;
constexpr ChartSize kWide{1080, 300}, kHalf{540, 260};  // px: across the page, two abreast
constexpr double kRadToDeg = 57.295779513082323;

/// One series over the trial: y from every observation.
template <class Value>
Series over_time(const Episode& episode, const std::string& name, Value value) {
  Series s{.name = name, .x = {}, .y = {}};
  for (std::size_t i = 0; i < episode.ticks.size(); ++i) {
    s.x.push_back(to_seconds(kTickPeriod) * episode.ticks[i].trial_tick);
    s.y.push_back(value(i));
  }
  return s;
}

/// One series over the trials: y from every summary.
template <class Value>
Series over_trials(const SessionState& state, const std::string& name, Value value) {
  Series s{.name = name, .x = {}, .y = {}, .markers = state.history.size() <= 30};
  for (const TrialSummary& t : state.history) {
    s.x.push_back(t.trial + 1);
    s.y.push_back(value(t));
  }
  return s;
}

double reference_at(const Episode& episode, std::size_t i, int entry) {
  return i < episode.reference.size() ? episode.reference[i][static_cast<std::size_t>(entry)]
                                      : std::nan("");
}

double joint_rms(const model::Input& u) { return std::sqrt(u.squaredNorm() / model::kNumJoints); }

/// Mean of the last ten values, as the paper plots its learning curves.
Series moving_average(const Series& of) {
  Series s{.name = "mean of 10", .x = of.x, .y = {}, .dashed = true};
  for (std::size_t i = 0; i < of.y.size(); ++i) {
    const std::size_t first = i + 1 >= 10 ? i - 9 : 0;
    double sum = 0;
    for (std::size_t k = first; k <= i; ++k) sum += of.y[k];
    s.y.push_back(sum / static_cast<double>(i - first + 1));
  }
  return s;
}

}  // namespace

std::string cost_over_trials(const SessionState& state) {
  const Series cost = over_trials(state, "cost J", [](const TrialSummary& t) { return t.cost; });
  LineChart chart{.title = "Cost over trials",
                  .x_label = "trial",
                  .y_label = "J",
                  .series = {cost},
                  .log_y = true};
  if (state.history.size() > 10) chart.series.push_back(moving_average(cost));
  for (const TrialSummary& t : state.history)
    if (t.failed()) chart.bands.push_back({t.trial + 0.75, t.trial + 1.25, "#f4c7b8"});
  const bool near =
      std::any_of(cost.y.begin(), cost.y.end(), [](double c) { return c > 0.2 * kCostLimit; });
  if (near) chart.levels.push_back({kCostLimit, "limit 350"});
  return svg(chart, kWide);
}

std::string layers_over_trials(const SessionState& state) {
  return svg(
      LineChart{.title = "Who does the work",
                .x_label = "trial",
                .y_label = "rms [rad]",
                .series = {over_trials(state, "upper",
                                       [](const TrialSummary& t) { return t.u_upper_rms; }),
                           over_trials(state, "middle",
                                       [](const TrialSummary& t) { return t.u_middle_rms; })},
                .y_min = 0.0},
      kHalf);
}

std::string gains_over_trials(const SessionState& state) {
  return svg(LineChart{.title = "Gains",
                       .x_label = "trial",
                       .y_label = "mean norm of K",
                       .series = {over_trials(state, "K upper",
                                              [](const TrialSummary& t) { return t.gain_upper; }),
                                  over_trials(state, "K middle",
                                              [](const TrialSummary& t) { return t.gain_middle; })},
                       .y_min = 0.0},
             kHalf);
}

std::string model_over_trials(const SessionState& state) {
  const auto known = [](double loss) { return loss >= 0 ? loss : std::nan(""); };
  return svg(
      LineChart{.title = "Prediction error of the model",
                .x_label = "trial",
                .y_label = "12-step loss in W_x",
                .series = {over_trials(state, "in use",
                                       [&](const TrialSummary& t) { return known(t.model_loss); }),
                           over_trials(
                               state, "first model",
                               [&](const TrialSummary& t) { return known(t.model_loss_initial); })},
                .log_y = true},
      kHalf);
}

std::string joint_angle(const Episode& episode, int joint) {
  const auto j = static_cast<std::size_t>(joint);
  Series reference = over_time(episode, "reference", [&](std::size_t i) {
    return kRadToDeg * reference_at(episode, i, model::kXJoint + joint);
  });
  reference.dashed = true;
  return svg(LineChart{.title = model::kJoints[j].name,
                       .x_label = "time [s]",
                       .y_label = "angle [deg]",
                       .series = {over_time(episode, "measured",
                                            [&](std::size_t i) {
                                              return kRadToDeg *
                                                     episode.ticks[i].x[model::kXJoint + joint];
                                            }),
                                  reference,
                                  over_time(episode, "target",
                                            [&](std::size_t i) {
                                              return kRadToDeg * episode.ticks[i].u_out[joint];
                                            })}},
             kHalf);
}

std::string layer_contributions(const Episode& episode) {
  const model::Input first =
      episode.ticks.empty() ? model::Input::Zero() : episode.ticks.front().u_lower;
  return svg(
      LineChart{
          .title = "What the three layers add",
          .x_label = "time [s]",
          .y_label = "rms over joints [rad]",
          .series = {over_time(episode, "upper",
                               [&](std::size_t i) { return joint_rms(episode.ticks[i].u_upper); }),
                     over_time(episode, "middle",
                               [&](std::size_t i) { return joint_rms(episode.ticks[i].u_middle); }),
                     over_time(episode, "lower (from first pose)",
                               [&](std::size_t i) {
                                 return joint_rms(episode.ticks[i].u_lower - first);
                               })}},
      kWide);
}

std::string base_height(const Episode& episode) {
  Series reference = over_time(episode, "reference", [&](std::size_t i) {
    return reference_at(episode, i, model::kXPos + 2);
  });
  reference.dashed = true;
  return svg(
      LineChart{
          .title = "Base height",
          .x_label = "time [s]",
          .y_label = "z [m]",
          .series = {over_time(episode, "estimated",
                               [&](std::size_t i) { return episode.ticks[i].x[model::kXPos + 2]; }),
                     reference,
                     over_time(episode, "true",
                               [&](std::size_t i) {
                                 return i < episode.truth.size()
                                            ? episode.truth[i].x[model::kXPos + 2]
                                            : std::nan("");
                               })}},
      kHalf);
}

std::string base_tilt(const Episode& episode) {
  const auto up = [&](std::size_t i) -> math::Vec3 {
    return math::rotation_matrix(model::base_quat(episode.ticks[i].x)).row(2).transpose();
  };
  return svg(LineChart{.title = "Lean of the base",
                       .x_label = "time [s]",
                       .y_label = "angle [deg]",
                       .series = {over_time(episode, "pitch",
                                            [&](std::size_t i) {
                                              return -kRadToDeg *
                                                     std::asin(std::clamp(up(i)[0], -1.0, 1.0));
                                            }),
                                  over_time(episode, "roll",
                                            [&](std::size_t i) {
                                              return kRadToDeg *
                                                     std::asin(std::clamp(up(i)[1], -1.0, 1.0));
                                            })}},
             kHalf);
}

std::string foot_forces(const Episode& episode) {
  const auto force = [&](std::size_t i, std::size_t foot) {
    return i < episode.truth.size() ? static_cast<double>(episode.truth[i].foot_load_N[foot])
                                    : std::nan("");
  };
  return svg(
      LineChart{.title = "Normal force on the feet (true)",
                .x_label = "time [s]",
                .y_label = "force [N]",
                .series = {over_time(episode, "right", [&](std::size_t i) { return force(i, 0); }),
                           over_time(episode, "left", [&](std::size_t i) { return force(i, 1); })},
                .y_min = 0.0},
      kHalf);
}

std::string update_times(const SessionState& state) {
  return svg(
      LineChart{.title = "Policy update",
                .x_label = "trial",
                .y_label = "time [ms]",
                .series = {over_trials(state, "median",
                                       [](const TrialSummary& t) {
                                         return learn::percentile(t.update_ms, 0.5);
                                       }),
                           over_trials(state, "longest",
                                       [](const TrialSummary& t) {
                                         return learn::percentile(t.update_ms, 1.0);
                                       })},
                .levels = {{kUpperPeriod_ms, fmt::format("period {:.0f} ms", kUpperPeriod_ms)}},
                .y_min = 0.0,
                .y_max = 1.1 * kUpperPeriod_ms},
      kHalf);
}

}  // namespace sanso::report
