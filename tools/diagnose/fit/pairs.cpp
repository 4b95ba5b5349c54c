// The promise of two effects together, from scores and correlations that the screening has
// measured: no simulation.
#include "tools/diagnose/fit/pairs.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "tools/diagnose/effects/effect.h"

namespace sanso::diagnose {
namespace {

bool part_of(const Candidate& small, const Candidate& large) {
  return std::find(large.contains.begin(), large.contains.end(), small.effect) !=
         large.contains.end();
}

/// One joint, or one of them is the whole robot's.
bool at_one_place(const Candidate& a, const Candidate& b) {
  return a.joints == b.joints || a.joints.empty() || b.joints.empty();
}

/// Both are functions of one quantity at one joint: terms of a series, which names nothing.
bool one_series(const Candidate& a, const Candidate& b) {
  const Effect *x = find_effect(a.effect), *y = find_effect(b.effect);
  return x != nullptr && y != nullptr && a.joints == b.joints && (x->terms & y->terms) != 0;
}

bool may_stand_together(const Candidate& a, const Candidate& b) {
  return a.effect != b.effect && at_one_place(a, b) && !one_series(a, b) && !part_of(a, b) &&
         !part_of(b, a);
}

/// An event is judged by its instant, chance by its scatter, neither beside another.
bool simple(const Candidate& c) {
  return !c.random &&
         std::none_of(c.parameters.begin(), c.parameters.end(),
                      [](const CandidateParameter& p) { return p.role == Role::event; });
}

}  // namespace

TogetherPromise promise_together(double za, double zb, double rho, bool a_signed, bool b_signed,
                                 double alike) {
  if (!(std::abs(rho) < alike)) return {};
  const double apart = 1.0 - rho * rho;
  TogetherPromise out;
  out.a = (za - rho * zb) / apart;
  out.b = (zb - rho * za) / apart;
  if ((a_signed && out.a < 0.0) || (b_signed && out.b < 0.0)) return {};
  out.energy = (za * za - 2.0 * rho * za * zb + zb * zb) / apart;
  return out;
}

namespace {

/// The best pair of probes of every pair of candidates, and how many pairs of probes there were.
struct Looked {
  std::map<std::pair<std::size_t, std::size_t>, CandidatePair> best;
  double at = 0.0;
};

Looked look_at_all(const Library& library, const Screening& screening,
                   const DecisionSettings& decisions) {
  Looked out;
  const std::vector<ProbeScore>& probes = screening.probes;
  for (std::size_t i = 0; i < probes.size(); ++i) {
    const Candidate& a = library[probes[i].candidate];
    if (!simple(a) || probes[i].signature <= 0.0) continue;
    for (std::size_t k = i + 1; k < probes.size(); ++k) {
      const Candidate& b = library[probes[k].candidate];
      if (!simple(b) || probes[k].signature <= 0.0 || !may_stand_together(a, b)) continue;
      out.at += 1.0;
      const double rho =
          screening.correlation(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k));
      const TogetherPromise both = promise_together(probes[i].z, probes[k].z, rho, !a.two_sided,
                                                    !b.two_sided, 1.0 - decisions.one_signature);
      CandidatePair& of = out.best[{probes[i].candidate, probes[k].candidate}];
      if (!(both.energy > of.promise)) continue;
      of.promise = both.energy;
      of.first = probes[i], of.second = probes[k];
      of.first.amount = both.a / probes[i].signature;
      of.second.amount = both.b / probes[k].signature;
    }
  }
  return out;
}

}  // namespace

std::vector<CandidatePair> promising_pairs(const Settings& settings, const Library& library,
                                           const Screening& screening, double least_energy) {
  double single = 0.0;
  for (const ProbeScore& p : screening.probes) single = std::max(single, p.score * p.score);
  const double least = std::max(single + screening.critical * screening.critical,
                                least_energy / settings.fitting.linear_reach);
  Looked looked = look_at_all(library, screening, settings.decisions);
  std::vector<CandidatePair> order;
  for (auto& [which, pair] : looked.best) {
    // chi-square with two degrees of freedom has the tail exp(-x / 2)
    pair.p = std::min(1.0, looked.at * std::exp(-0.5 * pair.promise));
    if (pair.promise > least && pair.p < settings.decisions.family_wise) order.push_back(pair);
  }
  std::stable_sort(order.begin(), order.end(),
                   [](const auto& a, const auto& b) { return a.promise > b.promise; });
  std::map<std::size_t, int> times;
  std::vector<CandidatePair> out;
  for (const CandidatePair& pair : order) {
    int &a = times[pair.first.candidate], &b = times[pair.second.candidate];
    if (out.size() == static_cast<std::size_t>(settings.decisions.pairs)) break;
    if (std::max(a, b) >= settings.decisions.pairs_of_one) continue;
    ++a, ++b;
    out.push_back(pair);
  }
  return out;
}

std::vector<CandidatePair> pairs_in_place_of(
    const Settings& settings, const Library& library, const Screening& screening,
    std::size_t candidate, const std::function<bool(const Candidate&, const Candidate&)>& allowed) {
  std::vector<CandidatePair> out;
  const ProbeScore* own = screening.best(candidate);
  if (own == nullptr) return out;
  const double nearly = settings.decisions.nearly_strongest * own->score;
  for (auto& [which, pair] : look_at_all(library, screening, settings.decisions).best) {
    const std::size_t a = which.first, b = which.second;
    if (a == candidate || b == candidate || !allowed(library[a], library[b])) continue;
    const double single = std::max(screening.best(a)->score, screening.best(b)->score);
    const double more = pair.promise - single * single;
    if (pair.promise > nearly * nearly && more > screening.critical * screening.critical)
      out.push_back(pair);
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const auto& x, const auto& y) { return x.promise > y.promise; });
  if (std::cmp_less(settings.decisions.pairs, out.size()))
    out.resize(static_cast<std::size_t>(settings.decisions.pairs));
  return out;
}

}  // namespace sanso::diagnose
