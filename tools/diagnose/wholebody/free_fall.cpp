// Between contacts the centre of mass falls, whatever the robot weighs: its acceleration in the
// recorded lengths and seconds is gravity times the scale of the lengths. A clock that runs fast
// and another gravity look the same; where the base rests on a ground of known height only the
// lengths show.
#include <fmt/format.h>

#include <Eigen/Dense>
#include <cmath>

#include "tools/diagnose/stats/significance.h"
#include "tools/diagnose/wholebody/questions.h"

namespace sanso::diagnose {
namespace {

/// Acceleration of the centre of mass in recorded lengths by least squares, m/s^2.
V3 acceleration_of(const Asking& asking, const WholeRecording& r, const Span& s) {
  BodyKinematics kinematics(asking.body);
  const auto n = static_cast<Eigen::Index>(s.rows());
  const double middle = 0.5 * (r.t[s.first] + r.t[s.last - 1]);
  Eigen::MatrixXd A(n, 3), b(n, 3);
  for (Eigen::Index i = 0; i < n; ++i) {
    const std::size_t k = s.first + static_cast<std::size_t>(i);
    kinematics.set(r.R[k], r.p[k], r.q.col(static_cast<Eigen::Index>(k)));
    const double t = r.t[k] - middle;
    A.row(i) << 1.0, t, 0.5 * t * t;
    b.row(i) = kinematics.com().transpose();
  }
  const Eigen::MatrixXd fit = A.colPivHouseholderQr().solve(b);
  return fit.row(2).transpose();
}

/// Scale of lengths that each flight shows.
Samples from_flights(const Asking& asking, const Clearance& c, std::size_t r, Samples samples) {
  const WholeRecording& recording = asking.recordings[r];
  const V3 up = upwards(asking.body);
  const double gravity = eigen(asking.body.model.gravity).norm();
  for (const Span& s : flights(recording, c, asking.settings)) {
    const double seconds = recording.t[s.last - 1] - recording.t[s.first];
    const V3 a = acceleration_of(asking, recording, s);
    // a robot in somebody's hands, or on a stand, touches nothing either
    if ((a + gravity * up).norm() > asking.settings.falls * gravity) continue;
    // variance of the second derivative: noise^2 720 / (n T^4)
    samples.add(-up.dot(a) / gravity, std::pow(seconds, 4) * static_cast<double>(s.rows()),
                asking.group_of(r, recording.t[s.first] - recording.t.front()));
  }
  return samples;
}

/// The base's height over its lowest point, recorded over by shape, wherever it rests.
Samples from_rests(const Asking& asking, const Clearance& c, std::size_t r, Samples samples) {
  if (!c.stated) return samples;
  const WholeRecording& recording = asking.recordings[r];
  const V3 up = upwards(asking.body);
  std::vector<char> rests(recording.rows(), 0);
  for (std::size_t k = 0; k < recording.rows(); ++k)
    rests[k] = recording.v[k].norm() < asking.settings.rest_speed &&
               recording.w[k].norm() < asking.settings.rest_turning;
  for (const Span& s : spans(recording, rests)) {
    if (recording.t[s.last - 1] - recording.t[s.first] < asking.settings.rest_time) continue;
    for (std::size_t k = s.first; k < s.last; ++k) {
      const double height = up.dot(recording.p[k]) - c.ground;
      const double shape = height - c.lowest[k];
      if (shape > 0.0)
        samples.add(height / shape, 1.0, asking.group_of(r, recording.t[k] - recording.t.front()));
    }
  }
  return samples;
}

/// One number of two measurements.
Measured joined(const Measured& a, const Measured& b) {
  const double wa = 1.0 / std::max(a.sigma * a.sigma, 1e-18),
               wb = 1.0 / std::max(b.sigma * b.sigma, 1e-18);
  Measured out = a;
  // what the two differ by is known no better than their difference
  out.sigma = std::max(std::sqrt(1.0 / (wa + wb)), 0.5 * std::abs(a.value - b.value));
  out.value = (wa * a.value + wb * b.value) / (wa + wb);
  out.low = out.value - kNormal95 * out.sigma, out.high = out.value + kNormal95 * out.sigma;
  return out;
}

}  // namespace

bool falls(const Asking& asking, const WholeRecording& r, const Span& flight) {
  const double gravity = eigen(asking.body.model.gravity).norm();
  const V3 a = acceleration_of(asking, r, flight) / asking.known.pose_scale;
  return (a + gravity * upwards(asking.body)).norm() <= asking.settings.falls * gravity;
}

Answered ask_free_fall(const Asking& asking) {
  Answered out;
  Samples fall, rest;
  for (std::size_t r = 0; r < asking.recordings.size(); ++r) {
    const WholeRecording& recording = asking.recordings[r];
    if (!recording.position || !recording.attitude || asking.body.shapes.empty()) continue;
    const Clearance c = clearance(recording, asking.body, 1.0, asking.settings);
    fall = from_flights(asking, c, r, std::move(fall));
    rest = from_rests(asking, c, r, std::move(rest));
  }
  const auto fallen = measured(fall, asking.known.pose_scale, asking.chance());
  const auto rested = measured(rest, asking.known.pose_scale, asking.chance());
  if (!fallen) {
    out.answers.cannot(WholeFigure::pose_scale,
                       "too few flights without contact: nothing falls freely");
    return out;
  }
  Asked asked = asked_for(WholeFigure::pose_scale);
  asked.where = {asking.body.root}, asked.channel = "fall";
  asked.nominal = asking.known.pose_scale, asked.tolerance = asking.settings.scale;
  bool of_lengths = true;
  Measured m = *fallen;
  if (!rested) {
    asked.equally_good = {"clock_rate", "gravity"};
    out.answers.notes.push_back(
        "a clock that runs fast and another gravity fall alike: [ground] height in model.toml, and "
        "recordings that end at rest, would tell them from the scale of the positions");
  } else {
    const double apart = std::abs(fallen->value - rested->value);
    const double chance = asking.chance().deviations() * std::hypot(fallen->sigma, rested->sigma) +
                          asking.settings.scale;
    out.answers.notes.push_back(fmt::format(
        "scale of the positions: falling {:.4f} [{:.4f}, {:.4f}], resting {:.4f} "
        "[{:.4f}, {:.4f}]",
        fallen->value, fallen->low, fallen->high, rested->value, rested->low, rested->high));
    if (apart < chance) {
      m = joined(*fallen, *rested);
    } else {
      of_lengths = false;
      asked.effect = "gravity", asked.equally_good = {"clock_rate"};
    }
  }
  out.answers.take(answer_to(asked, m, asking.chance()));
  if (out.answers.missing() && of_lengths) out.patch.pose_scale = m.value;
  return out;
}

}  // namespace sanso::diagnose
