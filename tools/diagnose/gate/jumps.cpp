// A jump is judged by what the same recording shows elsewhere, so no speed limit has to be known.
#include "tools/diagnose/gate/jumps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "tools/diagnose/gate/noise.h"
#include "tools/diagnose/stats/robust.h"

namespace sanso::diagnose {
namespace {

/// The sampled rows of one position; a speed or a place is taken over `span` of them.
struct Track {
  std::size_t span = 0;
  std::vector<std::size_t> row;
  std::vector<double> t, q;
  std::size_t size() const { return q.size(); }
};

Track track_of(const GateRecording& r, const GateChannel& c, int span) {
  Track out;
  out.span = static_cast<std::size_t>(span);
  for (std::size_t k = 0; k < c.values.size(); ++k) {
    if (!std::isfinite(c.values[k])) continue;
    out.row.push_back(k), out.t.push_back(r.t[k]), out.q.push_back(c.values[k]);
  }
  return out;
}

/// From row i to row i + x.span, rad/s (m/s).
double speed_from(const Track& x, std::size_t i) {
  return std::abs(x.q[i + x.span] - x.q[i]) / (x.t[i + x.span] - x.t[i]);
}

/// Fastest motion around the step into row i that does not contain it.
double speed_around(const Track& x, std::size_t i) {
  double fastest = 0.0;
  for (std::size_t back = 1; back <= 2 * x.span; ++back) {
    if (i >= back + x.span) fastest = std::max(fastest, speed_from(x, i - back - x.span));
    if (i + back + x.span <= x.size()) fastest = std::max(fastest, speed_from(x, i + back - 1));
  }
  return fastest;
}

/// Whether the places before and after differ as the step into row i does: a glitch comes back.
bool stays(const Track& x, std::size_t i) {
  if (i < x.span || i + x.span > x.size()) return false;
  const std::span<const double> q = x.q;
  const auto at = [&](std::size_t first) { return median(q.subspan(first, x.span)); };
  return std::abs(at(i) - at(i - x.span)) > 0.5 * std::abs(x.q[i] - x.q[i - 1]);
}

void add_jumps(const Track& x, const GateSettings& settings, std::vector<std::size_t>& rows) {
  if (x.size() < 4 * x.span) return;
  std::vector<double> speeds;
  for (std::size_t i = 0; i + x.span < x.size(); ++i) speeds.push_back(speed_from(x, i));
  // a step into row i stands in x.span of these; a hundredth are more than a few jumps make
  const double fastest = quantile(speeds, 0.99);
  const double quantum = quantisation_step(x.q);
  const double least = std::max(settings.jump_dropout * fastest, settings.jump_quanta * quantum);
  for (std::size_t i = x.span; i + x.span <= x.size(); ++i) {
    const double step = std::abs(x.q[i] - x.q[i - 1]), dt = x.t[i] - x.t[i - 1];
    if (!(step > least) || !stays(x, i)) continue;
    if (step > settings.jump_steps * speed_around(x, i) * dt) rows.push_back(x.row[i]);
  }
}

recording::Recording piece_of(const recording::Recording& whole, std::size_t first,
                              std::size_t last) {
  recording::Recording out = whole;
  const auto part = [&](const std::vector<double>& x) {
    return std::vector<double>(x.begin() + static_cast<std::ptrdiff_t>(first),
                               x.begin() + static_cast<std::ptrdiff_t>(last));
  };
  out.t = part(whole.t);
  for (recording::Channel& c : out.channels) c.values = part(c.values);
  out.header_line = whole.header_line + static_cast<int>(first);
  out.file = fmt::format("{} from {:.4g} s", whole.file, out.t.front());
  return out;
}

}  // namespace

std::vector<std::size_t> position_jumps(const GateRecording& r,
                                        const std::vector<GateJoint>& joints,
                                        const GateSettings& settings) {
  std::vector<std::size_t> rows;
  for (const GateJoint& joint : joints) {
    const GateChannel* q = r.find("q:" + joint.name);
    if (q != nullptr) add_jumps(track_of(r, *q, settings.jump_rows), settings, rows);
  }
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  return rows;
}

std::vector<recording::Recording> cut_at(recording::Recording whole,
                                         const std::vector<std::size_t>& rows,
                                         const GateSettings& settings) {
  std::vector<recording::Recording> out;
  if (rows.empty()) {
    out.push_back(std::move(whole));
    return out;
  }
  std::vector<std::size_t> ends = rows;
  ends.push_back(whole.rows());
  std::size_t first = 0;
  for (const std::size_t last : ends) {
    const bool enough = last >= first + static_cast<std::size_t>(settings.least_rows) &&
                        whole.t[last - 1] - whole.t[first] >= settings.least_seconds;
    if (enough) out.push_back(piece_of(whole, first, last));
    first = last;
  }
  return out;
}

}  // namespace sanso::diagnose
