// Cuts recordings into shots of equal length, thins them, chooses the channels that are compared
// and divides the shots into groups that are held out together.
#include "tools/diagnose/compare/problem.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/effects/from_model.h"
#include "tools/diagnose/gate/checks.h"
#include "tools/diagnose/stats/robust.h"
#include "tools/diagnose/stats/smoother.h"

namespace sanso::diagnose {

namespace {

/// Recordings faster than `fastest_rate` [Hz]: commands and efforts averaged over blocks (their
/// impulse is what acts), positions and velocities taken at the block's first row that has one.
recording::Recording thinned(const recording::Recording& r, double fastest_rate) {
  const double rate = 1.0 / std::max(gate::sampling_interval(r.t), 1e-9);
  const auto block = static_cast<std::size_t>(std::ceil(rate / fastest_rate));
  if (block <= 1) return r;
  recording::Recording out = r;
  out.t.clear();
  for (recording::Channel& c : out.channels) c.values.clear();
  for (std::size_t k = 0; k + block <= r.rows(); k += block) {
    out.t.push_back(r.t[k]);
    for (std::size_t c = 0; c < r.channels.size(); ++c) {
      const std::vector<double>& from = r.channels[c].values;
      const bool instant =
          r.channels[c].name.rfind("q:", 0) == 0 || r.channels[c].name.rfind("dq:", 0) == 0;
      const bool commanded =
          r.channels[c].name.rfind("u:", 0) == 0 || r.channels[c].name.rfind("tau_cmd:", 0) == 0;
      const std::vector<double> rows = finite_values(std::span(from).subspan(k, block));
      // a command that is missing in one row is off there
      const bool off = commanded && rows.size() < block;
      out.channels[c].values.push_back(off || rows.empty() ? NAN
                                       : instant           ? rows.front()
                                                           : mean(rows));
    }
  }
  return out;
}

NoiseLevel level_of(const std::vector<NoiseLevel>& noise, const std::string& channel) {
  for (const NoiseLevel& n : noise) {
    if (n.channel == channel) return n;
  }
  return {};
}
double noise_of(const std::vector<NoiseLevel>& noise, const std::string& channel) {
  return level_of(noise, channel).sigma;
}

void smooth_source(Source& source, const std::vector<double>& sigmas, const Settings& settings) {
  const std::size_t n = source.drive.joints.size(), rows = source.drive.rows();
  source.motion.q.assign(n, std::vector<double>(rows, 0.0));
  source.motion.dq = source.q_sigma = source.dq_sigma = source.motion.q;
  for (std::size_t j = 0; j < n; ++j) {
    JointData& data = source.drive.joints[j];
    if (data.q.empty()) continue;
    data.q = gate::without_glitches(data.q, nullptr, settings.gate);
    SmoothedState state = smooth_position(source.drive.t, data.q, sigmas[j], settings.smoother,
                                          settings.data.likelihood_rows);
    source.motion.q[j] = std::move(state.q);
    source.motion.dq[j] = std::move(state.dq);
    source.q_sigma[j] = std::move(state.q_sigma);
    source.dq_sigma[j] = std::move(state.dq_sigma);
  }
}

}  // namespace

double shot_seconds(const std::vector<Source>& sources, const DataSettings& settings) {
  double seconds = settings.shot_seconds;
  for (const Source& s : sources) {
    std::vector<double> steps;
    for (std::size_t k = 1; k < s.drive.t.size(); ++k)
      steps.push_back(s.drive.t[k] - s.drive.t[k - 1]);
    if (!steps.empty())
      seconds = std::max(seconds, settings.least_shot_rows * quantile(steps, 0.5));
  }
  return seconds;
}

std::vector<Source> make_sources(const ModelFolder& model,
                                 const std::vector<recording::Recording>& recordings,
                                 const std::vector<NoiseLevel>& noise, const Settings& settings) {
  std::vector<Source> sources(recordings.size());
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    const recording::Recording r = thinned(recordings[i], settings.data.fastest_rate);
    const ModelFolder here = with_overrides(model, r);
    sources[i].file = r.file;
    sources[i].condition = r.condition;
    sources[i].drive = make_drive(r, here);
    sources[i].nominal = params_with_effects(here, settings.simulation);
  }
  std::vector<double> sigmas;
  for (const TreeJoint& joint : model.tree.joints) {
    const double range = [&] {
      double widest = 0.0;
      for (const recording::Recording& r : recordings) {
        const auto q = r.find("q:" + joint.name);
        if (!q.empty()) widest = std::max(widest, quantile(q, 1.0) - quantile(q, 0.0));
      }
      return widest;
    }();
    sigmas.push_back(std::max({noise_of(noise, "q:" + joint.name), 1e-6 * range, 1e-9}));
  }
  parallel_for(sources.size(), [&](std::size_t i) { smooth_source(sources[i], sigmas, settings); });
  return sources;
}

