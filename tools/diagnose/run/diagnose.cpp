// The method from end to end: nothing here but the order of its steps.
#include "tools/diagnose/run/diagnose.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>

#include "shared/files/input_error.h"
#include "tools/diagnose/explain/whole_time.h"
#include "tools/diagnose/gate/load.h"
#include "tools/diagnose/run/settings_page.h"
#include "tools/diagnose/run/time_ahead.h"
#include "tools/diagnose/run/whole_options.h"
#include "tools/diagnose/torque/columns.h"
#include "tools/diagnose/torque/disagreement.h"
#include "tools/diagnose/verdict/conclude.h"
#include "tools/diagnose/verdict/patched_model.h"

namespace sanso::diagnose {
namespace {

/// What is compared: shots for the search, and all of the recorded time.
struct Cut {
  Problem problem;
  std::optional<WholeTime> whole;
  double seconds = 0.0;  // of a shot
};

/// Throws files::InputError where no recording holds a shot: nothing was compared, no answer,
/// least of all "no mismatch".
Cut cut_shots(const std::vector<Source>& sources, const std::vector<NoiseLevel>& noise,
              const Settings& settings) {
  ProblemOptions options;
  options.shot_seconds = shot_seconds(sources, settings.data);
  options.maximum_rows = settings.data.maximum_rows;
  options.maximum_shots = settings.data.maximum_shots;
  Cut out{make_problem(sources, noise, options, settings), {}, options.shot_seconds};
  if (out.problem->shots.empty()) {
    throw files::InputError(sources.front().file, 0, "t", "too short",
                            "no piece of motion to simulate",
                            fmt::format("pieces of {:.2g} s without gaps, {} rows or more",
                                        options.shot_seconds, settings.data.least_shot_rows));
  }
  out.whole.emplace(sources, noise, options, settings);
  if (out.whole->nominal_matters())
    out.problem = make_problem(sources, noise, out.whole->with_instants(options), settings);
  return out;
}

Placement place(const Comparison& comparison, const DiagnoseOptions& options) {
  Placement placement = place_library(comparison, options.effects);
  std::erase_if(placement.candidates, [&](const Candidate& c) {
    return std::find(options.without.begin(), options.without.end(), c.effect) !=
           options.without.end();
  });
  return placement;
}

/// Tells what is asked, and keeps what was found for a run that is ended there.
class Teller {
 public:
  Teller(const Progress& progress, SoFar* so_far) : progress_(progress), so_far_(so_far) {}

  void say(const std::string& line) const { progress_(line); }
  void ask(const std::string& question, const std::string& how_long = "") const {
    progress_("asks: " + question + (how_long.empty() ? "" : " (" + how_long + ")"));
    if (so_far_ != nullptr) so_far_->asking = question;
  }
  /// What holds before the search begins.
  void begin(const Evidence& evidence) const {
    if (so_far_ != nullptr) so_far_->evidence = evidence;
  }
  void keep(const ModelFolder& model, const Library& library, const Selection& found) const {
    if (so_far_ == nullptr) return;
    so_far_->evidence.findings = accepted_so_far(library, found);
    so_far_->evidence.search = record_of(library, found);
    const double whole = found.nominal_heldout.sum();
    so_far_->evidence.unfinished.emplace();
    so_far_->evidence.unfinished->removed =
        whole > 0.0 ? 1.0 - found.final_heldout.sum() / whole : 0.0;
    so_far_->patched = patched_model(model, library, found.final.model);
    so_far_->log = found.log;
  }

