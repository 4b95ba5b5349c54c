// Turns an episode into the samples that the measures read: the true pose where the robot's
// world tells it, the estimate otherwise.
#include "host/app/motion_judge.h"

#include "host/motion/make/body_kinematics.h"

namespace sanso::app {
namespace {

motion::EpisodeSample sample_at(const model::State& x, const learn::TrueSample* truth) {
  motion::EpisodeSample sample;
  sample.x = x;
  const motion::BodyPoints points = motion::body_points(x);
  for (int side = 0; side < 2; ++side) {
    const auto s = static_cast<std::size_t>(side);
    sample.foot_clearance_m[s] = points.sole_height(side);
    sample.foot_m[s] = points.p_world_foot[s].head<2>();
    if (!truth) continue;
    sample.foot_load_N[s] = static_cast<double>(truth->foot_load_N[s]);
    // the floor may lean, and a foot may stand on a plate
    sample.foot_clearance_m[s] = static_cast<double>(truth->foot_clearance_m[s]);
  }
  return sample;
}

}  // namespace

motion::MotionEpisode seen_from_outside(const learn::Episode& episode) {
  motion::MotionEpisode out;
  out.cost = episode.cost;
  out.completed = !episode.failed();
  const bool known = episode.truth.size() == episode.ticks.size();
  for (std::size_t i = 0; i < episode.ticks.size(); ++i) {
    const learn::TrueSample* truth = known ? &episode.truth[i] : nullptr;
    const motion::EpisodeSample sample = sample_at(truth ? truth->x : episode.ticks[i].x, truth);
    const auto tick = static_cast<std::size_t>(episode.ticks[i].trial_tick);
    // a lost observation repeats its successor
    while (out.samples.size() <= tick) out.samples.push_back(sample);
  }
  return out;
}

std::vector<std::string> broken_clauses(const motion::Motion& motion,
                                        const learn::Episode& episode) {
  return motion::evaluate(motion, seen_from_outside(episode)).failures();
}

}  // namespace sanso::app