namespace {

/// The channels that at least one recording holds, with their standard deviations.
std::vector<Observed> observed_channels(const Comparison& comparison,
                                        const std::vector<NoiseLevel>& noise, bool secondary) {
  std::vector<Observed> out;
  for (std::size_t j = 0; j < comparison.joints.size(); ++j) {
    for (Signal signal : {Signal::q, Signal::dq, Signal::tau, Signal::i, Signal::pwm}) {
      if (signal != Signal::q && !secondary) continue;
      const Actuator actuator = comparison.sources.front().nominal.joints[j].nominal.actuator;
      if ((signal == Signal::i || signal == Signal::pwm) && actuator != Actuator::dc_servo)
        continue;
      if (signal == Signal::tau && actuator == Actuator::passive) continue;
      std::vector<double> values;
      for (const Source& s : comparison.sources) {
        const std::vector<double>& c = column(s.drive.joints[j], signal);
        values.insert(values.end(), c.begin(), c.end());
      }
      if (finite_values(values).empty()) continue;
      Observed channel;
      channel.signal = signal;
      channel.joint = j;
      const NoiseLevel level =
          level_of(noise, std::string(to_string(signal)) + ":" + comparison.joints[j]);
      const double sigma = level.sigma;
      channel.quantum = level.quantum;
      const double floor = signal == Signal::q
                               ? comparison.settings.data.model_floor *
                                     (quantile(values, 0.99) - quantile(values, 0.01))
                               : comparison.settings.data.secondary_floor * rms(values);
      channel.noise = std::max(sigma, 1e-12);
      channel.floor = std::max({sigma, floor, 1e-9});
      out.push_back(channel);
    }
  }
  return out;
}

void add_shots(Comparison& comparison, std::size_t source_index, double seconds) {
  const Source& source = comparison.sources[source_index];
  const std::vector<double>& t = source.drive.t;
  const auto compared = static_cast<std::size_t>(comparison.settings.data.compared_rows);
  for (std::size_t first = 0; first + 1 < t.size();) {
    std::size_t last = first;
    while (last + 1 < t.size() && t[last + 1] - t[first] <= seconds + 1e-9) ++last;
    if (last < first + 5) break;
    // the rest of the recording is too short for a shot
    if (t[last] - t[first] < 0.5 * seconds) break;
    Shot shot;
    shot.source = source_index;
    shot.window.first = first;
    shot.window.last = last;
    for (std::size_t j = 0; j < comparison.joints.size(); ++j) {
      shot.window.q.push_back(source.motion.q[j][first]);
      shot.window.dq.push_back(source.motion.dq[j][first]);
    }
    shot.stride = std::max<std::size_t>(1, (last - first) / compared);
    // row `first` itself is the start, not a prediction
    shot.rows = (last - first) / shot.stride;
    comparison.shots.push_back(std::move(shot));
    first = last;
  }
}

/// Keeps an even choice of shots when there are more than the budget allows, and those at the
/// instants.
void thin_shots(Comparison& comparison, int maximum_rows, int maximum_shots) {
  std::size_t total = 0;
  for (const Shot& s : comparison.shots) total += s.rows * comparison.joints.size();
  const auto share = [](int allowed, std::size_t there) {
    return static_cast<double>(allowed) / static_cast<double>(std::max<std::size_t>(there, 1));
  };
  comparison.used_share =
      std::min({1.0, share(maximum_rows, total), share(maximum_shots, comparison.shots.size())});
  if (comparison.used_share >= 1.0) return;
  std::vector<Shot> kept;
  double credit = 0.5;
  for (Shot& s : comparison.shots) {
    credit += comparison.used_share;
    const bool chosen = credit >= 1.0;
    if (chosen) credit -= 1.0;
    const bool wanted = std::any_of(comparison.instants.begin(), comparison.instants.end(),
                                    [&](double t) { return near_instant(comparison, s, t); });
    if (chosen || wanted) kept.push_back(std::move(s));
  }
  comparison.shots = std::move(kept);
}

/// Held-out groups: whole recordings when there are at least three, else contiguous blocks of each
/// recording.
void assign_groups(Comparison& comparison) {
  std::map<std::string, std::size_t> conditions;
  // source -> (number of shots, shots so far)
  std::map<std::size_t, std::pair<std::size_t, std::size_t>> seen;
  for (const Shot& s : comparison.shots) ++seen[s.source].first;
  const std::size_t sources = comparison.sources.size();
  const auto folds = static_cast<std::size_t>(comparison.settings.decisions.folds);
  const std::size_t blocks = sources >= 3 ? 1 : folds / sources;
  for (Shot& s : comparison.shots) {
    auto& [total, index] = seen[s.source];
    s.group = sources >= 3 ? s.source % 5 : s.source * blocks + index * blocks / total;
    ++index;
    const auto place =
        conditions.emplace(comparison.sources[s.source].condition, conditions.size());
    s.condition = place.first->second;
    comparison.groups = std::max(comparison.groups, s.group + 1);
  }
  comparison.conditions = conditions.size();
}

}  // namespace

Problem make_problem(std::vector<Source> sources, const std::vector<NoiseLevel>& noise,
                     const ProblemOptions& options, const Settings& settings) {
  Comparison out;
  out.settings = settings;
  out.sources = std::move(sources);
  for (const TreeJoint& joint : out.sources.front().nominal.tree.joints)
    out.joints.push_back(joint.name);
  out.channels = observed_channels(out, noise, options.secondary);
  out.instants = options.instants;
  out.struck = options.struck;
  for (std::size_t i = 0; i < out.sources.size(); ++i) add_shots(out, i, options.shot_seconds);
  thin_shots(out, options.maximum_rows, options.maximum_shots);
  for (Shot& s : out.shots) {
    s.offset = out.size;
    out.size += s.rows * out.channels.size();
  }
  assign_groups(out);
  Scales scales = floors(out);
  return {std::make_shared<const Comparison>(std::move(out)), std::move(scales)};
}

}  // namespace sanso::diagnose
