// Clocks of channels against each other: an answer does not come before what it answers, and a
// velocity is the position's own.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/diagnose/gate/checks.h"
#include "tools/diagnose/stats/robust.h"

namespace sanso::diagnose::gate {
namespace {

/// Correlation of a(t) with b(t - lag) by lag.
struct LagCurve {
  std::vector<double> lag, correlation;
  std::size_t best() const {
    return static_cast<std::size_t>(std::max_element(correlation.begin(), correlation.end()) -
                                    correlation.begin());
  }
  /// Largest correlation among the lags that `which` says.
  template <class Which>
  double best_of(Which&& which) const {
    double most = -1.0;
    for (std::size_t k = 0; k < lag.size(); ++k) {
      if (which(lag[k])) most = std::max(most, correlation[k]);
    }
    return most;
  }
};

/// Rows [first, last) of a recording, as shares of it.
struct Part {
  double first = 0.0, last = 1.0;
};

LagCurve lag_curve(std::span<const double> a, std::span<const double> b, double interval,
                   const GateSettings& settings, const Part& part = {}) {
  LagCurve out;
  const auto step = std::max<long>(1, std::lround(settings.clock_step / interval));
  const auto reach = std::max<long>(step, std::lround(settings.clock_reach / interval));
  const auto rows = static_cast<long>(a.size());
  if (rows <= 2 * reach) return out;
  const auto row_at = [&](double share) {
    return reach + std::lround(share * static_cast<double>(rows - 2 * reach));
  };
  const long first = row_at(part.first), last = row_at(part.last);
  const auto skip = std::max<long>(1, (last - first) / settings.clock_pairs);
  std::vector<double> x;
  for (long k = first; k < last; k += skip) x.push_back(a[static_cast<std::size_t>(k)]);
  std::vector<double> y(x.size());
  for (long shift = -reach / step * step; shift <= reach; shift += step) {
    std::size_t i = 0;
    for (long k = first; k < last; k += skip) y[i++] = b[static_cast<std::size_t>(k - shift)];
    out.lag.push_back(static_cast<double>(shift) * interval);
    out.correlation.push_back(correlation(x, y));
  }
  return out;
}

/// Changes over about `seconds`, centred: without the offset that both may have.
std::vector<double> changes_over(std::span<const double> x, double seconds, double interval) {
  std::vector<double> out(x.size(), NAN);
  const auto half =
      std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(0.5 * seconds / interval)));
  for (std::size_t k = half; k + half < x.size(); ++k) out[k] = x[k + half] - x[k - half];
  return out;
}

bool follows(double correlation, const GateSettings& settings) {
  return correlation >= 1.0 - settings.clock_unlike;
}

/// Whether correlation `a` says clearly more than `b`: what it leaves is less than half.
bool clearly_better(double a, double b, const GateSettings& settings) {
  return follows(a, settings) && 1.0 - a < 0.5 * (1.0 - b);
}

/// Whether a shift that is seen in the whole is seen in its quarters too: one slow rise and fall
/// may follow another by chance. Quarters that follow at no lag say nothing.
template <class Allowed>
bool seen_in_quarters(std::span<const double> a, std::span<const double> b, double interval,
                      const GateSettings& settings, Allowed&& allowed) {
  int for_it = 0, against = 0;
  for (int k = 0; k < 4; ++k) {
    const LagCurve curve = lag_curve(a, b, interval, settings, {0.25 * k, 0.25 * (k + 1)});
    if (curve.lag.empty() || !follows(curve.correlation[curve.best()], settings)) continue;
    const bool shifted =
        !allowed(curve.lag[curve.best()]) &&
        clearly_better(curve.correlation[curve.best()], curve.best_of(allowed), settings);
    (shifted ? for_it : against) += 1;
  }
  return for_it >= 2 && against <= 1;
}

double interval_of(const GateRecording& r) { return std::max(sampling_interval(r.t), 1e-6); }

std::vector<double> velocity_of(const GateRecording& r, const GateChannel& q) {
  return changes_over(q.values, 0.06, interval_of(r));  // longer than counts show
}

