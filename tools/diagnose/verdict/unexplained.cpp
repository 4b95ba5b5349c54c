// Four places where physics without a name can show, asked in the order of how much they say.
#include "tools/diagnose/verdict/unexplained.h"

#include <algorithm>

namespace sanso::diagnose {
namespace {

/// `u` as it shows in the missing torque, else in the velocity channel; nothing: in neither.
std::optional<Unexplained> predictable(const Evidence& evidence, Unexplained u) {
  const Predictability* torque = most_predictable(evidence.left.torque, evidence.decisions);
  const Predictability* velocity = most_predictable(evidence.left.velocity, evidence.decisions);
  const Predictability* p = torque != nullptr ? torque : velocity;
  if (p == nullptr) return std::nullopt;
  u.predictable = p->explained;
  u.p = p->p;
  u.where = evidence.joints[p->joint];
  u.shows_in = p == torque ? ShowsIn::torque : ShowsIn::velocity_channel;
  if (p == velocity) u.regime = "velocity channel against the motion of the position channel";
  return u;
}

/// The level of the position error, or a name with a reserve, says that something stays.
bool something_stays(const Evidence& evidence) {
  // however loud the effects that have a name were: what is left besides is no noise
  const bool inadequate =
      evidence.left.level > evidence.decisions.adequate && evidence.search.detected;
  const bool stopped =
      std::any_of(evidence.findings.begin(), evidence.findings.end(),
                  [](const Finding& f) { return f.status == VerdictStatus::present_unnamed; });
  // held-out predictions improved beyond chance: something is there, if not what was tried
  const bool refuted = evidence.findings.empty() && !evidence.search.refuted.empty();
  return inadequate || stopped || !evidence.search.described.empty() || refuted;
}

/// Where and how it shows; the shape comes later.
std::optional<Unexplained> placed(const Evidence& evidence) {
  Unexplained u;
  u.energy_share = evidence.left.share;
  u.regime = location_sentence(evidence.findings.empty() ? evidence.before : evidence.after);
  if (auto by_motion = predictable(evidence, u)) return by_motion;
  if (evidence.left.stretches_matter) {
    u.where = evidence.joints[*evidence.left.stretches_joint];
    u.shows_in = ShowsIn::stretches;
    u.regime = "in " + std::to_string(evidence.left.stretches.size()) + " short stretches";
    return u;
  }
  if (!something_stays(evidence)) return std::nullopt;
  u.where =
      evidence.before.cells.empty() ? evidence.joints.front() : evidence.before.cells.front().where;
  u.shows_in = ShowsIn::position;
  return u;
}

}  // namespace

const char* to_string(ShowsIn where) {
  switch (where) {
    case ShowsIn::torque:
      return "torque";
    case ShowsIn::velocity_channel:
      return "velocity channel";
    case ShowsIn::stretches:
      return "stretches";
    case ShowsIn::position:
      return "position";
  }
  return "position";
}

const Predictability* most_predictable(const std::vector<Predictability>& left,
                                       const DecisionSettings& decisions) {
  const Predictability* best = nullptr;
  const double level =
      decisions.family_wise / static_cast<double>(std::max<std::size_t>(1, left.size()));
  for (const Predictability& p : left) {
    // p resolves to 1 / (bootstrap + 1); with many joints the smallest p is all one can ask for
    const bool significant = p.p <= std::max(level, 1.0 / (decisions.bootstrap + 1.0) + 1e-12);
    if (!significant || p.explained < decisions.predictable ||
        p.torque_rms < decisions.missing_effort * p.noise_rms)
      continue;
    if (best == nullptr || p.explained > best->explained) best = &p;
  }
  return best;
}

std::optional<Unexplained> unexplained(const Evidence& evidence) {
  std::optional<Unexplained> u = placed(evidence);
  if (!u) return u;
  const auto joint = std::find(evidence.joints.begin(), evidence.joints.end(), u->where);
  u->formula =
      sparse_formula(evidence.left.missing, joint - evidence.joints.begin(), evidence.remains).text;
  u->nearest_effect = evidence.search.nearest_effect;
  return u;
}

}  // namespace sanso::diagnose
