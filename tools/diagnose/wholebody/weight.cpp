// Over a piece of time the feet push the centre of mass: their mean force is the mass times gravity
// and what its velocity gained. Which link the mass is in, and whether the sensors or the scales
// are wrong, a sum of vertical forces does not say.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tools/diagnose/compare/measured_motion.h"
#include "tools/diagnose/stats/smoother.h"
#include "tools/diagnose/torque/disagreement.h"
#include "tools/diagnose/wholebody/questions.h"

namespace sanso::diagnose {
namespace {

/// Vertical velocity of the centre of mass, m/s; zeros where no position was recorded.
std::vector<double> vertical_velocity(const Asking& asking, const WholeRecording& r) {
  std::vector<double> out(r.rows(), 0.0);
  if (!r.position || !r.attitude) return out;
  const V3 up = upwards(asking.body);
  BodyKinematics kinematics(asking.body);
  std::vector<double> height;
  for (std::size_t k = 0; k < r.rows(); ++k) {
    kinematics.set(r.R[k], r.p[k] / asking.known.pose_scale, r.q.col(static_cast<Eigen::Index>(k)));
    height.push_back(up.dot(kinematics.com()));
  }
  return smooth_position(r.t, height, position_noise(height), asking.smoother).dq;
}

struct Loads {
  Samples share;  // of the whole mass, missing
  std::map<std::string, Samples> by_recording;
};

void add_loads(const Asking& asking, std::size_t number, Loads& loads) {
  const WholeRecording& r = asking.recordings[number];
  if (r.feet.empty()) return;
  const std::vector<double> v = vertical_velocity(asking, r);
  const double gravity = eigen(asking.body.model.gravity).norm(), mass = asking.body.mass();
  for (std::size_t first = 0; first + 1 < r.rows();) {
    std::size_t last = first;
    double sum = 0.0;
    while (last + 1 < r.rows() && r.piece[last + 1] == r.piece[first] &&
           r.t[last + 1] - r.t[first] <= asking.settings.block) {
      double force = 0.0;
      for (const FootForce& foot : r.feet) force += 0.5 * (foot.fz[last] + foot.fz[last + 1]);
      sum += force * (r.t[last + 1] - r.t[last]);
      ++last;
    }
    const double seconds = r.t[last] - r.t[first];
    if (seconds > 0.5 * asking.settings.block && std::isfinite(sum)) {
      const double pushed = sum / seconds / asking.known.force_scale;
      const double share = pushed / (mass * (gravity + (v[last] - v[first]) / seconds)) - 1.0;
      const std::size_t group = asking.group_of(number, r.t[first] - r.t.front());
      loads.share.add(share, 1.0, group);
      loads.by_recording[r.name].add(
          share, 1.0, static_cast<std::size_t>((r.t[first] - r.t.front()) / asking.settings.block));
    }
    first = std::max(last, first + 1);
  }
}

void scaled_by(Samples& samples, double factor) {
  for (double& x : samples.value) x *= factor;
}

}  // namespace

Answered ask_weight(const Asking& asking) {
  Answered out;
  Loads loads;
  for (std::size_t r = 0; r < asking.recordings.size(); ++r) add_loads(asking, r, loads);
  // the link that floats takes all of it: which one has it cannot be told from a sum
  const double of_base = asking.body.mass() / std::max(asking.body.base.mass, 1e-9);
  std::vector<GroupValue> values;
  for (const auto& [name, samples] : loads.by_recording) {
    if (const auto m = measured(samples, 0.0, asking.chance())) {
      values.push_back({name, m->value, m->sigma});
      out.answers.notes.push_back(
          fmt::format("{}: the feet carry {:.2f} % more than the model weighs [{:.2f}, {:.2f}]",
                      name, 100 * m->value, 100 * m->low, 100 * m->high));
    }
  }
  const std::string apart =
      disagreement("weight on the feet, share", "-", values, asking.decisions);
  if (!apart.empty())
    out.answers.notes.push_back(apart), out.answers.disagreements.push_back(apart);
  scaled_by(loads.share, of_base);
  const auto m = measured(loads.share, 0.0, asking.chance());
  if (!m) {
    const char* why = "no forces of the feet (fz:<link>) over some seconds: nothing weighs it";
    for (const WholeFigure figure :
         {WholeFigure::mass_share, WholeFigure::payload, WholeFigure::force_scale})
      out.answers.cannot(figure, why);
    return out;
  }
  out.answers.notes.push_back(
      "a sum of vertical forces tells neither which link is heavier nor whether the sensors read "
      "too much; weighing the robot would");
  Asked asked = asked_for(WholeFigure::mass_share);
  asked.where = {asking.body.root}, asked.regime = "stance", asked.channel = kWeightBalance;
  asked.tolerance = asking.tolerances.mass * of_base;
  asked.equally_good = {name_of(WholeFigure::payload), name_of(WholeFigure::force_scale)};
  out.answers.take(answer_to(asked, *m, asking.chance()));
  if (out.answers.missing()) out.patch.mass_share = m->value;
  return out;
}

}  // namespace sanso::diagnose
