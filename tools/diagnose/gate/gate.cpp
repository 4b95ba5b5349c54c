// Checks of one file in groups: a broken clock or unit makes the later ones meaningless, so the
// first group that fails is the last one asked.
#include "tools/diagnose/gate/gate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/diagnose/gate/checks.h"
#include "tools/diagnose/gate/noise.h"
#include "tools/diagnose/stats/robust.h"

namespace sanso::diagnose {

const GateChannel* GateRecording::find(const std::string& name) const {
  for (const GateChannel& c : channels) {
    if (c.name == name) return &c;
  }
  return nullptr;
}

namespace {

void append(std::vector<Defect>& to, std::vector<Defect> from) {
  to.insert(to.end(), std::make_move_iterator(from.begin()), std::make_move_iterator(from.end()));
}

/// All defects of one file. A broken clock or unit makes every later check meaningless, so the
/// checks stop at the first group that fails.
std::vector<Defect> inspect_one(const GateRecording& r, const std::vector<GateJoint>& joints) {
  std::vector<Defect> out;
  for (auto* check : {&gate::check_size, &gate::check_time}) {
    append(out, (*check)(r));
    if (!out.empty()) return out;
  }
  using Check = std::vector<Defect> (*)(const GateRecording&, const std::vector<GateJoint>&);
  for (const std::initializer_list<Check>& group :
       {std::initializer_list<Check>{gate::check_required},
        {gate::check_wraps},
        {gate::check_units},
        {gate::check_commands, gate::check_clipping, gate::check_stuck}}) {
    for (Check check : group) append(out, check(r, joints));
    if (!out.empty()) return out;
  }
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

void note_legal_oddities(const GateRecording& r, std::vector<std::string>& notes) {
  const double interval = gate::sampling_interval(r.t);
  std::vector<double> steps;
  for (std::size_t i = 1; i < r.t.size(); ++i) steps.push_back(r.t[i] - r.t[i - 1]);
  const double jitter = robust_sigma(steps) / std::max(interval, 1e-12);
  if (jitter > 0.1)
    notes.push_back(
        fmt::format("{}: sampling varies by {:.0f} % of {:.3g} s", r.file, 100 * jitter, interval));
  for (const GateChannel& c : r.channels) {
    if (c.name.rfind("q:", 0) != 0) continue;
    int glitches = 0;
    gate::without_glitches(c.values, &glitches);
    if (glitches > 0)
      notes.push_back(fmt::format("{}: {} has {} single-sample glitches; they are left out", r.file,
                                  c.name, glitches));
  }
}

}  // namespace

GateReport inspect(const std::vector<GateRecording>& recordings,
                   const std::vector<GateJoint>& joints) {
  GateReport report;
  for (const GateRecording& r : recordings) append(report.defects, inspect_one(r, joints));
  if (report.defects.empty()) append(report.defects, gate::check_copies(recordings));
  if (report.refused()) return report;

  for (const GateRecording& r : recordings) note_legal_oddities(r, report.notes);
  // noise: per channel, median over the recordings (one file with a glitch must not decide)
  std::vector<std::string> names;
  for (const GateRecording& r : recordings) {
    for (const GateChannel& c : r.channels) {
      if (std::find(names.begin(), names.end(), c.name) == names.end()) names.push_back(c.name);
    }
  }
  for (const std::string& name : names) {
    std::vector<double> sigmas;
    NoiseLevel level;
    for (const GateRecording& r : recordings) {
      if (const GateChannel* c = r.find(name)) {
        level = noise_level(name, gate::without_glitches(c->values));
        sigmas.push_back(level.sigma);
      }
    }
    level.sigma = median(sigmas);
    report.noise.push_back(std::move(level));
  }
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
