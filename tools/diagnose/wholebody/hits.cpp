// A hit: the track before it leads to the instant of the lowest point; what the velocities are as
// soon as the tracker is over it, less that, is the impulse, and the velocity of the corner that
// hit comes from the turning. A corner that stays on the ground counts: it did not rebound.
// Slipping corners show the friction coefficient, sticking ones bound it.
#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>

#include "tools/diagnose/wholebody/questions.h"

namespace sanso::diagnose {
namespace {

struct Hits {
  Samples restitution, friction;
  double largest_ratio = 0.0;  // of impulses along and across the ground, sticking ones too
};

/// State at an instant that the rows of a flight lead to.
struct Reached {
  V3 v, w;  // of the base's origin, world axes
};

/// Before the hit nothing touches: base position less fall is a straight line.
Reached before_hit(const Asking& asking, const WholeRecording& r, const Span& flight,
                   double instant, const V3& gravity) {
  const double scale = asking.known.pose_scale;
  const auto rows = static_cast<std::size_t>(asking.settings.before_hit_rows);
  double n = 0.0, sum_s = 0.0, sum_ss = 0.0;
  V3 sum_x = V3::Zero(), sum_sx = V3::Zero(), w = V3::Zero();
  for (std::size_t k = flight.last - std::min(flight.rows(), rows); k < flight.last; ++k) {
    const double s = r.t[k] - instant;
    const V3 x = r.p[k] / scale - 0.5 * s * s * gravity;
    n += 1.0, sum_s += s, sum_ss += s * s, sum_x += x, sum_sx += s * x;
    w += r.R[k] * r.w[k];
  }
  return {(n * sum_sx - sum_s * sum_x) / (n * sum_ss - sum_s * sum_s), w / n};
}

/// Rows after the hit, as soon as the tracker is over it; what flies again has fallen since.
struct After {
  Reached state;
  bool alone = true;  // no other corner came down meanwhile
};
std::optional<After> after_hit(const Asking& asking, const WholeRecording& r, const Clearance& c,
                               std::size_t hit, const V3& gravity) {
  const auto rows = static_cast<std::size_t>(asking.settings.after_hit_rows);
  const auto spread =
      static_cast<std::size_t>(std::ceil(asking.settings.impact_spread / r.interval));
  const std::size_t first = hit + std::max<std::size_t>(spread, 1), last = first + rows;
  if (last > r.rows() || r.piece[last - 1] != r.piece[hit]) return std::nullopt;
  After out;
  V3 v = V3::Zero(), w = V3::Zero();
  for (std::size_t k = first; k < last; ++k) {
    const bool flies = c.lowest[k] > asking.settings.left_ground * asking.settings.clearance;
    v += r.v[k] / asking.known.pose_scale;
    if (flies) v -= (r.t[k] - r.t[hit]) * gravity;
    w += r.R[k] * r.w[k];
    const bool other = c.point[k] == c.point[hit] ? c.second[k] < asking.settings.clearance
                                                  : c.lowest[k] < asking.settings.clearance;
    out.alone = out.alone && !other;
  }
  out.state = {v / static_cast<double>(rows), w / static_cast<double>(rows)};
  return out;
}

void add_hit(const Asking& asking, std::size_t number, const Clearance& c, const Span& flight,
             std::size_t k, Hits& hits) {
  const WholeRecording& r = asking.recordings[number];
  // two corners at once share the impulse nobody knows how
  if (c.second[k] - c.lowest[k] < asking.settings.one_corner * asking.settings.clearance) return;
  const V3 up = upwards(asking.body), gravity = eigen(asking.body.model.gravity);
  const Reached a = before_hit(asking, r, flight, r.t[k], gravity);
  const auto after = after_hit(asking, r, c, k, gravity);
  if (!after || !after->alone) return;
  const Reached& b = after->state;
  const TouchPoint point = touch_points(asking.body)[static_cast<std::size_t>(c.point[k])];
  const V3 arm = r.R[k] * point.at - point.radius * up, com = r.R[k] * eigen(asking.body.base.com);
  const V3 va = a.v + a.w.cross(arm), vb = b.v + b.w.cross(arm);
  const double into = -up.dot(va);
  if (into < asking.settings.hit_speed) return;
  const std::size_t group = asking.group_of(number, r.t[k] - r.t.front());
  hits.restitution.add(up.dot(vb) / into, into * into, group);
  const V3 impulse = b.v + b.w.cross(com) - a.v - a.w.cross(com);  // over the mass
  const double across = up.dot(impulse);
  const V3 along = impulse - across * up, slip_a = va + into * up, slip_b = vb - up.dot(vb) * up;
  if (across < asking.settings.hit_speed) return;
  const double ratio = along.norm() / across;
  const bool slips =
      slip_b.norm() > asking.settings.slip_speed && slip_a.dot(slip_b) > 0.0 &&
      along.dot(slip_b) < -std::cos(asking.settings.opposes) * along.norm() * slip_b.norm();
  if (slips)
    hits.friction.add(ratio, across, group);
  else
    hits.largest_ratio = std::max(hits.largest_ratio, ratio);
}

/// Slides that do not tumble: what slows them down.
void add_slides(const Asking& asking, std::size_t number, const Clearance& c, Hits& hits) {
  const WholeRecording& r = asking.recordings[number];
  const V3 up = upwards(asking.body);
  const double gravity = eigen(asking.body.model.gravity).norm();
  const auto speed = [&](std::size_t k) { return (r.v[k] - up.dot(r.v[k]) * up).norm(); };
  std::vector<char> slides(r.rows(), 0);
  for (std::size_t k = 0; k < r.rows(); ++k)
    slides[k] = c.lowest[k] < asking.settings.clearance && speed(k) > asking.settings.slip_speed &&
                r.w[k].norm() < 2.0 * asking.settings.rest_turning &&
                std::abs(up.dot(r.v[k])) < asking.settings.rest_speed;
  for (const Span& s : spans(r, slides)) {
    const double seconds = r.t[s.last - 1] - r.t[s.first];
    if (s.rows() < 5) continue;
    const double slower = (speed(s.first) - speed(s.last - 1)) / seconds / asking.known.pose_scale;
    hits.friction.add(slower / gravity, gravity * seconds,
                      asking.group_of(number, r.t[s.first] - r.t.front()));
  }
}

Hits find_hits(const Asking& asking) {
  Hits hits;
  for (std::size_t i = 0; i < asking.recordings.size(); ++i) {
    const WholeRecording& r = asking.recordings[i];
    if (!r.position || !r.attitude) continue;
    const Clearance c = clearance(r, asking.body, asking.known.pose_scale, asking.settings);
    const auto spread =
        static_cast<std::size_t>(std::ceil(asking.settings.impact_spread / r.interval));
    bool thrown = false;
    for (const Span& up : flights(r, c, asking.settings)) {
      if (!falls(asking, r, up)) continue;
      thrown = true;
      // the lowest row soon after a flight's end
      const std::size_t first = up.last, last = std::min(r.rows(), first + 2 * spread + 2);
      if (first >= last || r.piece[last - 1] != r.piece[up.first]) continue;
      const auto begin = c.lowest.begin();
      const auto k =
          static_cast<std::size_t>(std::min_element(begin + static_cast<std::ptrdiff_t>(first),
                                                    begin + static_cast<std::ptrdiff_t>(last)) -
                                   begin);
      if (k + 1 < last && c.lowest[k] < asking.settings.clearance)
        add_hit(asking, i, c, up, k, hits);
    }
    if (thrown) add_slides(asking, i, c, hits);
  }
  return hits;
}

/// A number that nobody stated is estimated, and nothing is missing.
WholeAnswers unstated(const std::string& what, const Measured& m) {
  WholeAnswers out;
  out.asked = 1;
  out.notes.push_back(fmt::format("{} is not stated by the model: {:.3g} [{:.3g}, {:.3g}] here",
                                  what, m.value, m.low, m.high));
  return out;
}

Answered ask_rebound(const Asking& asking, const Hits& hits) {
  Answered out;
  Asked asked = asked_for(WholeFigure::restitution);
  asked.where = {asking.body.root}, asked.channel = "rebound";
  asked.nominal = asking.body.ground.restitution.value_or(0.0);
  asked.tolerance = asking.settings.restitution;
  // velocities on both sides of a hit are the same for a spring
  asked.equally_good = {name_of(WholeFigure::compliance)};
  const auto m = measured(hits.restitution, asked.nominal, asking.chance());
  if (!m) {
    out.answers.cannot(WholeFigure::restitution, "too few hits of a single corner after a flight");
    return out;
  }
  const bool stated = asking.body.ground.restitution.has_value();
  out.answers = stated ? answer_to(asked, *m, asking.chance()) : unstated(asked.effect, *m);
  if (!stated || out.answers.missing()) out.patch.restitution = std::clamp(m->value, 0.0, 1.0);
  return out;
}

Answered ask_slip(const Asking& asking, const Hits& hits) {
  Answered out;
  const ContactMaterial material = asking.body.material_of(asking.body.root);
  Asked asked = asked_for(WholeFigure::friction);
  asked.where = {asking.body.root}, asked.channel = "slip";
  asked.nominal = material.friction.value_or(0.0);
  asked.tolerance = asking.settings.friction * asked.nominal;
  const auto m = measured(hits.friction, asked.nominal, asking.chance());
  if (!m) {
    out.answers.cannot(WholeFigure::friction,
                       fmt::format("nothing slips often enough: the coefficient is {:.2g} at least",
                                   hits.largest_ratio));
    return out;
  }
  out.answers = material.friction ? answer_to(asked, *m, asking.chance())
                                  : unstated("the friction coefficient", *m);
  if (!material.friction || out.answers.missing()) out.patch.friction = std::max(0.0, m->value);
  return out;
}

}  // namespace

Answered ask_hits(const Asking& asking) {
  Answered out;
  if (asking.body.model.tree.size() > 0) {
    out.answers.cannot(WholeFigure::restitution,
                       "the impulse of a touchdown runs through moving joints");
    return out;
  }
  const Hits hits = find_hits(asking);
  out.take(ask_rebound(asking, hits));
  out.take(ask_slip(asking, hits));
  return out;
}

}  // namespace sanso::diagnose
