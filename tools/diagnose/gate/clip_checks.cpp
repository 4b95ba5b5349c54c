// A command that the log cuts off at a level, and one that the joint does not follow beyond its
// limit.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/diagnose/gate/checks.h"
#include "tools/diagnose/gate/noise.h"
#include "tools/diagnose/stats/robust.h"

namespace sanso::diagnose::gate {
namespace {

using Run = std::pair<std::size_t, std::size_t>;  // [first, last) rows

/// Runs at exactly `level` into which and out of which the command moves: not the corners of steps.
std::vector<Run> plateaus(std::span<const double> u, double level, const GateSettings& settings) {
  const auto least = static_cast<std::size_t>(settings.flat_rows),
             approach = static_cast<std::size_t>(settings.flat_command_approach);
  std::vector<Run> out;
  for (std::size_t k = approach; k < u.size(); ++k) {
    if (u[k] != level || u[k - 1] == level) continue;
    std::size_t end = k;
    while (end < u.size() && u[end] == level) ++end;
    if (end - k < least || end + approach > u.size()) continue;
    const double in = std::abs(u[k - 1] - u[k - approach]), jump = std::abs(u[k] - u[k - 1]);
    const double away = std::abs(u[end + approach - 1] - u[end]);
    if (in > 0.0 && away > 0.0 && jump <= 2.0 * in) out.emplace_back(k, end);
  }
  return out;
}

/// q(t + lag) = offset + gain u(t), from the rows between the extremes of u.
struct Follower {
  std::size_t lag = 0;  // rows
  double offset = 0.0, gain = 0.0, rms = INFINITY;
};

Follower follower_at(std::span<const double> q, std::span<const double> u, std::size_t lag,
                     double low, double high, const GateSettings& settings) {
  std::vector<double> x, y;
  const std::size_t skip = std::max<std::size_t>(1, u.size() / 4000);
  for (std::size_t k = 0; k + lag < q.size(); k += skip) {
    if (!(u[k] > low && u[k] < high) || !std::isfinite(q[k + lag])) continue;
    x.push_back(u[k]), y.push_back(q[k + lag]);
  }
  Follower f;
  f.lag = lag;
  const double r = correlation(x, y);
  if (x.size() < static_cast<std::size_t>(settings.least_rows) || r <= 0.5) return f;
  f.gain = r * standard_deviation(y) / standard_deviation(x);
  f.offset = mean(y) - f.gain * mean(x);
  f.rms = standard_deviation(y) * std::sqrt(std::max(0.0, 1.0 - r * r));
  return f;
}

Follower follower(const GateRecording& r, std::span<const double> q, std::span<const double> u,
                  double low, double high, const GateSettings& settings) {
  const double step = settings.answer_delay / 40.0;
  const double interval = std::max(sampling_interval(r.t), 1e-6);
  Follower best;
  for (double lag = 0.0; lag <= settings.answer_delay; lag += std::max(step, interval)) {
    const auto rows = static_cast<std::size_t>(std::lround(lag / interval));
    const Follower f = follower_at(q, u, rows, low, high, settings);
    if (f.rms < best.rms) best = f;
  }
  return best;
}

/// How far beyond its answer to the level a position is on average during a run; negative: inside.
double excess(std::span<const double> q, const Follower& f, const Run& run, double level,
              double side) {
  double sum = 0.0, rows = 0.0;
  for (std::size_t k = run.first; k < run.second && k + f.lag < q.size(); ++k) {
    if (!std::isfinite(q[k + f.lag])) continue;
    sum += side * (q[k + f.lag] - f.offset - f.gain * level), rows += 1.0;
  }
  return rows > 0.0 ? sum / rows : 0.0;
}

}  // namespace

std::vector<Defect> check_clipped_commands(const GateRecording& r,
                                           const std::vector<GateJoint>& joints,
                                           const GateSettings& settings) {
  std::vector<Defect> out;
  for (const GateJoint& joint : joints) {
    const GateChannel* q = r.find("q:" + joint.name);
    const GateChannel* u = r.find("u:" + joint.name);
    if (q == nullptr || u == nullptr) continue;
    const double low = quantile(u->values, 0.0), high = quantile(u->values, 1.0);
    for (const double side : {-1.0, 1.0}) {
      const double level = side < 0.0 ? low : high;
      const std::vector<Run> runs = plateaus(u->values, level, settings);
      if (runs.size() < static_cast<std::size_t>(settings.flat_tops)) continue;
      const Follower f = follower(r, q->values, u->values, low, high, settings);
      if (!std::isfinite(f.rms)) continue;
      const auto beyond = std::count_if(runs.begin(), runs.end(), [&](const Run& run) {
        return excess(q->values, f, run, level, side) >
               settings.clipped_deviations * f.rms + quantisation_step(q->values);
      });
      if (2 * beyond <= static_cast<long>(runs.size()) || beyond < settings.flat_tops) continue;
      out.push_back(
          {r.file, u->name, static_cast<long>(runs.front().first), defect::kClipped,
           fmt::format(
               "{} flat tops at {:.6g}, and in {} of them {} goes on as if the command had; "
               "the log cuts the command off: raise the logger's range",
               runs.size(), level, beyond, q->name)});
      break;
    }
  }
  return out;
}

std::vector<std::string> unfollowed_commands(const GateRecording& r,
                                             const std::vector<GateJoint>& joints) {
  std::vector<std::string> out;
  for (const GateJoint& joint : joints) {
    const GateChannel* q = r.find("q:" + joint.name);
    const GateChannel* u = r.find("u:" + joint.name);
    if (q == nullptr || u == nullptr || joint.lower >= joint.upper) continue;
    const double tolerance = 0.01 * (joint.upper - joint.lower);
    for (const double side : {-1.0, 1.0}) {
      const double limit = side < 0.0 ? joint.lower : joint.upper;
      const auto farthest = [&](const GateChannel& c) {
        return quantile(c.values, side < 0.0 ? 0.0 : 1.0);
      };
      const double asked = farthest(*u), went = farthest(*q);
      if (side * (asked - limit) <= tolerance || side * (went - limit) > tolerance) continue;
      out.push_back(
          fmt::format("{}: {} asks for {:.4g}, beyond the joint's limit {:.4g}, and {} goes to "
                      "{:.4g}: the goal is cut off on its way, or the joint stands at its stop",
                      r.file, u->name, asked, limit, q->name, went));
    }
  }
  return out;
}

}  // namespace sanso::diagnose::gate
