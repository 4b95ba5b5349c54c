// What is held changes at equal distances, however far it goes from one change to the next.
#include "tools/diagnose/gate/held.h"

#include <algorithm>
#include <cmath>

#include "tools/diagnose/stats/robust.h"

namespace sanso::diagnose {
namespace {

struct Change {
  std::size_t row = 0;
  double distance = 0.0;  // rows since the last change
  double step = 0.0;
};

std::vector<Change> changes_of(std::span<const double> x) {
  std::vector<Change> out;
  std::size_t last = x.size();
  double value = NAN;
  for (std::size_t k = 0; k < x.size(); ++k) {
    if (!std::isfinite(x[k]) || x[k] == value) continue;
    if (last < x.size()) out.push_back({k, static_cast<double>(k - last), std::abs(x[k] - value)});
    value = x[k], last = k;
  }
  return out;
}

/// Rows by which `late` changes after `first`, the offset at which most of its changes meet one.
int rows_after(const std::vector<Change>& first, const std::vector<Change>& late, int rows,
               double share) {
  std::vector<std::size_t> met(static_cast<std::size_t>(rows), 0);
  std::size_t i = 0;
  for (const Change& change : late) {
    while (i + 1 < first.size() && first[i + 1].row <= change.row) ++i;
    if (first.empty() || first[i].row > change.row) continue;
    const std::size_t after = change.row - first[i].row;
    if (after < met.size()) ++met[after];
  }
  const auto most = std::max_element(met.begin(), met.end());
  const bool clear = static_cast<double>(*most) >= share * static_cast<double>(late.size());
  return clear ? static_cast<int>(most - met.begin()) : 0;
}

}  // namespace

bool is_reading(const std::string& channel) {
  for (const char* kind : {"q:", "dq:", "tau:", "i:", "pwm:"}) {
    if (channel.rfind(kind, 0) == 0) return true;
  }
  return false;
}

int rows_between_refreshes(std::span<const double> x, const GateSettings& settings) {
  const std::vector<Change> changes = changes_of(x);
  std::vector<double> steps, distances;
  for (const Change& c : changes) steps.push_back(c.step);
  const double smallest = quantile(steps, 0.02);
  for (const Change& c : changes) {
    if (c.step > 1.5 * smallest) distances.push_back(c.distance);
  }
  if (distances.size() < static_cast<std::size_t>(settings.held_changes)) return 1;
  const double rows = std::floor(quantile(distances, 0.1));
  if (rows < 2.0) return 1;
  // a clock of its own beats with the rows: one more now and then
  const auto regular = std::count_if(distances.begin(), distances.end(),
                                     [&](double d) { return d == rows || d == rows + 1.0; });
  const bool held = static_cast<double>(regular) >=
                    (1.0 - settings.resting_share) * static_cast<double>(distances.size());
  return held ? static_cast<int>(rows) : 1;
}

std::vector<double> one_row_per_refresh(std::span<const double> x, int rows) {
  std::vector<double> out(x.begin(), x.end());
  if (rows < 2) return out;
  double value = NAN;
  int since = 0;
  for (double& v : out) {
    if (!std::isfinite(v)) continue;
    // at rest refreshes bring the same value: one is kept for each of them
    const bool refreshed = v != value || ++since > rows;
    if (refreshed)
      value = v, since = 0;
    else
      v = NAN;
  }
  return out;
}

std::vector<HeldChannel> held_channels(const GateRecording& r, const GateSettings& settings) {
  std::vector<HeldChannel> out;
  std::vector<std::vector<Change>> changes;
  for (const GateChannel& c : r.channels) {
    if (!is_reading(c.name)) continue;
    const int rows = rows_between_refreshes(c.values, settings);
    if (rows < 2) continue;
    out.push_back({c.name, rows, 0, {}});
    changes.push_back(changes_of(c.values));
  }
  for (std::size_t a = 0; a < out.size(); ++a) {
    for (std::size_t b = 0; b < out.size(); ++b) {
      if (a == b || out[a].rows != out[b].rows) continue;
      const int after =
          rows_after(changes[b], changes[a], out[a].rows, 1.0 - settings.resting_share);
      // later than half a period is earlier than the next refresh
      if (2 * after <= out[a].rows && after > out[a].late)
        out[a].late = after, out[a].before = out[b].channel;
    }
  }
  return out;
}

}  // namespace sanso::diagnose