 private:
  const Progress& progress_;
  SoFar* so_far_;
};

/// The search, told step by step with the time that it may still take.
Selection search(const Problem& problem, const WholeTime& whole, const Library& library,
                 const DiagnoseOptions& options, const ModelFolder& model, const Teller& tell) {
  SelectOptions how;
  how.whole = &whole;
  how.seed = options.seed;
  how.keep_groups = options.first_look_by_group;
  how.progress = [&](const std::string& line) { tell.say(line); };
  auto last = std::chrono::steady_clock::now();
  int before = 0;
  const int most = problem->settings.decisions.maximum_effects;
  how.reached = [&](const Selection& found) {
    tell.keep(model, library, found);
    const auto now = std::chrono::steady_clock::now();
    const double took = std::chrono::duration<double>(now - last).count();
    last = now;
    const int names = static_cast<int>(found.accepted.size());
    const bool more = names > before;  // else the search is over, or goes back
    before = names;
    if (!more || names >= most) return;
    tell.ask(fmt::format("is anything missing beside {} name{}, and which name predicts it?", names,
                         names == 1 ? "" : "s"),
             fmt::format("the last step took {:.2g} s, at most {} more", took, most - names));
  };
  return select(problem, library, how);
}

/// What the recordings do not agree about: the search's model fitted to each condition alone, or
/// to each recording where all have one condition. Each takes a fit; more than a few say no more.
std::vector<std::string> disagreements(const Library& library, const Selection& selection) {
  const Surroundings& around = *selection.around;
  const Comparison& comparison = *around.problem;
  std::map<std::string, std::vector<std::size_t>> groups;
  for (std::size_t s = 0; s < comparison.shots.size(); ++s) {
    const Source& source = comparison.sources[comparison.shots[s].source];
    groups[comparison.conditions > 1 ? source.condition
                                     : std::filesystem::path(source.file).stem().string()]
        .push_back(s);
  }
  std::vector<std::string> out;
  const auto most = static_cast<std::size_t>(comparison.settings.decisions.disagreeing_groups);
  if (groups.size() < 2 || groups.size() > most || selection.accepted.empty()) return out;
  std::vector<std::pair<std::string, FitResult>> fits;
  for (const auto& [name, shots] : groups) {
    Surroundings here =
        make_surroundings(with_shots(around.problem, shots), library, selection.final.model);
    here.shot_scale = around.shot_scale;
    FitResult found = fit(here, selection.final.model, 3);
    found.covariance = robust_covariance(here, found, 1.0);
    fits.emplace_back(name, std::move(found));
  }
  std::size_t next = 0;
  for (std::size_t i = 0; i < selection.accepted.size(); ++i) {
    const Candidate& c = library[selection.accepted[i].candidate];
    for (std::size_t k = 0; k < c.parameters.size(); ++k, ++next) {
      if (c.parameters[k].structural || c.random) continue;
      std::vector<GroupValue> values;
      for (const auto& [name, found] : fits) {
        if (found.fixed[next] != 0) continue;
        values.push_back(
            {name, found.model.effects[i].theta[k], parameter_sigmas(found, library)[next]});
      }
      const std::string text =
          disagreement(c.title() + ", " + c.parameters[k].name, c.parameters[k].unit, values,
                       comparison.settings.decisions);
      if (!text.empty()) out.push_back(text);
    }
  }
  return out;
}

/// Everything a verdict rests on but the held-out proof.
Evidence measure(const DiagnoseOptions& options, const LoadedRecordings& loaded,
                 const std::vector<Source>& sources, const Placement& placement,
                 const Library& library, const Selection& selection, const Regimes& regimes,
                 const WholeTime& whole) {
  const Problem& problem = selection.around->problem;
  const StartElimination& starts = selection.around->starts;
  Evidence out;
  out.joints = problem->joints;
  // the search divides channels by the error level that it reaches; a person reads errors in units
  // of the noise
  const auto located = [&](const FitResult& result) {
    return locate(*problem, regimes,
                  rescaled(*problem, starts.project(result.r), problem.scales, floors(*problem)));
  };
  out.before = located(selection.nominal);
  out.after = located(selection.final);
  out.findings = findings_of(library, selection, regimes);
  out.search = record_of(library, selection);
  for (const auto& [effect, because] : placement.untestable)
    out.untestable.push_back({effect, because});
  for (Untestable& u : too_quiet(library, selection.first, options.settings.decisions))
    out.untestable.push_back(std::move(u));
  out.detectable = smallest_sizes(library, selection.first);
  out.next_experiment = next_experiment(problem, library, selection, out.findings);
  out.left = what_is_left(sources, loaded.gate.noise, library, selection, whole, options.seed);
  out.notes = loaded.gate.notes;
  out.disagreements = disagreements(library, selection);
  out.data_hash = loaded.hashes;
  out.decisions = options.settings.decisions;
  out.remains = options.settings.remains;
  out.seed = options.seed;
  return out;
}

/// What is known before anything is simulated.
Evidence known_before(const DiagnoseOptions& options, const LoadedRecordings& loaded,
                      const Placement& placement) {
  Evidence out;
  for (const auto& [effect, because] : placement.untestable)
    out.untestable.push_back({effect, because});
  out.notes = loaded.gate.notes;
  out.data_hash = loaded.hashes;
  out.seed = options.seed;
  return out;
}

/// By effect of the final model: it is a finding that is confirmed, or one of a set.
std::vector<char> have_a_name(const Selection& selection, const std::vector<Finding>& findings) {
  std::vector<char> out;
  std::size_t next = 0;
  for (const Accepted& entry : selection.accepted) {
    const Finding* f = entry.contradicted.empty() ? &findings[next++] : nullptr;
    out.push_back(f != nullptr && (f->status == VerdictStatus::confirmed ||
                                   f->status == VerdictStatus::one_of)
                      ? 1
                      : 0);
  }
  return out;
}

/// rad, m, or both.
std::string unit_of(const RobotTree& tree) {
  const auto sliding = std::count_if(tree.joints.begin(), tree.joints.end(),
                                     [](const TreeJoint& j) { return j.prismatic; });
  if (sliding == 0) return "rad";
  return sliding == static_cast<std::ptrdiff_t>(tree.joints.size()) ? "m" : "rad and m";
}

/// The verdict, and what the report shows beside it.
Diagnosis diagnosis_of(const Evidence& evidence, const ModelFolder& model,
                       const std::vector<Source>& sources, const std::vector<NoiseLevel>& noise,
                       const Library& library, const Selection& selection,
                       const Settings& settings) {
  Diagnosis out;
  out.verdict = conclude(evidence);
  out.patched = patched_model(model, library, selection.final.model);
  out.before = evidence.before;
  out.after = evidence.after;
  out.joints = evidence.joints;
  for (const TreeJoint& joint : model.tree.joints) out.slides.push_back(joint.prismatic ? 1 : 0);
  out.shown_joints = joints_to_show(out.verdict, model.tree);
  out.curves_before = curves_of(
      missing_torque(sources, noise, library, selection.nominal.model, settings), out.shown_joints);
  out.curves_after = curves_of(evidence.left.missing, out.shown_joints);
  const Simulated simulated = simulate_heldout(sources, noise, library, evidence.proof, settings);
  out.roll_outs = roll_outs(simulated, out.shown_joints);
  out.motions = shown_motions(simulated);
  out.log = selection.log;
  out.first_look = first_look(library, selection.first, settings.tolerances);
  return out;
}

Diagnosis refused(std::vector<Defect> defects) {
  Evidence evidence;
  evidence.defects = std::move(defects);
  Diagnosis out;
  out.verdict = conclude(evidence);
  return out;
}

/// Steps 1 to 8 on healthy data.
Diagnosis diagnose_healthy(const DiagnoseOptions& options, const Teller& tell,
                           const ModelFolder& model, const LoadedRecordings& loaded) {
  const std::vector<NoiseLevel>& noise = loaded.gate.noise;
  const Settings& settings = options.settings;
  tell.ask("how did the joints move? (smoothing, cutting shots)");
  const std::vector<Source> sources = make_sources(model, loaded.recordings, noise, settings);
  if (std::vector<Defect> wrong = check_columns(sources, settings); !wrong.empty())
    return refused(std::move(wrong));
  Cut cut = cut_shots(sources, noise, settings);
  const Placement placement = place(*cut.problem, options);
  const Library library{placement.candidates, make_nuisances(*cut.problem)};
  tell.begin(known_before(options, loaded, placement));
  tell.say(fmt::format(
      "{} shots of {:.3g} s in {} recordings, {} channels, {:.0f} % of the recorded time",
      cut.problem->shots.size(), cut.seconds, sources.size(), cut.problem->channels.size(),
      100 * cut.problem->used_share));
  tell.ask(fmt::format("is anything missing, and which of {} candidates predicts it?",
                       library.candidates.size()),
           time_ahead(cut.problem, library));
  const Selection selection = search(cut.problem, *cut.whole, library, options, model, tell);
  tell.ask("where does it show, what speaks against the names, is anything left without one?");
  const Regimes regimes = find_regimes(*selection.around->problem);
  Evidence evidence =
      measure(options, loaded, sources, placement, library, selection, regimes, *cut.whole);
  evidence.unit = unit_of(model.tree);
  tell.ask("how much better are predictions of data that were not fitted?");
  evidence.proof = prove(sources, noise, *selection.around, selection.final.model,
                         have_a_name(selection, evidence.findings));

  Diagnosis out = diagnosis_of(evidence, model, sources, noise, library, selection, settings);
  out.regimes = regimes.names;
  return out;
}

}  // namespace

Diagnosis SoFar::diagnosis(double seconds) const {
  Evidence ended = evidence;
  if (!ended.unfinished) ended.unfinished.emplace();
  ended.unfinished->asking = asking;
  ended.unfinished->seconds = seconds;
  Diagnosis out;
  out.verdict = conclude(ended);
  out.patched = patched;
  out.log = log;
  return out;
}

Diagnosis diagnose(const DiagnoseOptions& options, const Progress& progress, SoFar* so_far) {
  require_in_range(options.settings);
  const Teller tell(progress, so_far);
  try {
    const ModelFolder model = read_model_folder(options.model);
    if (model.floating) {
      Diagnosis whole;
      whole.verdict = diagnose_whole(whole_options(options), progress).verdict;
      return whole;
    }
    tell.ask("are the recordings sound?");
    const LoadedRecordings loaded =
        load_recordings(options.recordings, gate_joints(model), options.settings.gate);
    if (loaded.gate.refused()) return refused(loaded.gate.defects);
    return diagnose_healthy(options, tell, model, loaded);
  } catch (const files::InputError& error) {
    return refused({defect_of(error)});
  }
}

}  // namespace sanso::diagnose
