// A model with an effect at each joint in the place of one tied over joints: same terms, more
// numbers. It stands where neither the energy of what was fitted nor that of groups left out,
//
//   E(untied) - E(tied) <= max(standard error + unit of log-likelihood, what matters)
#include "tools/diagnose/explain/untie.h"

#include <algorithm>

#include "tools/diagnose/effects/effect.h"
#include "tools/diagnose/explain/rivals.h"

namespace sanso::diagnose {
namespace {

/// At some of the other's joints, not at all of them.
bool inside(const Candidate& part, const Candidate& whole) {
  return !part.joints.empty() && part.joints.size() < whole.joints.size() &&
         std::all_of(part.joints.begin(), part.joints.end(), [&](std::size_t j) {
           return std::find(whole.joints.begin(), whole.joints.end(), j) != whole.joints.end();
         });
}

bool of_a_kind(const Candidate& tied, const Candidate& inside) {
  return tied.effect == inside.effect || documented_twin(inside.effect, tied.effect);
}

/// Index of an effect at one joint alone, if it is in the library.
std::optional<std::size_t> at_joint(const Library& library, const std::string& effect,
                                    std::size_t joint) {
  for (std::size_t i = 0; i < library.candidates.size(); ++i) {
    const Candidate& c = library[i];
    if (c.effect == effect && c.joints == std::vector<std::size_t>{joint}) return i;
  }
  return std::nullopt;
}

std::vector<double> within_bounds(std::vector<double> theta,
                                  const std::vector<CandidateParameter>& parameters) {
  for (std::size_t k = 0; k < theta.size(); ++k)
    theta[k] = std::clamp(theta[k], parameters[k].low, parameters[k].high);
  return theta;
}

/// Appends the tied effect at each of its joints; false where the library does not place it there.
bool append_singles(const Library& library, const Chosen& tied, Model& model) {
  const Candidate& whole = library[tied];
  for (const std::size_t joint : whole.joints) {
    const std::optional<std::size_t> single = at_joint(library, whole.effect, joint);
    if (!single) return false;
    const std::vector<CandidateParameter>& parameters = library[*single].parameters;
    model.effects.push_back({*single, within_bounds(tied.theta, parameters)});
  }
  return true;
}

/// By more than the groups' spread and than what matters.
bool worse(const Surroundings& around, const HeldoutGain& lost) {
  return lost.certainty() > 1.0 && lost.removed() > practical_energy(*around.problem);
}

}  // namespace

std::vector<Untied> untied(const Library& library, const Model& model, std::size_t most) {
  std::vector<Untied> out;
  for (std::size_t t = 0; t < model.effects.size(); ++t) {
    const Candidate& tied = library[model.effects[t]];
    if (tied.random) continue;
    Untied u;
    u.model.nuisance = model.nuisance;
    for (std::size_t i = 0; i < model.effects.size(); ++i) {
      const Candidate& other = library[model.effects[i]];
      const bool goes = i == t || (inside(other, tied) && of_a_kind(tied, other));
      (goes ? u.replaced : u.stay).push_back(i);
      if (!goes) u.model.effects.push_back(model.effects[i]);
    }
    if (u.replaced.size() < 2 || !append_singles(library, model.effects[t], u.model)) continue;
    if (u.model.effects.size() <= most) out.push_back(std::move(u));
  }
  return out;
}

std::optional<FitResult> fit_untied(const Surroundings& around, const Untied& apart,
                                    const FitResult& tied) {
  FitResult out = fit(around, apart.model, around.settings().fitting.iterations);
  // on what the fits saw first: where fits without a group are erratic, the second comparison alone
  // would let anything pass
  const auto seen = [&](const FitResult& f) {
    return around.bounded(around.starts.energy_by_shot(f.r));
  };
  if (worse(around, compare(*around.problem, seen(out), seen(tied)))) return std::nullopt;
  if (worse(around,
            compare(*around.problem, refitted_energy(around, out), refitted_energy(around, tied))))
    return std::nullopt;
  return out;
}

}  // namespace sanso::diagnose
