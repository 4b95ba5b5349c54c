// What changes the units or the motion of a problem, and errors told in them.
#include "tools/diagnose/compare/problem.h"

#include <algorithm>
#include <cmath>

#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/stats/smoother.h"

namespace sanso::diagnose {

Scales floors(const Comparison& comparison) {
  Scales out;
  for (const Observed& channel : comparison.channels) out.sigma.push_back(channel.floor);
  return out;
}

Scales overdispersed(const Problem& problem, const std::vector<double>& overdispersion) {
  Scales out = problem.scales;
  for (std::size_t c = 0; c < out.sigma.size(); ++c) {
    out.sigma[c] =
        std::max(problem->channels[c].floor, out.sigma[c] * std::sqrt(overdispersion[c]));
  }
  return out;
}

Eigen::VectorXd rescaled(const Comparison& comparison, Eigen::VectorXd r, const Scales& from,
                         const Scales& to) {
  for (const Shot& shot : comparison.shots) {
    for (std::size_t c = 0; c < comparison.channels.size(); ++c)
      rows_of(r, shot, c) *= from.sigma[c] / to.sigma[c];
  }
  return r;
}

namespace {

/// The speed that says how well a reading is known comes from the motion that the readings say: a
/// few rounds settle it.
void resmooth_joint(Source& source, std::size_t joint, double noise, double jitter,
                    const Settings& settings) {
  const std::vector<double>& q = source.drive.joints[joint].q;
  for (int round = 0; round < settings.data.smoothing_rounds; ++round) {
    std::vector<double> sigma;
    for (const double speed : source.motion.dq[joint])
      sigma.push_back(std::hypot(noise, jitter * speed));
    SmoothedState state =
        smooth_position(source.drive.t, q, sigma, settings.smoother, settings.data.likelihood_rows);
    source.motion.q[joint] = std::move(state.q);
    source.motion.dq[joint] = std::move(state.dq);
    source.q_sigma[joint] = std::move(state.q_sigma);
    source.dq_sigma[joint] = std::move(state.dq_sigma);
  }
}

}  // namespace

Problem resmoothed(const Problem& problem, const std::vector<double>& jitter) {
  Comparison out = *problem;
  for (const Observed& channel : out.channels) {
    const std::size_t joint = channel.joint;
    if (channel.signal != Signal::q || !(jitter[joint] > 0.0)) continue;
    parallel_for(out.sources.size(), [&](std::size_t i) {
      Source& source = out.sources[i];
      if (!source.drive.joints[joint].q.empty())
        resmooth_joint(source, joint, channel.noise, jitter[joint], out.settings);
    });
    for (Shot& shot : out.shots) {
      const MeasuredMotion& motion = out.sources[shot.source].motion;
      shot.window.q[joint] = motion.q[joint][shot.window.first];
      shot.window.dq[joint] = motion.dq[joint][shot.window.first];
    }
  }
  return {std::make_shared<const Comparison>(std::move(out)), problem.scales, problem.correction};
}

Problem with_shots(const Problem& problem, const std::vector<std::size_t>& shots,
                   double recalled_s) {
  Comparison out = *problem;
  out.recalled_s = std::min(out.recalled_s, recalled_s);
  const std::size_t channels = out.channels.size();
  out.shots.clear();
  out.size = 0;
  for (const std::size_t s : shots) {
    out.shots.push_back(problem->shots[s]);
    out.shots.back().offset = out.size;
    out.size += out.shots.back().rows * channels;
  }
  StepCorrection correction;
  if (problem.correction.error.size() > 0) {
    correction.error.resize(out.size);
    for (std::size_t i = 0; i < shots.size(); ++i) {
      rows_of(correction.error, out.shots[i], 0, channels) =
          rows_of(problem.correction.error, problem->shots[shots[i]], 0, channels);
    }
  }
  return {std::make_shared<const Comparison>(std::move(out)), problem.scales,
          std::move(correction)};
}

void whiten_residual(const Problem& problem, const Shot& shot, const Prediction& p,
                     const std::vector<char>& wanted, Eigen::VectorXd& r) {
  const Source& source = problem->sources[shot.source];
  const Eigen::VectorXd& correction = problem.correction.error;
  for (std::size_t c = 0; c < problem->channels.size(); ++c) {
    const Observed& channel = problem->channels[c];
    if (!wanted.empty() && wanted[channel.joint] == 0) continue;
    const std::vector<double>& all = channel.signal == Signal::q     ? p.q
                                     : channel.signal == Signal::dq  ? p.dq
                                     : channel.signal == Signal::tau ? p.tau
                                     : channel.signal == Signal::i   ? p.i
                                                                     : p.pwm;
    const auto predicted = p.of(all, channel.joint);
    auto out = rows_of(r, shot, c);
    const double sigma = problem.scales.sigma[c];
    const MeasuredColumn measured(source, channel);
    const double* added = correction.size() > 0 ? rows_of(correction, shot, c).data() : nullptr;
    for (std::size_t k = 0; k < shot.rows; ++k) {
      const std::size_t row = recorded_row(shot, k);
      double difference = measured.at(row) - predicted[row - shot.window.first];
      if (added != nullptr) difference += added[k];
      out[k] = std::isfinite(difference) ? difference / sigma : 0.0;
    }
  }
}

}  // namespace sanso::diagnose
