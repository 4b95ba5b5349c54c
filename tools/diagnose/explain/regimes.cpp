// Reversal, standstill, speed, load and the like, row by row, with limits common to all recordings.
#include "tools/diagnose/explain/regimes.h"

#include <algorithm>
#include <cmath>

#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/stats/robust.h"

namespace sanso::diagnose {
namespace {

/// Limits that are shared by all recordings of a joint, so that a regime means the same in each.
struct RegimeLimits {
  double rest_speed = 0.0;        // below: standing
  double slow = 0.0, fast = 0.0;  // terciles of the moving speed
  double low_load = 0.0, high_load = 0.0;
  double low_volt = 0.0, high_volt = 0.0, low_temp = 0.0, high_temp = 0.0;
};

struct Row {
  double t, q, dq, command, torque, volt, temp, duty;
};

class JointRegimes {
 public:
  JointRegimes(const Source& source, std::size_t j, const ReplayTorques& torques,
               const RegimeSettings& settings)
      : source_(source), j_(j), settings_(settings) {
    const std::size_t rows = source.drive.rows();
    rows_.resize(rows);
    const JointData& data = source.drive.joints[j];
    for (std::size_t k = 0; k < rows; ++k) {
      const auto value = [&](const std::vector<double>& v) { return k < v.size() ? v[k] : NAN; };
      rows_[k] = {source.drive.t[k],   source.motion.q[j][k],       source.motion.dq[j][k],
                  value(data.command), torques.motor[j * rows + k], value(source.drive.volt),
                  value(data.temp),    torques.duty[j * rows + k]};
    }
  }
  const std::vector<Row>& rows() const { return rows_; }

  void fill(const RegimeLimits& scale, std::vector<std::vector<char>>& mask,
            const std::vector<std::string>& names) const {
    mask.assign(names.size(), std::vector<char>(rows_.size(), 0));
    const auto set = [&](const char* name, std::size_t row, bool value) {
      const auto at = std::find(names.begin(), names.end(), name);
      if (value) mask[at - names.begin()][row] = 1;
    };
    mark_reversals(scale, set);
    mark_standstill(scale, set);
    mark_steps(set);
    const TreeJoint& joint = source_.nominal.tree.joints[j_];
    for (std::size_t k = 0; k < rows_.size(); ++k) {
      const Row& r = rows_[k];
      const double speed = std::abs(r.dq);
      const bool moving = speed > scale.rest_speed, off = std::isnan(r.command);
      set("low speed", k, moving && speed <= scale.slow);
      set("middle speed", k, moving && speed > scale.slow && speed <= scale.fast);
      set("high speed", k, moving && speed > scale.fast);
      set("forwards", k, moving && r.dq > 0);
      set("backwards", k, moving && r.dq < 0);
      set("torque off", k, off);
      set("saturated", k, !off && std::abs(r.duty) > settings_.saturated);
      set("driving", k, !off && moving && r.torque * r.dq > 0);
      set("back-driven", k, !off && moving && r.torque * r.dq < 0);
      set("low load", k, std::abs(r.torque) <= scale.low_load);
      set("high load", k, std::abs(r.torque) > scale.high_load);
      if (joint.lower < joint.upper) {
        const double margin = settings_.near_limit * (joint.upper - joint.lower);
        set("near a limit", k, r.q < joint.lower + margin || r.q > joint.upper - margin);
      }
      set("low voltage", k, scale.low_volt < scale.high_volt && r.volt <= scale.low_volt);
      set("high voltage", k, scale.low_volt < scale.high_volt && r.volt >= scale.high_volt);
      set("cold", k, scale.low_temp < scale.high_temp && r.temp <= scale.low_temp);
      set("hot", k, scale.low_temp < scale.high_temp && r.temp >= scale.high_temp);
      set("first minute", k,
          rows_.back().t - rows_.front().t > 90.0 && r.t - rows_.front().t < 60.0);
    }
  }

