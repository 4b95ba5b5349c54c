// A foot that carries more sinks deeper. Soles are held against each other while both stand: nobody
// has to know where the base is, and floors that lean stay as they are.
//
//   height of one - height of other = what it is between two steps - give (force of one - of other)
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/diagnose/wholebody/questions.h"

namespace sanso::diagnose {
namespace {

/// Middle of what may touch of a foot, above the base's origin.
double height_of(const std::vector<TouchPoint>& points, const BodyKinematics& kinematics,
                 const V3& up, const FootForce& foot) {
  double sum = 0.0, count = 0.0;
  for (const TouchPoint& p : points)
    if (p.joint == foot.joint && p.link == foot.link)
      sum += up.dot(kinematics.at(p.joint, p.at)), count += 1.0;
  return sum / std::max(count, 1.0);
}

/// Two feet over a piece of time, sums about the means.
struct Pair {
  double n = 0.0, f = 0.0, h = 0.0, ff = 0.0, fh = 0.0;
  void add(double force, double height) {
    n += 1.0, f += force, h += height, ff += force * force, fh += force * height;
  }
  double squares() const { return n > 0.0 ? ff - f * f / n : 0.0; }
  double give() const { return -(fh - f * h / n) / squares(); }
};

/// Both feet carry a good part in every row that is taken; a step begins a piece of its own.
void add_pair(const Asking& asking, std::size_t number, const FootForce& one,
              const FootForce& other, Samples& out) {
  const WholeRecording& r = asking.recordings[number];
  const std::vector<TouchPoint> points = touch_points(asking.body);
  const double weight = asking.body.mass() * eigen(asking.body.model.gravity).norm();
  const V3 up = upwards(asking.body);
  const auto stands = [&](const FootForce& foot, std::size_t k) {
    return foot.fz[k] > asking.settings.stance_share * weight;
  };
  std::vector<char> both(r.rows(), 0);
  for (std::size_t k = 0; k < r.rows(); ++k) both[k] = stands(one, k) && stands(other, k) ? 1 : 0;
  BodyKinematics kinematics(asking.body);
  for (const Span& s : spans(r, both)) {
    for (std::size_t first = s.first; first < s.last;) {
      Pair sums;
      std::size_t k = first;
      for (; k < s.last && r.t[k] - r.t[first] <= asking.settings.block; ++k) {
        kinematics.set(r.R[k], V3::Zero(), r.q.col(static_cast<Eigen::Index>(k)));
        sums.add((one.fz[k] - other.fz[k]) / asking.known.force_scale,
                 height_of(points, kinematics, up, one) - height_of(points, kinematics, up, other));
      }
      // between two steps a foot rolls over its edges
      const bool stood = r.t[k - 1] - r.t[first] > 0.5 * asking.settings.block;
      if (stood && sums.squares() > 0.0)
        out.add(sums.give(), sums.squares(), asking.group_of(number, r.t[first] - r.t.front()));
      first = k;
    }
  }
}

/// What a sole gives a newton, as the library has it: logarithm of stiffness over the stated one.
void as_stiffness(double nominal, Finding& f) {
  const EffectParameter& p = effect_of(WholeFigure::compliance).parameters.front();
  const VerdictParameter give = f.parameters.begin()->second;
  const auto log_of = [&](double x) {
    return x > 0.0 ? std::clamp(std::log(nominal / x), p.low, p.high) : p.high;
  };
  f.parameters = {{std::string(p.name),
                   {log_of(give.value), log_of(give.high), log_of(give.low), std::string(p.unit),
                    give.low <= 0.0}}};
}

}  // namespace

Answered ask_sinking(const Asking& asking) {
  Answered out;
  Samples gives;  // m/N
  std::string link = asking.body.root;
  for (std::size_t i = 0; i < asking.recordings.size(); ++i) {
    const WholeRecording& r = asking.recordings[i];
    for (std::size_t f = 1; r.attitude && f < r.feet.size(); ++f)
      add_pair(asking, i, r.feet[f - 1], r.feet[f], gives), link = r.feet[f].link;
  }
  const ContactMaterial material = asking.body.material_of(link);
  Asked asked = asked_for(WholeFigure::compliance);
  asked.parameter = "give", asked.unit = "m/N", asked.channel = "sinking";
  asked.nominal = material.stiffness ? 1.0 / *material.stiffness : 0.0;
  const double weight = asking.body.mass() * eigen(asking.body.model.gravity).norm();
  asked.tolerance = asking.settings.sinking / weight;
  // a leg that bends where no encoder sees it gives as a sole does
  for (const std::string_view id : effect_of(WholeFigure::compliance).confounders)
    if (find_effect(std::string(id))->whole == WholeFigure::none)
      asked.equally_good.emplace_back(id);
  const auto m = measured(gives, asked.nominal, asking.chance());
  if (!m) {
    out.answers.cannot(WholeFigure::compliance,
                       "no forces (fz:<link>) of two feet that stand for some seconds, with an "
                       "attitude: nothing says how deep a sole sinks");
    return out;
  }
  const double least = asked.nominal + asked.tolerance + asking.chance().deviations() * m->sigma;
  const std::string bound = fmt::format(
      "soles give by {:.2g} m/N [{:.2g}, {:.2g}]; softer than {:.2g} N/m would have been seen",
      m->value, m->low, m->high, 1.0 / least);
  if (material.stiffness) {
    out.answers.take(answer_to(asked, *m, asking.chance()));
    if (out.answers.missing()) as_stiffness(asked.nominal, out.answers.findings.back());
    return out;
  }
  ++out.answers.asked;
  out.answers.log.push_back(bound);
  if (m->value > least)
    out.answers.notes.push_back("the stiffness of the contact is not stated by the model: " +
                                bound);
  else
    out.answers.cannot(WholeFigure::compliance, bound);
  return out;
}

}  // namespace sanso::diagnose
