// Order of the questions: lengths first, since every later one measures in them.
#include "tools/diagnose/wholebody/diagnose_whole.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "shared/files/input_error.h"
#include "shared/math/so3.h"
#include "tools/diagnose/gate/load.h"
#include "tools/diagnose/verdict/conclude.h"
#include "tools/diagnose/verdict/plain_words.h"
#include "tools/diagnose/wholebody/choices.h"

namespace sanso::diagnose {
namespace {

WholeDiagnosis refused(std::vector<Defect> defects) {
  Evidence evidence;
  evidence.defects = std::move(defects);
  WholeDiagnosis out;
  out.verdict = conclude(evidence);
  return out;
}

std::string answer_of(const WholeAnswers& answers) {
  std::string text;
  if (answers.findings.empty() && answers.unnamed) {
    text = fmt::format("Missing: something without a name, most at {}",
                       answers.locations.front().where);
  } else if (answers.findings.empty()) {
    text = fmt::format("No mismatch in the {} numbers that these recordings could be asked for",
                       answers.asked);
  } else {
    text = "Missing: ";
    for (std::size_t i = 0; i < answers.findings.size(); ++i)
      text += (i == 0 ? "" : "; ") + sentence(answers.findings[i]);
  }
  std::string names;
  for (const Untestable& u : answers.untestable) names += (names.empty() ? "" : ", ") + u.effect;
  return text + (names.empty() ? "." : ". Not testable here: " + names + ".");
}

/// What no recording of positions can show without forces or commands, said once.
WholeAnswers limits_of(const WholeData& data, const WholeBody& body) {
  WholeAnswers answers;
  if (body.model.tree.size() == 0)
    answers.cannot(WholeFigure::compliance,
                   "a touchdown lasts as long as a few samples: stiffness is not asked for");
  else
    answers.cannot(WholeFigure::sole_shape, "no pressure under the soles was recorded");
  answers.cannot(WholeFigure::rolling, "wheels only");
  const bool weighed = std::any_of(data.recordings.begin(), data.recordings.end(),
                                   [](const WholeRecording& r) { return !r.feet.empty(); });
  if (!weighed)
    answers.notes.push_back("nothing weighs the robot: its motion alone is the same at any mass");
  return answers;
}

/// What names are worth on data that they were not fitted to.
std::string proof_of(const WholeAnswers& answers) {
  const auto stance = answers.scores.find(kStanceBalance);
  if (answers.findings.empty() || stance == answers.scores.end()) return {};
  const FitScore& s = stance->second;
  if (!(s.patched < s.nominal)) return {};
  return fmt::format(
      " Where it was not fitted, drives and motion disagree by {:.3g} deviations of what is known "
      "beforehand, and by {:.3g} with what was found.",
      s.nominal, s.patched);
}

Verdict verdict_of(const WholeAnswers& answers, const WholeData& data, unsigned long seed) {
  Verdict v;
  v.findings = answers.findings;
  v.status = overall_status(v.findings, answers.unnamed);
  v.mismatch = v.status != VerdictStatus::absent;
  v.locations = answers.locations;
  if (answers.unnamed && !answers.locations.empty()) {
    Unexplained& u = v.unexplained.emplace();
    u.shows_in = ShowsIn::torque, u.where = answers.locations.front().where, u.regime = "stance";
    u.nearest_effect = "none";
    const FitScore& s = answers.scores.at(kStanceBalance);
    u.energy_share = std::min(1.0, std::pow(s.patched / std::max(s.nominal, 1e-300), 2));
  }
  v.answer = answer_of(answers);
  v.untestable = answers.untestable;
  v.detectable = answers.detectable;
  v.heldout[Horizon::recorded_motion()].channels = answers.scores;
  if (!answers.scores.empty())
    v.heldout_recordings = {data.recordings.size() >= 8 ? "every third recording"
                                                        : "every third piece of each recording"};
  v.disagreements = answers.disagreements;
  v.notes = data.notes;
  v.notes.insert(v.notes.end(), answers.notes.begin(), answers.notes.end());
  v.data_hash = data.hashes;
  v.seed = seed;
  return v;
}

/// The questions about impulses again, as if what they rest on were something else.
WholeAnswers asked_otherwise(const Asking& asking, const Known& before, WholeAnswers answers,
                             const std::function<void(const std::string&)>& progress) {
  if (answers.findings.empty() || asking.body.model.tree.size() > 0) return answers;
  const Asked scale = asked_for(WholeFigure::pose_scale);
  const auto fall =
      answers.numbers.find(number_of(scale.effect, scale.parameter, {asking.body.root}));
  std::optional<Measured> fallen;
  if (fall != answers.numbers.end()) fallen = fall->second;
  for (const Choice& c : other_choices(asking, before, fallen)) {
    progress("asks again with " + c.name);
    Asking other{c.body,           c.recordings,      c.known,     c.settings,
                 asking.decisions, asking.tolerances, asking.seed, asking.stance};
    answers.widen(c.name, ask_hits(other).answers, asking.chance());
  }
  return answers;
}

Defect nothing_to_ask(const WholeData& data, const WholeAnswers& answers) {
  std::string why;
  for (const Untestable& u : answers.untestable)
    why += (why.empty() ? "" : "; ") + u.effect + ": " + u.because;
  return {data.recordings.front().file, "", -1, defect::kTooShort,
          "these recordings answer none of the questions (" + why + ")"};
}

}  // namespace

bool floats(const std::string& model_folder) {
  try {
    return read_model_folder(model_folder).floating;
  } catch (const files::InputError&) {
    return false;
  }
}

WholeDiagnosis diagnose_whole(const WholeOptions& options, const WholeBody& body,
                              const WholeData& data,
                              const std::function<void(const std::string&)>& progress) {
  if (!data.defects.empty()) return refused(data.defects);
  WholeBody nominal = body;
  Known known = apply_effects(nominal);
  Answered found;
  const Patch& patch = found.patch;
  const Known before = known;
  const auto asking = [&] {
    const Settings& s = options.settings;
    return Asking{nominal,      data.recordings, known,    s.whole,    s.decisions,
                  s.tolerances, options.seed,    s.stance, s.smoother, options.effects};
  };
  progress("asks: does it fall as gravity says?");
  found.take(ask_free_fall(asking()));
  if (patch.pose_scale) known.pose_scale = *patch.pose_scale;
  progress("asks: what do hits and slides say of the ground?");
  found.take(ask_hits(asking()));
  progress("asks: do the feet carry what it weighs?");
  found.take(ask_weight(asking()));
  if (body.model.tree.size() > 0) {
    progress("asks: do soles sink under a load?");
    found.take(ask_sinking(asking()));
  }
  progress("asks: does the IMU read what the base does?");
  found.take(ask_imu(asking()));
  progress("asks: do standing soles lie flat, and stay?");
  found.take(ask_soles(asking()));
  if (patch.imu_turn) known.imu_turn = math::rotation_matrix(math::quat_exp(V3(-*patch.imu_turn)));
  if (patch.acc_bias) known.acc_bias += *patch.acc_bias;
  if (body.model.tree.size() > 0) {
    progress("asks: do drives, links and motion agree?");
    found.take(ask_drives(asking()));
  }
  WholeAnswers answers = asked_otherwise(asking(), before, std::move(found.answers), progress);
  if (answers.asked == 0) return refused({nothing_to_ask(data, answers)});
  answers.take(limits_of(data, body));
  WholeDiagnosis out;
  out.verdict = verdict_of(answers, data, options.seed);
  out.proof = proof_of(answers);
  out.verdict.summary = plain_words(out.verdict) + out.proof;
  out.nominal = body, out.patched = patched(body, patch);
  out.log = answers.log, out.stance = std::move(found.shown);
  out.apart = std::move(found.apart);
  return out;
}

WholeDiagnosis diagnose_whole(const WholeOptions& options,
                              const std::function<void(const std::string&)>& progress) {
  try {
    const WholeBody body = read_whole_body(options.model, options.settings.whole);
    progress("asks: are the recordings sound?");
    WholeData data = load_whole(options.recordings, body, options.settings);
    WholeDiagnosis out = diagnose_whole(options, body, data, progress);
    if (out.verdict.status != VerdictStatus::refused) out.recordings = std::move(data.recordings);
    return out;
  } catch (const files::InputError& error) {
    return refused({defect_of(error)});
  }
}

}  // namespace sanso::diagnose
