// The method from end to end: nothing here but the order of its steps.
#include "tools/diagnose/run/diagnose.h"

#include <fmt/format.h>

#include <algorithm>

#include "shared/files/input_error.h"
#include "tools/diagnose/explain/whole_time.h"
#include "tools/diagnose/gate/load.h"
#include "tools/diagnose/run/settings_page.h"
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

SelectOptions select_options(const DiagnoseOptions& options, const Progress& progress) {
  SelectOptions out;
  out.seed = options.seed;
  out.progress = progress;
  out.keep_groups = options.first_look_by_group;
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
  out.data_hash = loaded.hashes;
  out.decisions = options.settings.decisions;
  out.seed = options.seed;
  return out;
}

/// Steps 1 to 8 on healthy data.
Diagnosis diagnose_healthy(const DiagnoseOptions& options, const Progress& progress,
                           const ModelFolder& model, const LoadedRecordings& loaded) {
  const std::vector<NoiseLevel>& noise = loaded.gate.noise;
  const Settings& settings = options.settings;
  progress("smooth the motion, cut shots");
  const std::vector<Source> sources = make_sources(model, loaded.recordings, noise, settings);
  Cut cut = cut_shots(sources, noise, settings);
  const Placement placement = place(*cut.problem, options);
  const Library library{placement.candidates, make_nuisances(*cut.problem)};
  progress(fmt::format(
      "{} shots of {:.3g} s in {} recordings, {} channels, {:.0f} % of the recorded time",
      cut.problem->shots.size(), cut.seconds, sources.size(), cut.problem->channels.size(),
      100 * cut.problem->used_share));
  const Selection selection = select(cut.problem, library, select_options(options, progress));
  progress("locate, refute, test what is left");
  const Regimes regimes = find_regimes(*selection.around->problem);
  Evidence evidence =
      measure(options, loaded, sources, placement, library, selection, regimes, *cut.whole);
  progress("fit again without the held-out recordings, score there");
  evidence.proof = prove(sources, noise, *selection.around, selection.final.model);

  Diagnosis out;
  out.verdict = conclude(evidence);
  out.patched = patched_model(model, library, selection.final.model);
  out.before = std::move(evidence.before);
  out.after = std::move(evidence.after);
  out.regimes = regimes.names;
  out.joints = cut.problem->joints;
  for (const TreeJoint& joint : model.tree.joints) out.slides.push_back(joint.prismatic ? 1 : 0);
  out.shown_joints = joints_to_show(out.verdict, model.tree);
  out.curves_before = curves_of(
      missing_torque(sources, noise, library, selection.nominal.model, settings), out.shown_joints);
  out.curves_after = curves_of(evidence.left.missing, out.shown_joints);
  out.roll_outs = roll_outs(sources, noise, library, evidence.proof, out.shown_joints, settings);
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

}  // namespace

Diagnosis diagnose(const DiagnoseOptions& options, const Progress& progress) {
  require_in_range(options.settings);
  try {
    const ModelFolder model = read_model_folder(options.model);
    require_fixed_base(model, "sanso diagnose");
    progress("read and judge the recordings");
    const LoadedRecordings loaded =
        load_recordings(options.recordings, gate_joints(model), options.settings.gate);
    if (loaded.gate.refused()) return refused(loaded.gate.defects);
    return diagnose_healthy(options, progress, model, loaded);
  } catch (const files::InputError& error) {
    return refused({defect_of(error)});
  }
}

}  // namespace sanso::diagnose
