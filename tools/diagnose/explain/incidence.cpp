// An explanation is asked what it would change, residual by residual, and held to it.
#include "tools/diagnose/explain/incidence.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/explain/effort_law.h"
#include "tools/diagnose/stats/significance.h"

namespace sanso::diagnose {
namespace {

struct Sums {
  ErrorPart residual;
  std::vector<double> dr, dd;  // by shot: promised . measured, promised . promised
  double rows = 0.0;
};

struct Table {
  std::map<std::string, Sums> residuals;  // by their names: the order in which they are told
  double total = 0.0;                     // d'd of the channels that the motion gives
};

const char* words(Signal signal) {
  switch (signal) {
    case Signal::q:
      return "position";
    case Signal::dq:
      return "velocity";
    case Signal::tau:
      return "torque";
    case Signal::i:
      return "current";
    case Signal::pwm:
      return "duty";
  }
  return "position";
}

/// One residual over its shots s:
///
///   slope     = sum_s d_s'r_s / sum_s d_s'd_s       1: as promised, 0: did not happen
///   predicted = sqrt(sum_s d_s'd_s)                 noise levels
///   low, high = slope -+ 1.96 sqrt(sum_s (d_s'r_s - slope d_s'd_s)^2 / (1 - h_s)^2)
///                              / sum_s d_s'd_s,     h_s = d_s'd_s / sum d'd
///
/// A shot is one observation: errors of neighbouring rows are not independent. Without h (the
/// jackknife's, MacKinnon and White 1985) a shot that holds most of the promise would seem to be
/// certain of it.
IncidenceRow row_of(const Sums& sums) {
  IncidenceRow row;
  row.residual = sums.residual;
  double dr = 0.0, dd = 0.0;
  for (std::size_t s = 0; s < sums.dd.size(); ++s) dr += sums.dr[s], dd += sums.dd[s];
  row.predicted = std::sqrt(dd);
  row.slope = dd > 0.0 ? dr / dd : 0.0;
  double square = 0.0;
  for (std::size_t s = 0; s < sums.dd.size() && dd > 0.0; ++s) {
    const double leverage = sums.dd[s] / dd;
    const double e = (sums.dr[s] - row.slope * sums.dd[s]) / std::max(1.0 - leverage, 1e-3);
    square += e * e;
  }
  const double half = dd > 0.0 ? kNormal95 * std::sqrt(square) / dd : 0.0;
  row.low = row.slope - half;
  row.high = row.slope + half;
  return row;
}

/// `with` less the effects that `without` does not have: what differs is the effect itself, none of
/// the calibrations that are fitted anew without it.
Model less_the_effect(const Model& without, const Model& with) {
  Model out = with;
  std::erase_if(out.effects, [&](const Chosen& c) { return !without.has(c.candidate); });
  return out;
}

/// What there is and what is promised, stacked.
struct Changes {
  Eigen::VectorXd error, promised;
};

/// Torque, current and duty: the changes of the servo's law where the joints really were take the
/// place of the simulated ones.
Changes with_efforts_at_the_measured_motion(const Surroundings& around, const Model& without,
                                            const Model& with, Changes simulated) {
  const Comparison& comparison = *around.problem;
  Eigen::VectorXd error, beside;
  parallel_for(2, [&](std::size_t i) {
    (i == 0 ? error : beside) = effort_error(comparison, *around.library, i == 0 ? without : with);
  });
  const Eigen::VectorXd change = error - beside;
  for (const Shot& shot : comparison.shots) {
    for (std::size_t c = 0; c < comparison.channels.size(); ++c) {
      if (!is_effort(comparison.channels[c].signal)) continue;
      rows_of(simulated.error, shot, c) = rows_of(error, shot, c);
      rows_of(simulated.promised, shot, c) = rows_of(change, shot, c);
    }
  }
  return simulated;
}

/// Adds one shot of one channel to the residuals in which it counts.
void add_shot(const Comparison& comparison, const Regimes& regimes, std::size_t s, std::size_t c,
              const Eigen::VectorXd& r, const Eigen::VectorXd& d, Table& table) {
  const Shot& shot = comparison.shots[s];
  const Observed& channel = comparison.channels[c];
  const auto sums_in = [&](const std::string& regime) {
    const ErrorPart residual{channel.signal, regime};
    Sums& sums = table.residuals[to_string(residual)];
    sums.residual = residual;
    sums.dr.resize(comparison.shots.size(), 0.0);
    sums.dd.resize(comparison.shots.size(), 0.0);
    return &sums;
  };
  const auto add = [s](Sums& sums, double dr, double dd) {
    sums.dr[s] += dr;
    sums.dd[s] += dd;
    sums.rows += 1.0;
  };
  Sums& whole = *sums_in("");
  std::vector<Sums*> by_regime;
  if (channel.signal == Signal::q) {
    for (const std::string& regime : regimes.names) by_regime.push_back(sums_in(regime));
  }
  const auto there = rows_of(r, shot, c), promised = rows_of(d, shot, c);
  for (std::size_t k = 0; k < shot.rows; ++k) {
    const double dr = promised[k] * there[k], dd = promised[k] * promised[k];
    if (!is_effort(channel.signal)) table.total += dd;
    add(whole, dr, dd);
    const std::size_t row = recorded_row(shot, k);
    for (std::size_t g = 0; g < by_regime.size(); ++g) {
      if (regimes.in(shot.source, channel.joint, g, row)) add(*by_regime[g], dr, dd);
    }
  }
}

Table sums_of(const Comparison& comparison, const Regimes& regimes, const Eigen::VectorXd& r,
              const Eigen::VectorXd& d) {
  Table table;
  for (std::size_t s = 0; s < comparison.shots.size(); ++s) {
    for (std::size_t c = 0; c < comparison.channels.size(); ++c)
      add_shot(comparison, regimes, s, c, r, d, table);
  }
  return table;
}

}  // namespace

std::string to_string(const ErrorPart& residual) {
  const std::string signal = words(residual.signal);
  return residual.regime.empty() ? signal : signal + ", " + residual.regime;
}

std::vector<IncidenceRow> incidence(const Surroundings& around, const Regimes& regimes,
                                    const FitResult& without, const FitResult& with) {
  // r: the error that is there; d: the change of it that the explanation promises
  const auto [r, d] = with_efforts_at_the_measured_motion(
      around, less_the_effect(without.model, with.model), with.model,
      {around.starts.project(without.r), around.starts.project(without.r - with.r)});
  const DecisionSettings& decisions = around.settings().decisions;
  const Table table = sums_of(*around.problem, regimes, r, d);
  std::vector<IncidenceRow> out;
  for (const auto& [name, sums] : table.residuals) {
    const IncidenceRow row = row_of(sums);
    // the servo's law is trusted to its channel's floor only: less than that a row on average is no
    // promise
    const double least =
        is_effort(sums.residual.signal) ? sums.rows : decisions.promised_share * table.total;
    const bool told = row.predicted > decisions.promised && row.predicted * row.predicted > least;
    if (told) out.push_back(row);
  }
  return out;
}

std::string refuted_by(const std::vector<IncidenceRow>& rows, const DecisionSettings& decisions) {
  if (rows.empty()) return "";
  // of twenty true promises one lies outside its 95 %: the intervals are widened until all of them
  // hold together
  const double widened =
      std::max(1.0, normal_score(0.025 / static_cast<double>(rows.size())) / kNormal95);
  for (const IncidenceRow& row : rows) {
    if (row.slope + widened * (row.high - row.slope) < decisions.happened_least)
      return fmt::format("{}: {:.0f} % of the promised change happened", to_string(row.residual),
                         100 * row.slope);
    if (row.slope + widened * (row.low - row.slope) > decisions.happened_most)
      return fmt::format("{}: {:.1f} times the promised change happened", to_string(row.residual),
                         row.slope);
  }
  return "";
}

}  // namespace sanso::diagnose