/// The position answers the command before it was given.
std::optional<Defect> check_answer(const GateRecording& r, const GateJoint& joint,
                                   const GateSettings& settings) {
  const GateChannel* q = r.find("q:" + joint.name);
  const GateChannel* u = r.find("u:" + joint.name);
  if (q == nullptr || u == nullptr) return std::nullopt;
  const double interval = interval_of(r);
  const std::vector<double> answer = changes_over(q->values, 0.2, interval),
                            asked = changes_over(u->values, 0.2, interval);
  const LagCurve curve = lag_curve(answer, asked, interval, settings);
  if (curve.lag.empty()) return std::nullopt;
  const std::size_t best = curve.best();
  const auto after = [](double lag) { return lag >= 0.0; };
  const double causal = curve.best_of(after);
  if (curve.lag[best] >= -settings.clock_skew ||
      !clearly_better(curve.correlation[best], causal, settings))
    return std::nullopt;
  if (!seen_in_quarters(answer, asked, interval, settings, after)) return std::nullopt;
  return Defect{r.file, q->name, -1, defect::kShiftedClock,
                fmt::format("the position does what {} asks {:.3g} s later (correlation {:.4f}, "
                            "{:.4f} at best with what was asked before); the two columns have "
                            "different clocks: shift one of them",
                            u->name, -curve.lag[best], curve.correlation[best], causal)};
}

/// The velocity is that of another time.
std::optional<Defect> check_velocity(const GateRecording& r, const GateJoint& joint,
                                     const GateSettings& settings) {
  const GateChannel* q = r.find("q:" + joint.name);
  const GateChannel* dq = r.find("dq:" + joint.name);
  if (q == nullptr || dq == nullptr) return std::nullopt;
  const double interval = interval_of(r);
  const std::vector<double> velocity = velocity_of(r, *q);
  const LagCurve curve = lag_curve(dq->values, velocity, interval, settings);
  if (curve.lag.empty()) return std::nullopt;
  const std::size_t best = curve.best();
  const auto close = [&](double lag) { return std::abs(lag) <= settings.clock_skew; };
  const double near = curve.best_of(close);
  if (close(curve.lag[best]) || !clearly_better(curve.correlation[best], near, settings))
    return std::nullopt;
  if (!seen_in_quarters(dq->values, velocity, interval, settings, close)) return std::nullopt;
  return Defect{
      r.file, dq->name, -1, defect::kShiftedClock,
      fmt::format("the velocity is d({})/dt of {:.3g} s {} (correlation {:.4f}, {:.4f} at best "
                  "within {:.3g} s); the two columns have different clocks: shift one of them",
                  q->name, std::abs(curve.lag[best]), curve.lag[best] > 0 ? "before" : "later",
                  curve.correlation[best], near, settings.clock_skew)};
}

}  // namespace

std::vector<Defect> check_clocks(const GateRecording& r, const std::vector<GateJoint>& joints,
                                 const GateSettings& settings) {
  std::vector<Defect> out;
  for (const GateJoint& joint : joints) {
    std::optional<Defect> found = check_answer(r, joint, settings);
    if (!found) found = check_velocity(r, joint, settings);
    append_either(out, r, joint, std::move(found));
  }
  return out;
}

std::vector<Defect> check_clocks_between(const std::vector<GateRecording>& recordings,
                                         const std::vector<GateJoint>& joints,
                                         const GateSettings& settings) {
  std::vector<Defect> out;
  for (const GateJoint& joint : joints) {
    std::vector<const GateRecording*> with;
    std::vector<LagCurve> curves;
    std::vector<double> lags;
    for (const GateRecording& r : recordings) {
      const GateChannel* q = r.find("q:" + joint.name);
      const GateChannel* dq = r.find("dq:" + joint.name);
      if (q == nullptr || dq == nullptr) continue;
      LagCurve curve = lag_curve(dq->values, velocity_of(r, *q), interval_of(r), settings);
      if (curve.lag.empty() || !follows(curve.correlation[curve.best()], settings)) continue;
      lags.push_back(curve.lag[curve.best()]);
      curves.push_back(std::move(curve));
      with.push_back(&r);
    }
    if (curves.size() < 3) continue;  // of two nobody can say which one is wrong
    const double usual = median(lags);
    for (std::size_t k = 0; k < curves.size(); ++k) {
      const double allowed = settings.clock_between + 2.0 * interval_of(*with[k]);
      const double near =
          curves[k].best_of([&](double lag) { return std::abs(lag - usual) <= allowed; });
      if (std::abs(lags[k] - usual) <= allowed ||
          !clearly_better(curves[k].correlation[curves[k].best()], near, settings)) {
        continue;
      }
      out.push_back({with[k]->file, "dq:" + joint.name, -1, defect::kShiftedClock,
                     fmt::format("the velocity comes {:.3g} s after the position, {:.3g} s in the "
                                 "other recordings; one sensor has one delay: shift the columns",
                                 lags[k], usual)});
    }
  }
  return out;
}

}  // namespace sanso::diagnose::gate
