#include "tools/diagnose/explain/incidence.h"

#include <fmt/format.h>

#include <cmath>
#include <map>

#include "tools/diagnose/explain/effort_law.h"

namespace sanso::diagnose {
namespace {

struct Sums {
  std::vector<double> dr, dd;  // by shot: promised . measured, promised . promised
  bool effort = false;
  double rows = 0.0;
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

IncidenceRow row_of(const std::string& name, const Sums& sums) {
  IncidenceRow row;
  row.residual = name;
  double dr = 0.0, dd = 0.0;
  for (std::size_t s = 0; s < sums.dd.size(); ++s) dr += sums.dr[s], dd += sums.dd[s];
  row.predicted = std::sqrt(dd);
  row.slope = dd > 0.0 ? dr / dd : 0.0;
  double square = 0.0;
  for (std::size_t s = 0; s < sums.dd.size(); ++s) {
    const double e = sums.dr[s] - row.slope * sums.dd[s];
    square += e * e;
  }
  const double half = dd > 0.0 ? 1.96 * std::sqrt(square) / dd : 0.0;
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

/// Torque, current and duty: replaces the simulated changes by those of the servo's law where the
/// joints really were.
void judge_efforts_at_the_measured_motion(const Surroundings& around, const Model& without,
                                          const Model& with, Eigen::VectorXd& measured,
                                          Eigen::VectorXd& promised) {
  const Problem& problem = *around.problem;
  const Eigen::VectorXd error = effort_error(problem, *around.library, without);
  const Eigen::VectorXd change = error - effort_error(problem, *around.library, with);
  for (const Shot& shot : problem.shots) {
    for (std::size_t c = 0; c < problem.channels.size(); ++c) {
      if (!is_effort(problem.channels[c].signal)) continue;
      const auto from = static_cast<Eigen::Index>(shot.offset + c * shot.rows);
      const auto rows = static_cast<Eigen::Index>(shot.rows);
      measured.segment(from, rows) = error.segment(from, rows);
      promised.segment(from, rows) = change.segment(from, rows);
    }
  }
}

}  // namespace

std::vector<IncidenceRow> incidence(const Surroundings& around, const Regimes& regimes,
                                    const FitResult& without, const FitResult& with) {
  const Problem& problem = *around.problem;
  Eigen::VectorXd measured = around.starts.project(without.r);
  Eigen::VectorXd promised = around.starts.project(without.r - with.r);
  judge_efforts_at_the_measured_motion(around, less_the_effect(without.model, with.model),
                                       with.model, measured, promised);
  std::map<std::string, Sums> table;
  double total = 0.0;
  for (std::size_t s = 0; s < problem.shots.size(); ++s) {
    const Shot& shot = problem.shots[s];
    for (std::size_t c = 0; c < problem.channels.size(); ++c) {
      const Observed& channel = problem.channels[c];
      const auto add = [&](const std::string& name, double dr, double dd) {
        Sums& sums = table[name];
        sums.dr.resize(problem.shots.size(), 0.0);
        sums.dd.resize(problem.shots.size(), 0.0);
        sums.dr[s] += dr;
        sums.dd[s] += dd;
        sums.rows += 1.0;
        sums.effort = is_effort(channel.signal);
      };
      for (std::size_t k = 0; k < shot.rows; ++k) {
        const auto i = static_cast<Eigen::Index>(shot.offset + c * shot.rows + k);
        const double dr = promised[i] * measured[i], dd = promised[i] * promised[i];
        if (!is_effort(channel.signal)) total += dd;
        add(words(channel.signal), dr, dd);
        if (channel.signal != Signal::q) continue;
        const std::size_t row = shot.window.first + (k + 1) * static_cast<std::size_t>(shot.stride);
        for (std::size_t g = 0; g < regimes.names.size(); ++g) {
          if (regimes.in(shot.source, channel.joint, g, row))
            add("position, " + regimes.names[g], dr, dd);
        }
      }
    }
  }
  std::vector<IncidenceRow> out;
  for (const auto& [name, sums] : table) {
    const IncidenceRow row = row_of(name, sums);
    // the servo's law is trusted to its channel's floor only: less than that a row on average is no
    // promise
    const double least = sums.effort ? sums.rows : 0.02 * total;
    const bool told = row.predicted > 5.0 && row.predicted * row.predicted > least;
    if (told) out.push_back(row);
  }
  return out;
}

std::string refuted_by(const std::vector<IncidenceRow>& rows) {
  for (const IncidenceRow& row : rows) {
    if (row.high < 0.5)
      return fmt::format("{}: {:.0f} % of the promised change happened", row.residual,
                         100 * row.slope);
    if (row.low > 2.0)
      return fmt::format("{}: {:.1f} times the promised change happened", row.residual, row.slope);
  }
  return "";
}

}  // namespace sanso::diagnose
