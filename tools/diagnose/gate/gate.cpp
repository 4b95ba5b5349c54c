// Checks of one file in groups: a broken clock or unit makes the later ones meaningless, so the
// first group that fails is the last one asked.
#include "tools/diagnose/gate/gate.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tools/diagnose/gate/checks.h"
#include "tools/diagnose/gate/held.h"
#include "tools/diagnose/gate/noise.h"
#include "tools/diagnose/gate/stale.h"
#include "tools/diagnose/stats/robust.h"

namespace sanso::diagnose {

const GateChannel* GateRecording::find(const std::string& name) const {
  for (const GateChannel& c : channels) {
    if (c.name == name) return &c;
  }
  return nullptr;
}

namespace {

/// All defects of one file. A broken clock or unit makes every later check meaningless, so the
/// checks stop at the first group that fails.
std::vector<Defect> inspect_one(const GateRecording& r, const std::vector<GateJoint>& joints,
                                const GateSettings& settings) {
  std::vector<Defect> out;
  for (auto* check : {&gate::check_size, &gate::check_time}) {
    gate::append(out, (*check)(r, settings));
    if (!out.empty()) return out;
  }
  using Check =
      std::vector<Defect> (*)(const GateRecording&, const gate::Joints&, const GateSettings&);
  for (const std::initializer_list<Check>& group :
       {std::initializer_list<Check>{gate::check_required},
        {gate::check_wraps},
        {gate::check_velocity_swaps},
        {gate::check_units},
        {gate::check_commands, gate::check_clipping, gate::check_stuck, gate::check_resumed}}) {
    for (Check check : group) gate::append(out, check(r, joints, settings));
    if (!out.empty()) return out;
  }
  gate::append(out, gate::check_clocks(r, joints, settings));
  if (out.empty()) gate::append(out, gate::check_clipped_commands(r, joints, settings));
  return out;
}

/// Changes of direction that go back by more than `hysteresis`.
int count_reversals(std::span<const double> x, double hysteresis) {
  int reversals = 0, direction = 0;
  double low = INFINITY, high = -INFINITY;  // extremes since the last change of direction
  for (double v : x) {
    if (!std::isfinite(v)) continue;
    low = std::min(low, v), high = std::max(high, v);
    const int now = v > low + hysteresis && direction <= 0    ? 1
                    : v < high - hysteresis && direction >= 0 ? -1
                                                              : 0;
    if (now == 0) continue;
    reversals += direction != 0;
    direction = now;
    low = high = v;
  }
  return reversals;
}

Excitation excitation_of(const std::vector<GateRecording>& recordings, const GateJoint& joint,
                         double sigma) {
  Excitation e;
  e.joint = joint.name;
  double square = 0.0, rows = 0.0;
  for (const GateRecording& r : recordings) {
    const GateChannel* q = r.find("q:" + joint.name);
    if (q == nullptr) continue;
    e.range = std::max(e.range, quantile(q->values, 0.995) - quantile(q->values, 0.005));
    e.reversals += count_reversals(q->values, 5.0 * sigma);
    const auto stride = std::max<std::size_t>(
        1, static_cast<std::size_t>(0.05 / std::max(gate::sampling_interval(r.t), 1e-6)));
    for (std::size_t i = stride; i < q->values.size(); i += stride) {
      const double v = (q->values[i] - q->values[i - stride]) / (r.t[i] - r.t[i - stride]);
      if (std::isfinite(v)) square += v * v, rows += 1.0;
    }
  }
  e.speed_rms = rows > 0.0 ? std::sqrt(square / rows) : 0.0;
  // ten noise levels: below, nothing the joint does can be told from noise
  e.moves = e.range > 10.0 * sigma;
  return e;
}

std::vector<std::string> legal_oddities(const GateRecording& r, const GateSettings& settings) {
  std::vector<std::string> notes;
  const std::string uneven = gate::uneven_sampling(r.file, r.t);
  if (!uneven.empty()) notes.push_back(uneven);
  for (const GateChannel& c : r.channels) {
    if (c.name.rfind("q:", 0) != 0) continue;
    int glitches = 0;
    gate::without_glitches(c.values, &glitches, settings);
    if (glitches > 0)
      notes.push_back(fmt::format("{}: {} has {} single-sample glitches; they are left out", r.file,
                                  c.name, glitches));
  }
  const std::vector<char> stale = stale_rows(r, settings);
  if (const auto lost = std::count(stale.begin(), stale.end(), 1); lost > 0) {
    notes.push_back(fmt::format(
        "{}: {} rows of {} repeat all readings of the row before though the motion went on (cycles "
        "of the bus that were lost); what they read is left out",
        r.file, lost, r.t.size()));
  }
  for (const HeldChannel& held : held_channels(r, settings)) {
    notes.push_back(fmt::format("{}: {} changes every {} rows only{}; one row of each is kept",
                                r.file, held.channel, held.rows,
                                held.late > 0
                                    ? fmt::format(", {} {} after {}", held.late,
                                                  held.late > 1 ? "rows" : "row", held.before)
                                    : std::string()));
  }
  return notes;
}

/// The rows of a channel that are new.
std::vector<double> refreshed(const GateChannel& c, const GateSettings& settings) {
  return one_row_per_refresh(c.values, rows_between_refreshes(c.values, settings));
}

/// Noise of a channel over all recordings: the median of those in which it changes (one file with a
/// glitch must not decide, and one at rest shows no noise).
NoiseLevel noise_over(const std::vector<GateRecording>& recordings, const std::string& name,
                      const GateSettings& settings) {
  NoiseLevel level;
  level.channel = name;
  std::vector<double> sigmas, quanta;
  for (const GateRecording& r : recordings) {
    const GateChannel* c = r.find(name);
    if (c == nullptr) continue;
    NoiseLevel here = noise_level(
        name, gate::without_glitches(refreshed(*c, settings), nullptr, settings), settings);
    if (here.sigma > 0.0) sigmas.push_back(here.sigma);
    if (here.quantum > 0.0) quanta.push_back(here.quantum);
    if (!here.colour.empty()) level.colour = std::move(here.colour);
  }
  if (!sigmas.empty()) level.sigma = median(sigmas);
  if (!quanta.empty()) level.quantum = median(quanta);
  return level;
}

std::string kind_of(const std::string& channel) { return channel.substr(0, channel.find(':')); }

/// A joint at rest shows no noise of its own: the encoder's step that the model states says it, or
/// the joints that move.
void fill_in_resting(std::vector<NoiseLevel>& noise, const std::vector<GateJoint>& joints) {
  for (NoiseLevel& level : noise) {
    const std::string kind = kind_of(level.channel);
    for (const GateJoint& joint : joints) {
      if (level.quantum == 0.0 && level.sigma == 0.0 && level.channel == "q:" + joint.name)
        level.quantum = joint.position_quantum;
    }
    std::vector<double> sigmas;
    for (const NoiseLevel& other : noise) {
      if (kind_of(other.channel) == kind && other.sigma > 0.0) sigmas.push_back(other.sigma);
    }
    if (level.sigma == 0.0 && level.quantum == 0.0 && !sigmas.empty()) level.sigma = median(sigmas);
  }
  for (NoiseLevel& level : noise)
    level.sigma = std::max(level.sigma, level.quantum / std::sqrt(12.0));
}

std::vector<NoiseLevel> noise_of_all(const std::vector<GateRecording>& recordings,
                                     const std::vector<GateJoint>& joints,
                                     const GateSettings& settings) {
  std::vector<NoiseLevel> noise;
  for (const GateRecording& r : recordings) {
    for (const GateChannel& c : r.channels) {
      const bool known = std::any_of(noise.begin(), noise.end(),
                                     [&](const NoiseLevel& n) { return n.channel == c.name; });
      if (!known) noise.push_back(noise_over(recordings, c.name, settings));
    }
  }
  fill_in_resting(noise, joints);
  return noise;
}

}  // namespace

GateReport inspect(const std::vector<GateRecording>& recordings,
                   const std::vector<GateJoint>& joints, const GateSettings& settings) {
  GateReport report;
  for (const GateRecording& r : recordings)
    gate::append(report.defects, inspect_one(r, joints, settings));
  if (report.defects.empty()) gate::append(report.defects, gate::check_copies(recordings));
  if (report.defects.empty())
    gate::append(report.defects, gate::check_clocks_between(recordings, joints, settings));
  if (report.refused()) return report;

  for (const GateRecording& r : recordings) {
    for (std::vector<std::string>& notes :
         std::array{legal_oddities(r, settings), gate::unfollowed_commands(r, joints)})
      std::move(notes.begin(), notes.end(), std::back_inserter(report.notes));
  }
  report.noise = noise_of_all(recordings, joints, settings);
  bool any = false;
  for (const GateJoint& joint : joints) {
    double sigma = 0.0;
    for (const NoiseLevel& n : report.noise) {
      if (n.channel == "q:" + joint.name) sigma = n.sigma;
    }
    report.excitation.push_back(excitation_of(recordings, joint, sigma));
    any |= report.excitation.back().moves;
  }
  if (!any) {
    report.defects.push_back(
        {recordings.empty() ? "" : recordings.front().file, "q:", -1, defect::kNoMotion,
         "no joint moves beyond its noise; a recording at rest cannot show what is missing"});
  }
  return report;
}

}  // namespace sanso::diagnose
