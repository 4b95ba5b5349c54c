// A robot at rest repeats its readings too, and one that breaks away moves on slowly. A row that
// was written again is followed by all that was missed at once:
//
//   caught up   |q after - q before| over the mean change of the rows before and after, of the
//               joint that went farthest: 2 and more after a lost cycle, at most 1 out of rest
//   by chance   the product of how often each reading repeats while others do not: coarse counts
#include "tools/diagnose/gate/stale.h"

#include <algorithm>
#include <cmath>

#include "tools/diagnose/gate/held.h"
#include "tools/diagnose/stats/robust.h"

namespace sanso::diagnose {
namespace {

bool is_position(const GateChannel& c) { return c.name.rfind("q:", 0) == 0; }

/// Sampled readings of row k are those of the row before; there is one of a position.
bool repeats(const std::vector<const GateChannel*>& readings, std::size_t k) {
  bool compared = false;
  for (const GateChannel* c : readings) {
    const double before = c->values[k - 1], here = c->values[k];
    if (std::isfinite(before) && std::isfinite(here) && before != here) return false;
    compared |= std::isfinite(before) && std::isfinite(here) && is_position(*c);
  }
  return compared;
}

/// Share of rows in which all readings would repeat if each did so by itself; 1 where one is alone.
double by_chance(const std::vector<const GateChannel*>& readings, const std::vector<char>& frame) {
  if (readings.size() < 2) return 1.0;
  double out = 1.0;
  for (const GateChannel* c : readings) {
    double sampled = 0.0, same = 0.0;
    for (std::size_t k = 1; k < frame.size(); ++k) {
      if (frame[k] != 0 || !std::isfinite(c->values[k]) || !std::isfinite(c->values[k - 1]))
        continue;
      sampled += 1.0;
      if (c->values[k] == c->values[k - 1]) same += 1.0;
    }
    if (sampled > 0.0) out *= same / sampled;
  }
  return out;
}

/// Rows [first, last) that repeat the row before.
struct Run {
  std::size_t first, last;
  double caught_up;  // see the head of the file
};

std::vector<double> steps_of(const GateChannel& c) {
  std::vector<double> out;
  for (std::size_t k = 1; k < c.values.size(); ++k) {
    const double step = std::abs(c.values[k] - c.values[k - 1]);
    if (step > 0.0) out.push_back(step);
  }
  return out;
}

double caught_up(const std::vector<const GateChannel*>& positions,
                 const std::vector<double>& smallest, std::size_t first, std::size_t last) {
  double out = 0.0, most = 1.5;  // counts
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const auto at = [&](std::size_t k) { return positions[i]->values[k]; };
    const double jump = std::abs(at(last) - at(first - 1)), counts = jump / smallest[i];
    const double around =
        0.5 * (std::abs(at(first - 1) - at(first - 2)) + std::abs(at(last + 1) - at(last)));
    if (!(counts > most) || !std::isfinite(around)) continue;
    most = counts;
    out = jump / std::max(around, smallest[i]);
  }
  return out;
}

}  // namespace

std::vector<char> stale_rows(const GateRecording& r, const GateSettings& settings) {
  std::vector<const GateChannel*> readings, positions;
  std::vector<double> smallest;
  for (const GateChannel& c : r.channels) {
    if (is_reading(c.name)) readings.push_back(&c);
    if (!is_position(c)) continue;
    const std::vector<double> steps = steps_of(c);
    if (steps.empty()) continue;
    positions.push_back(&c);
    smallest.push_back(quantile(steps, 0.02));
  }
  std::vector<char> frame(r.t.size(), 0), out(r.t.size(), 0);
  for (std::size_t k = 1; k < frame.size(); ++k) frame[k] = repeats(readings, k) ? 1 : 0;
  std::vector<Run> runs;
  for (std::size_t k = 2; k + 1 < frame.size(); ++k) {
    if (frame[k] == 0) continue;
    Run run{k, k + 1, 0.0};
    while (run.last < frame.size() && frame[run.last] != 0) ++run.last;
    k = run.last;
    if (run.last + 1 >= frame.size()) break;
    run.caught_up = caught_up(positions, smallest, run.first, run.last);
    if (run.caught_up > 0.0) runs.push_back(run);
  }
  if (runs.size() < static_cast<std::size_t>(settings.held_changes)) return {};
  std::vector<double> all;
  all.reserve(runs.size());
  for (const Run& run : runs) all.push_back(run.caught_up);
  if (median(all) < settings.stale_step) return {};
  const auto share = [&frame](const std::vector<char>& rows) {
    return static_cast<double>(std::count(rows.begin(), rows.end(), 1)) /
           static_cast<double>(frame.size());
  };
  const double chance = settings.stale_beyond * by_chance(readings, frame);
  // so rarely by themselves that one in ten of them is all that chance can have made
  if (share(frame) > 10.0 * chance) return frame;
  for (const Run& run : runs) {
    if (run.caught_up < 0.5 * settings.stale_step) continue;
    std::fill(out.begin() + static_cast<std::ptrdiff_t>(run.first),
              out.begin() + static_cast<std::ptrdiff_t>(run.last), 1);
  }
  if (share(out) < chance) return {};
  return out;
}

}  // namespace sanso::diagnose
