// Groups are resampled whole, because the values inside one are not independent.
#include "tools/diagnose/wholebody/answers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "tools/diagnose/stats/random.h"
#include "tools/diagnose/stats/robust.h"
#include "tools/diagnose/stats/significance.h"

namespace sanso::diagnose {
namespace {

/// Sums of a group: weight, weight x value.
struct Sum {
  double w = 0.0, wx = 0.0;
};

std::vector<Sum> sums_of(const Samples& s) {
  std::vector<Sum> out(s.groups());
  for (std::size_t i = 0; i < s.value.size(); ++i) {
    Sum& sum = out[s.group[i]];
    sum.w += s.weight[i], sum.wx += s.weight[i] * s.value[i];
  }
  return out;
}

double mean_of(const std::vector<Sum>& sums, const auto& take) {
  Sum all;
  for (std::size_t g = 0; g < sums.size(); ++g) {
    if (take(g)) all.w += sums[g].w, all.wx += sums[g].wx;
  }
  return all.w > 0.0 ? all.wx / all.w : 0.0;
}

/// Means of resampled groups, in order of size.
std::vector<double> resampled(const std::vector<Sum>& sums, const Chance& chance) {
  Random random(chance.seed, 17);
  std::vector<double> out;
  for (int d = 0; d < chance.whole.draws; ++d) {
    Sum all;
    for (std::size_t k = 0; k < sums.size(); ++k) {
      const Sum& s = sums[random.below(sums.size())];
      all.w += s.w, all.wx += s.wx;
    }
    if (all.w > 0.0) out.push_back(all.wx / all.w);
  }
  std::sort(out.begin(), out.end());
  return out;
}

/// The last of the parts judges.
bool held_out(std::size_t group, const WholeSettings& whole) {
  const auto parts = whole.parts_of_groups();
  return group % parts == parts - 1;
}

/// What a fit to the other groups does on the held-out ones; of Measured, which says what it is.
struct Proof {
  double before = 0.0, after = 0.0, gain = 0.0, gain_low = 0.0;
};

/// Mean of the nominal's squared error less the fitted value's, by held-out group, and the RMS.
Proof prove(const Samples& s, const std::vector<Sum>& sums, double nominal, const Chance& chance) {
  const double fitted = mean_of(sums, [&](std::size_t g) { return !held_out(g, chance.whole); });
  std::vector<double> before(sums.size(), 0.0), after(sums.size(), 0.0);
  double weight = 0.0, b = 0.0, a = 0.0;
  for (std::size_t i = 0; i < s.value.size(); ++i) {
    const std::size_t g = s.group[i];
    if (!held_out(g, chance.whole)) continue;
    const double x = s.value[i], w = s.weight[i];
    before[g] += w * (x - nominal) * (x - nominal), after[g] += w * (x - fitted) * (x - fitted);
    weight += w;
  }
  std::vector<double> removed;
  for (std::size_t g = 0; g < sums.size(); ++g) {
    if (!held_out(g, chance.whole)) continue;
    b += before[g], a += after[g];
    removed.push_back(before[g] - after[g]);
  }
  if (weight <= 0.0 || b <= 0.0) return {};
  const double low = moving_block_lower_bound(removed, chance.decisions.gain_level,
                                              chance.decisions.gain_draws, Random(chance.seed, 18));
  return {std::sqrt(b / weight), std::sqrt(a / weight), 1.0 - a / b, low / b};
}

/// What keeps a number that is no chance from being a finding.
std::string why_unnamed(const Asked& a, const Measured& m, double off, double surely) {
  if (off <= a.tolerance)
    return fmt::format(": within what a nominal model may be wrong by ({:.3g})", a.tolerance);
  if (off <= a.tolerance + surely)
    return fmt::format(
        ": further off than a nominal model may be ({:.3g}), and not surely: {:.3g} would be",
        a.tolerance, a.tolerance + surely);
  return fmt::format(
      ": described, not named: its gain on held-out data is not beyond chance ({:.3g})",
      m.gain_low);
}

}  // namespace

std::string number_of(const std::string& effect, const std::string& parameter,
                      const std::vector<std::string>& where) {
  return effect + "." + parameter + (where.empty() ? "" : " at " + where.front());
}

std::size_t Samples::groups() const {
  return group.empty() ? 0 : *std::max_element(group.begin(), group.end()) + 1;
}

double Chance::deviations() const { return normal_score(decisions.family_wise / whole.questions); }

double Chance::family_wise(double deviations) const {
  return std::min(1.0, whole.questions * normal_tail(deviations));
}

std::optional<Measured> measured(const Samples& samples, double nominal, const Chance& chance) {
  std::vector<Sum> sums;
  Samples packed;  // groups numbered without holes
  std::vector<std::optional<std::size_t>> number(samples.groups());
  std::size_t next = 0;
  for (std::size_t i = 0; i < samples.value.size(); ++i) {
    std::optional<std::size_t>& n = number[samples.group[i]];
    if (!n) n = next++;
    packed.add(samples.value[i], samples.weight[i], *n);
  }
  if (next < static_cast<std::size_t>(chance.whole.least_groups)) return std::nullopt;
  sums = sums_of(packed);
  Measured m;
  m.groups = next;
  m.value = mean_of(sums, [](std::size_t) { return true; });
  const std::vector<double> draws = resampled(sums, chance);
  // few groups spread too little by sqrt((n - 1) / n)
  const double widen = std::sqrt(static_cast<double>(next) / static_cast<double>(next - 1));
  m.low = m.value - widen * (m.value - quantile(draws, 0.025));
  m.high = m.value + widen * (quantile(draws, 0.975) - m.value);
  m.sigma = widen * standard_deviation(draws);
  std::vector<double> around;
  for (double x : packed.value) around.push_back(x);
  m.noise = robust_sigma(around);
  const Proof proof = prove(packed, sums, nominal, chance);
  m.before = proof.before, m.after = proof.after;
  m.gain = proof.gain, m.gain_low = proof.gain_low;
  return m;
}

Asked asked_for(WholeFigure figure) {
  const Effect& effect = effect_of(figure);
  const EffectParameter& number = effect.parameters.front();
  Asked out;
  out.effect = effect.id, out.family = to_string(effect.family);
  out.parameter = number.name, out.unit = number.unit;
  out.regime = effect.regimes.front();
  out.nominal = number.null;
  return out;
}

void WholeAnswers::cannot(WholeFigure figure, const std::string& because) {
  cannot(name_of(figure), because);
}

void WholeAnswers::cannot(const std::string& effect, const std::string& because) {
  untestable.push_back({effect, because});
}

void WholeAnswers::take(WholeAnswers later) {
  const auto append = [](auto& to, auto& from) {
    to.insert(to.end(), std::make_move_iterator(from.begin()), std::make_move_iterator(from.end()));
  };
  append(findings, later.findings), append(untestable, later.untestable);
  append(detectable, later.detectable), append(notes, later.notes), append(log, later.log);
  append(disagreements, later.disagreements), append(locations, later.locations);
  for (auto& [channel, score] : later.scores) scores[channel] = score;
  for (auto& [number, m] : later.numbers) numbers[number] = m;
  unnamed = unnamed || later.unnamed;
  asked += later.asked;
  std::erase_if(untestable, [&](const Untestable& u) {
    return std::any_of(findings.begin(), findings.end(), [&](const Finding& f) {
      return std::find(f.one_of.begin(), f.one_of.end(), u.effect) != f.one_of.end();
    });
  });
}

void WholeAnswers::widen(const std::string& choice, const WholeAnswers& other,
                         const Chance& chance) {
  for (Finding& f : findings) {
    for (auto& [name, p] : f.parameters) {
      const std::string number = number_of(f.effect, name, f.where);
      const auto here = numbers.find(number);
      const auto there = other.numbers.find(number);
      if (here == numbers.end() || there == other.numbers.end()) continue;
      const Measured& m = there->second;
      const bool missing =
          std::any_of(other.findings.begin(), other.findings.end(),
                      [&](const Finding& o) { return o.effect == f.effect && o.where == f.where; });
      if (!missing && std::find(f.one_of.begin(), f.one_of.end(), choice) == f.one_of.end())
        f.one_of.push_back(choice);
      const double apart = std::abs(m.value - here->second.value);
      if (apart > chance.deviations() * here->second.sigma || m.low < p.low || m.high > p.high)
        log.push_back(fmt::format("{} = {:.4g} [{:.4g}, {:.4g}] with {}{}", number, m.value, m.low,
                                  m.high, choice, missing ? "" : ": nothing missing there"));
      p.low = std::min(p.low, m.low), p.high = std::max(p.high, m.high);
    }
    f.status = status_of(f);
  }
}

WholeAnswers answer_to(const Asked& a, const Measured& m, const Chance& chance) {
  WholeAnswers out;
  out.asked = 1;
  out.numbers[number_of(a.effect, a.parameter, a.where)] = m;
  const double surely = chance.deviations() * m.sigma;
  const double off = std::abs(m.value - a.nominal);
  const std::string where = a.where.empty() ? std::string() : " at " + a.where.front();
  const std::string text =
      fmt::format("{}.{}{} = {:.4g} {} [{:.4g}, {:.4g}] from {} groups", a.effect, a.parameter,
                  where, m.value, a.unit, m.low, m.high, m.groups);
  out.log.push_back(text);
  if (!a.channel.empty())
    out.scores[a.channel] = {m.before, m.after, m.noise, std::numeric_limits<double>::quiet_NaN(),
                             std::numeric_limits<double>::quiet_NaN()};
  out.detectable.push_back({a.effect, a.where.empty() ? "" : a.where.front(), a.parameter, a.unit,
                            a.tolerance + surely});
  if (off <= surely) return out;
  if (off <= a.tolerance + surely || m.gain_low <= 0.0) {
    out.notes.push_back(text + why_unnamed(a, m, off, surely));
    return out;
  }
  Finding f;
  f.effect = a.effect, f.family = a.family, f.where = a.where, f.regime = a.regime;
  f.parameters[a.parameter] = {m.value, m.low, m.high, a.unit, false};
  f.heldout_gain = m.gain, f.heldout_gain_low = m.gain_low;
  f.p_family = chance.family_wise(off / std::max(m.sigma, 1e-300));
  f.one_of = {a.effect};
  f.one_of.insert(f.one_of.end(), a.equally_good.begin(), a.equally_good.end());
  f.status = status_of(f);
  out.findings.push_back(std::move(f));
  return out;
}

}  // namespace sanso::diagnose
