// Lengths, seconds and gravity make the same fall, and each another speed of a hit.
#include "tools/diagnose/wholebody/choices.h"

#include <cmath>

namespace sanso::diagnose {
namespace {

/// Recorded seconds over true ones.
void correct_clock(std::vector<WholeRecording>& recordings, double clock) {
  for (WholeRecording& r : recordings) {
    r.interval /= clock;
    for (double& t : r.t) t /= clock;
    for (V3& v : r.v) v *= clock;
    for (V3& w : r.w) w *= clock;
  }
}

Choice same(const Asking& asking, std::string name) {
  return {std::move(name), asking.body, asking.recordings, asking.known, asking.settings};
}

Choice with_scale(const Asking& asking, std::string name, double scale) {
  Choice out = same(asking, std::move(name));
  out.known.pose_scale = scale;
  return out;
}

}  // namespace

std::vector<Choice> other_choices(const Asking& asking, const Known& before,
                                  const std::optional<Measured>& fall) {
  std::vector<Choice> out;
  if (!fall) return out;
  const bool taken = asking.known.pose_scale != before.pose_scale;
  const std::string scale = name_of(WholeFigure::pose_scale);
  out.push_back(with_scale(asking, taken ? scale + " left out" : scale,
                           taken ? before.pose_scale : fall->value));
  if (taken) {
    out.push_back(with_scale(asking, "the least " + scale, fall->low));
    out.push_back(with_scale(asking, "the largest " + scale, fall->high));
  }
  const double share = fall->value / before.pose_scale;
  // what falls share times as fast: seconds that are too long by its root, or a weaker gravity
  Choice clock = with_scale(asking, "clock_rate", before.pose_scale);
  correct_clock(clock.recordings, 1.0 / std::sqrt(share));
  out.push_back(std::move(clock));
  Choice gravity = with_scale(asking, "gravity", before.pose_scale);
  for (double& g : gravity.body.model.gravity) g *= share;
  out.push_back(std::move(gravity));
  for (const double factor : {0.5, 2.0}) {
    const char* word = factor < 1.0 ? "half" : "twice";
    Choice near = same(asking, std::string(word) + " the clearance");
    near.settings.clearance *= factor;
    out.push_back(std::move(near));
    Choice spread = same(asking, std::string(word) + " the impact's spread");
    spread.settings.impact_spread *= factor;
    out.push_back(std::move(spread));
  }
  return out;
}

}  // namespace sanso::diagnose