 private:
  template <class Set>
  void mark_reversals(const RegimeLimits& scale, const Set& set) const {
    for (std::size_t k = 1; k < rows_.size(); ++k) {
      if (rows_[k].dq * rows_[k - 1].dq > 0.0 || std::abs(rows_[k].dq - rows_[k - 1].dq) < 1e-9)
        continue;
      // a change of sign that leads somewhere: speed outside the standing band within 5 times the
      // reversal time
      bool before = false, after = false;
      for (std::size_t i = k; i-- > 0 && rows_[k].t - rows_[i].t < 5 * settings_.reversal;)
        before |= std::abs(rows_[i].dq) > scale.rest_speed;
      for (std::size_t i = k; i < rows_.size() && rows_[i].t - rows_[k].t < 5 * settings_.reversal;
           ++i)
        after |= std::abs(rows_[i].dq) > scale.rest_speed;
      if (!before || !after) continue;
      for (std::size_t i = k; i-- > 0 && rows_[k].t - rows_[i].t < settings_.reversal;)
        set("reversal", i, true);
      for (std::size_t i = k; i < rows_.size() && rows_[i].t - rows_[k].t < settings_.reversal; ++i)
        set("reversal", i, true);
    }
  }
  template <class Set>
  void mark_standstill(const RegimeLimits& scale, const Set& set) const {
    for (std::size_t k = 0; k < rows_.size();) {
      std::size_t end = k;
      while (end < rows_.size() && std::abs(rows_[end].dq) <= scale.rest_speed) ++end;
      if (end > k && rows_[end - 1].t - rows_[k].t > settings_.standstill) {
        for (std::size_t i = k; i < end; ++i) set("standstill", i, true);
        for (std::size_t i = end;
             i < rows_.size() && rows_[i].t - rows_[end - 1].t < settings_.breakaway; ++i)
          set("breakaway", i, true);
      }
      k = std::max(end, k + 1);
    }
  }
  template <class Set>
  void mark_steps(const Set& set) const {
    std::vector<double> changes;
    for (std::size_t k = 1; k < rows_.size(); ++k)
      changes.push_back(std::abs(rows_[k].command - rows_[k - 1].command));
    const double usual = quantile(changes, 0.95);
    for (std::size_t k = 1; k < rows_.size(); ++k) {
      if (!(std::abs(rows_[k].command - rows_[k - 1].command) > settings_.step * usual + 1e-6))
        continue;
      for (std::size_t i = k; i < rows_.size() && rows_[i].t - rows_[k].t < settings_.after_step;
           ++i)
        set("after a command step", i, true);
    }
  }

  const Source& source_;
  std::size_t j_;
  const RegimeSettings& settings_;
  std::vector<Row> rows_;
};

RegimeLimits scale_of(const std::vector<JointRegimes>& recordings, const RegimeSettings& settings) {
  std::vector<double> speed, load, volt, temp;
  for (const JointRegimes& joint : recordings) {
    for (const Row& r : joint.rows()) {
      speed.push_back(std::abs(r.dq)), load.push_back(std::abs(r.torque));
      volt.push_back(r.volt), temp.push_back(r.temp);
    }
  }
  RegimeLimits s;
  s.rest_speed = settings.standing * quantile(speed, 0.99);
  std::vector<double> moving;
  for (double v : speed) {
    if (v > s.rest_speed) moving.push_back(v);
  }
  s.slow = quantile(moving, 1.0 / 3), s.fast = quantile(moving, 2.0 / 3);
  s.low_load = quantile(load, 1.0 / 3), s.high_load = quantile(load, 2.0 / 3);
  s.low_volt = quantile(volt, 1.0 / 3), s.high_volt = quantile(volt, 2.0 / 3);
  s.low_temp = quantile(temp, 1.0 / 3), s.high_temp = quantile(temp, 2.0 / 3);
  return s;
}

}  // namespace

Regimes find_regimes(const Comparison& comparison) {
  Regimes out;
  out.names = {"reversal",   "standstill",   "breakaway",
               "low speed",  "middle speed", "high speed",
               "forwards",   "backwards",    "after a command step",
               "saturated",  "driving",      "back-driven",
               "low load",   "high load",    "near a limit",
               "torque off", "low voltage",  "high voltage",
               "cold",       "hot",          "first minute"};
  const std::size_t sources = comparison.sources.size(), n = comparison.joints.size();
  out.mask.assign(sources, std::vector<std::vector<std::vector<char>>>(n));
  std::vector<Replayed> recordings;
  for (const Source& source : comparison.sources)
    recordings.push_back({&source.nominal, &source.drive, &source.motion});
  const std::vector<ReplayTorques> torques = replay_torques(recordings);
  parallel_for(n, [&](std::size_t joint) {
    std::vector<JointRegimes> by_source;
    for (std::size_t s = 0; s < sources; ++s)
      by_source.emplace_back(comparison.sources[s], joint, torques[s], comparison.settings.regimes);
    const RegimeLimits scale = scale_of(by_source, comparison.settings.regimes);
    for (std::size_t s = 0; s < sources; ++s)
      by_source[s].fill(scale, out.mask[s][joint], out.names);
  });
  return out;
}

}  // namespace sanso::diagnose
