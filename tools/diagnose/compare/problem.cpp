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

const char* to_string(Signal signal) {
  switch (signal) {
    case Signal::q:
      return "q";
    case Signal::dq:
      return "dq";
    case Signal::tau:
      return "tau";
    case Signal::i:
      return "i";
    case Signal::pwm:
      return "pwm";
  }
  return "q";
}

namespace {

const std::vector<double>& column(const JointData& data, Signal signal) {
  switch (signal) {
    case Signal::dq:
      return data.dq;
    case Signal::tau:
      return data.tau;
    case Signal::i:
      return data.i;
    case Signal::pwm:
      return data.pwm;
    default:
      return data.q;
  }
}

/// Recordings faster than `fastest_rate` [Hz]: commands and efforts averaged over blocks (their
/// impulse is what acts), positions taken at the block's first row.
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
      double sum = 0.0;
      for (std::size_t i = k; i < k + block; ++i) sum += from[i];
      out.channels[c].values.push_back(instant ? from[k] : sum / static_cast<double>(block));
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

void smooth_source(Source& source, const std::vector<double>& sigmas, int likelihood_rows) {
  const std::size_t n = source.drive.joints.size(), rows = source.drive.rows();
  source.motion.q.assign(n, std::vector<double>(rows, 0.0));
  source.motion.dq = source.q_sigma = source.dq_sigma = source.motion.q;
  for (std::size_t j = 0; j < n; ++j) {
    JointData& data = source.drive.joints[j];
    if (data.q.empty()) continue;
    data.q = gate::without_glitches(data.q);
    SmoothedState state = smooth_position(source.drive.t, data.q, sigmas[j], likelihood_rows);
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

double measured(const Source& source, const Observed& channel, std::size_t row) {
  const JointData& data = source.drive.joints[static_cast<std::size_t>(channel.joint)];
  const std::vector<double>& values = column(data, channel.signal);
  if (row >= values.size()) return NAN;
  // an actuator that is off reports duty and current of its own convention
  const bool electrical = channel.signal != Signal::q && channel.signal != Signal::dq;
  if (electrical && row < data.command.size() && std::isnan(data.command[row])) return NAN;
  return values[row];
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
    sources[i].nominal = params_with_effects(here);
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
  parallel_for(static_cast<int>(sources.size()), [&](int i) {
    smooth_source(sources[static_cast<std::size_t>(i)], sigmas, settings.data.likelihood_rows);
  });
  return sources;
}

namespace {

/// The channels that at least one recording holds, with their standard deviations.
std::vector<Observed> observed_channels(const Problem& problem,
                                        const std::vector<NoiseLevel>& noise, bool secondary) {
  std::vector<Observed> out;
  for (std::size_t j = 0; j < problem.joints.size(); ++j) {
    for (Signal signal : {Signal::q, Signal::dq, Signal::tau, Signal::i, Signal::pwm}) {
      if (signal != Signal::q && !secondary) continue;
      const Actuator actuator = problem.sources.front().nominal.joints[j].nominal.actuator;
      if ((signal == Signal::i || signal == Signal::pwm) && actuator != Actuator::dc_servo)
        continue;
      if (signal == Signal::tau && actuator == Actuator::passive) continue;
      std::vector<double> values;
      for (const Source& s : problem.sources) {
        const std::vector<double>& c = column(s.drive.joints[j], signal);
        values.insert(values.end(), c.begin(), c.end());
      }
      if (finite_values(values).empty()) continue;
      Observed channel;
      channel.signal = signal;
      channel.joint = static_cast<int>(j);
      const NoiseLevel level =
          level_of(noise, std::string(to_string(signal)) + ":" + problem.joints[j]);
      const double sigma = level.sigma;
      channel.quantum = level.quantum;
      const double floor = signal == Signal::q
                               ? problem.settings.data.model_floor *
                                     (quantile(values, 0.99) - quantile(values, 0.01))
                               : problem.settings.data.secondary_floor * rms(values);
      channel.noise = std::max(sigma, 1e-12);
      channel.sigma = channel.floor = std::max({sigma, floor, 1e-9});
      out.push_back(channel);
    }
  }
  return out;
}

void add_shots(Problem& problem, int source_index, double seconds) {
  const Source& source = problem.sources[static_cast<std::size_t>(source_index)];
  const std::vector<double>& t = source.drive.t;
  const auto compared = static_cast<std::size_t>(problem.settings.data.compared_rows);
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
    for (std::size_t j = 0; j < problem.joints.size(); ++j) {
      shot.window.q.push_back(source.motion.q[j][first]);
      shot.window.dq.push_back(source.motion.dq[j][first]);
    }
    shot.stride = static_cast<int>(std::max<std::size_t>(1, (last - first) / compared));
    // row `first` itself is the start, not a prediction
    shot.rows = (last - first) / static_cast<std::size_t>(shot.stride);
    problem.shots.push_back(std::move(shot));
    first = last;
  }
}

/// Keeps an even choice of shots when there are more than the budget allows, and those at the
/// instants.
void thin_shots(Problem& problem, int maximum_rows, int maximum_shots) {
  std::size_t total = 0;
  for (const Shot& s : problem.shots) total += s.rows * problem.joints.size();
  const auto share = [](int allowed, std::size_t there) {
    return static_cast<double>(allowed) / static_cast<double>(std::max<std::size_t>(there, 1));
  };
  problem.used_share =
      std::min({1.0, share(maximum_rows, total), share(maximum_shots, problem.shots.size())});
  if (problem.used_share >= 1.0) return;
  std::vector<Shot> kept;
  double credit = 0.5;
  for (Shot& s : problem.shots) {
    credit += problem.used_share;
    const bool chosen = credit >= 1.0;
    if (chosen) credit -= 1.0;
    const bool wanted = std::any_of(problem.instants.begin(), problem.instants.end(),
                                    [&](double t) { return near_instant(problem, s, t); });
    if (chosen || wanted) kept.push_back(std::move(s));
  }
  problem.shots = std::move(kept);
}

/// Held-out groups: whole recordings when there are at least three, else contiguous blocks of each
/// recording.
void assign_groups(Problem& problem) {
  std::map<std::string, int> conditions;
  std::map<int, std::pair<int, int>> seen;  // source -> (number of shots, shots so far)
  for (const Shot& s : problem.shots) ++seen[s.source].first;
  const int sources = static_cast<int>(problem.sources.size());
  const int blocks = sources >= 3 ? 1 : problem.settings.decisions.folds / sources;
  for (Shot& s : problem.shots) {
    auto& [total, index] = seen[s.source];
    s.group = sources >= 3 ? s.source % 5 : s.source * blocks + index * blocks / total;
    ++index;
    const auto place =
        conditions.emplace(problem.sources[static_cast<std::size_t>(s.source)].condition,
                           static_cast<int>(conditions.size()));
    s.condition = place.first->second;
    problem.groups = std::max(problem.groups, s.group + 1);
  }
  problem.conditions = static_cast<int>(conditions.size());
}

}  // namespace

Problem make_problem(std::vector<Source> sources, const std::vector<NoiseLevel>& noise,
                     const ProblemOptions& options, const Settings& settings) {
  Problem problem;
  problem.settings = settings;
  problem.sources = std::move(sources);
  for (const TreeJoint& joint : problem.sources.front().nominal.tree.joints)
    problem.joints.push_back(joint.name);
  problem.channels = observed_channels(problem, noise, options.secondary);
  problem.instants = options.instants;
  problem.struck = options.struck;
  for (std::size_t i = 0; i < problem.sources.size(); ++i)
    add_shots(problem, static_cast<int>(i), options.shot_seconds);
  thin_shots(problem, options.maximum_rows, options.maximum_shots);
  for (Shot& s : problem.shots) {
    s.offset = problem.size;
    problem.size += s.rows * problem.channels.size();
  }
  assign_groups(problem);
  return problem;
}

bool near_instant(const Problem& problem, const Shot& shot, double t) {
  const std::vector<double>& clock = problem.sources[static_cast<std::size_t>(shot.source)].drive.t;
  const double from = clock[shot.window.first], length = clock[shot.window.last] - from;
  return std::abs(t - from) < 1.5 * length;
}

namespace {

/// The speed that says how well a reading is known comes from the motion that the readings say: a
/// few rounds settle it.
void resmooth_joint(Source& source, std::size_t joint, double noise, double jitter,
                    const DataSettings& settings) {
  const std::vector<double>& q = source.drive.joints[joint].q;
  for (int round = 0; round < settings.smoothing_rounds; ++round) {
    std::vector<double> sigma;
    for (const double speed : source.motion.dq[joint])
      sigma.push_back(std::hypot(noise, jitter * speed));
    SmoothedState state = smooth_position(source.drive.t, q, sigma, settings.likelihood_rows);
    source.motion.q[joint] = std::move(state.q);
    source.motion.dq[joint] = std::move(state.dq);
    source.q_sigma[joint] = std::move(state.q_sigma);
    source.dq_sigma[joint] = std::move(state.dq_sigma);
  }
}

}  // namespace

void resmooth(Problem& problem, const std::vector<double>& jitter) {
  for (const Observed& channel : problem.channels) {
    const auto joint = static_cast<std::size_t>(channel.joint);
    if (channel.signal != Signal::q || !(jitter[joint] > 0.0)) continue;
    parallel_for(static_cast<int>(problem.sources.size()), [&](int i) {
      Source& source = problem.sources[static_cast<std::size_t>(i)];
      if (!source.drive.joints[joint].q.empty())
        resmooth_joint(source, joint, channel.noise, jitter[joint], problem.settings.data);
    });
    for (Shot& shot : problem.shots) {
      const MeasuredMotion& motion = problem.sources[static_cast<std::size_t>(shot.source)].motion;
      shot.window.q[joint] = motion.q[joint][shot.window.first];
      shot.window.dq[joint] = motion.dq[joint][shot.window.first];
    }
  }
}

double longest_recording(const Problem& problem) {
  double longest = 0.0;
  for (const Source& s : problem.sources)
    longest = std::max(longest, s.drive.t.back() - s.drive.t.front());
  return longest;
}

double rows_of_a_joint(const Problem& problem) {
  double rows = 0.0;
  for (const Shot& shot : problem.shots) rows += static_cast<double>(shot.rows);
  return rows;
}

void whitened_residual(const Problem& problem, const Shot& shot, const Prediction& p,
                       const std::vector<char>& wanted, double* out) {
  const Source& source = problem.sources[static_cast<std::size_t>(shot.source)];
  for (std::size_t c = 0; c < problem.channels.size(); ++c) {
    const Observed& channel = problem.channels[c];
    if (!wanted.empty() && wanted[static_cast<std::size_t>(channel.joint)] == 0) continue;
    const std::vector<double>& all = channel.signal == Signal::q     ? p.q
                                     : channel.signal == Signal::dq  ? p.dq
                                     : channel.signal == Signal::tau ? p.tau
                                     : channel.signal == Signal::i   ? p.i
                                                                     : p.pwm;
    const auto predicted = p.of(all, channel.joint);
    for (std::size_t k = 0; k < shot.rows; ++k) {
      const std::size_t local = (k + 1) * static_cast<std::size_t>(shot.stride);
      double difference = measured(source, channel, shot.window.first + local) - predicted[local];
      if (!problem.step_error.empty())
        difference += problem.step_error[shot.offset + c * shot.rows + k];
      out[c * shot.rows + k] = std::isfinite(difference) ? difference / channel.sigma : 0.0;
    }
  }
}

}  // namespace sanso::diagnose
