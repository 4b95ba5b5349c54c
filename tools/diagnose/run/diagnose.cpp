#include "tools/diagnose/run/diagnose.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/effects/from_model.h"
#include "tools/diagnose/explain/events.h"
#include "tools/diagnose/explain/incidence.h"
#include "tools/diagnose/gate/load.h"
#include "tools/diagnose/run/settings_page.h"
#include "tools/diagnose/stats/robust.h"
#include "tools/diagnose/verdict/conclude.h"
#include "tools/diagnose/verdict/decide.h"
#include "tools/diagnose/verdict/experiment.h"
#include "tools/diagnose/verdict/heldout.h"
#include "tools/diagnose/verdict/velocity.h"
#include "tools/recording/input_error.h"

namespace sanso::diagnose {
namespace {

/// FNV-1a of the file's columns: which data a verdict speaks of.
std::string data_hash(const recording::Recording& r) {
  std::uint64_t h = 1469598103934665603ULL;
  const auto mix = [&](const std::vector<double>& values) {
    const auto* bytes = reinterpret_cast<const unsigned char*>(values.data());
    for (std::size_t i = 0; i < values.size() * sizeof(double); ++i)
      h = (h ^ bytes[i]) * 1099511628211ULL;
  };
  mix(r.t);
  for (const recording::Channel& c : r.channels) mix(c.values);
  return fmt::format("{:016x}", h);
}

/// The model's effects and calibrations as entries of model.toml.
ModelFolder patched_model(const ModelFolder& nominal, const Library& library, const Model& model) {
  ModelFolder out = nominal;
  const auto add = [&](const std::string& id, const std::vector<std::string>& where,
                       const std::vector<double>& theta) {
    out.effects.push_back(entry_of({find_effect(id), where, theta}));
  };
  for (std::size_t i = 0; i < model.nuisance.size(); ++i) {
    const Nuisance& n = library.nuisances[i];
    // less than a hundredth of its tolerance is no calibration
    if (std::abs(model.nuisance[i]) < 0.01 * n.tolerance) continue;
    std::vector<std::string> where;
    for (const int j : n.joints) {
      const TreeJoint& joint = nominal.tree.joints[static_cast<std::size_t>(j)];
      where.push_back(find_effect(n.effect)->scope == Scope::link ? joint.link : joint.name);
    }
    add(n.effect, where, n.theta(model.nuisance[i]));
  }
  for (const Chosen& c : model.effects) {
    const Candidate& candidate = library.candidates[static_cast<std::size_t>(c.candidate)];
    add(candidate.effect, candidate.where, c.theta);
  }
  return out;
}

std::vector<RollOut> roll_outs(const std::vector<Source>& sources,
                               const std::vector<NoiseLevel>& noise, const Library& library,
                               const Model& patched, const Part& part,
                               const std::vector<int>& joints, const Settings& settings) {
  std::vector<RollOut> out;
  ProblemOptions options;
  options.shot_seconds = 2.0;
  options.maximum_rows = 4 * settings.data.maximum_rows;
  options.secondary = false;
  const Problem problem = restricted(make_problem(sources, noise, options, settings), part);
  if (problem.shots.empty()) return out;
  const Eigen::VectorXd before = prediction_error(problem, library, Model{}),
                        after = prediction_error(problem, library, patched);
  for (const int joint : joints) {
    for (std::size_t c = 0; c < problem.channels.size(); ++c) {
      if (problem.channels[c].joint != joint || problem.channels[c].signal != Signal::q) continue;
      RollOut r;
      r.joint = problem.joints[static_cast<std::size_t>(joint)];
      r.recording = problem.sources[static_cast<std::size_t>(problem.shots.front().source)].file;
      r.noise = problem.channels[c].noise;
      int shown = 0;
      for (const Shot& shot : problem.shots) {
        if (shot.source != problem.shots.front().source || ++shown > 4) break;
        const Source& source = problem.sources[static_cast<std::size_t>(shot.source)];
        for (std::size_t k = 0; k < shot.rows; ++k) {
          const std::size_t row =
              shot.window.first + (k + 1) * static_cast<std::size_t>(shot.stride);
          const auto i = static_cast<Eigen::Index>(shot.offset + c * shot.rows + k);
          const double y = measured(source, problem.channels[c], row);
          r.t.push_back(source.drive.t[row]);
          r.measured.push_back(y);
          r.nominal.push_back(y - problem.channels[c].sigma * before[i]);
          r.patched.push_back(y - problem.channels[c].sigma * after[i]);
        }
        r.t.push_back(r.t.back()), r.measured.push_back(NAN), r.nominal.push_back(NAN),
            r.patched.push_back(NAN);  // pen up
      }
      out.push_back(std::move(r));
    }
  }
  return out;
}

/// The joints worth showing: those of findings and of what is unexplained, at most three.
std::vector<int> joints_to_show(const Verdict& verdict, const Problem& problem,
                                const LocationMap& map) {
  std::vector<int> out;
  const auto add = [&](const std::string& name) {
    for (std::size_t j = 0; j < problem.joints.size(); ++j) {
      const bool is =
          problem.joints[j] == name || problem.sources.front().nominal.tree.joints[j].link == name;
      if (is && out.size() < 3 &&
          std::find(out.begin(), out.end(), static_cast<int>(j)) == out.end())
        out.push_back(static_cast<int>(j));
    }
  };
  for (const Finding& f : verdict.findings) {
    for (const std::string& w : f.where) add(w);
  }
  if (verdict.unexplained) add(verdict.unexplained->where);
  for (const LocationCell& c : map.cells) {
    if (out.empty()) add(c.where);
  }
  if (out.empty()) out.push_back(0);
  return out;
}

/// Length of a shot, or what the slowest recording needs for the least number of rows.
double shot_seconds(const std::vector<Source>& sources, const DataSettings& settings) {
  double seconds = settings.shot_seconds;
  for (const Source& s : sources) {
    std::vector<double> steps;
    for (std::size_t k = 1; k < s.drive.t.size(); ++k)
      steps.push_back(s.drive.t[k] - s.drive.t[k - 1]);
    if (!steps.empty())
      seconds = std::max(seconds, settings.least_shot_rows * quantile(steps, 0.5));
  }
  return seconds;
}

/// Steps 1 to 8 on healthy data.
class Run {
 public:
  Run(const DiagnoseOptions& options, const Progress& progress, const ModelFolder& model,
      const LoadedRecordings& loaded)
      : options_(options),
        settings_(options.settings),
        progress_(progress),
        model_(model),
        loaded_(loaded) {}

  Diagnosis all() {
    prepare();
    search();
    locate_and_conclude();
    prove();
    return std::move(out_);
  }

 private:
  void prepare() {
    progress_("smooth the motion, cut shots");
    sources_ = make_sources(model_, loaded_.recordings, loaded_.gate.noise, settings_);
    ProblemOptions options;
    options.shot_seconds = shot_seconds(sources_, settings_.data);
    options.maximum_rows = settings_.data.maximum_rows;
    options.maximum_shots = settings_.data.maximum_shots;
    problem_ = make_problem(sources_, loaded_.gate.noise, options, settings_);
    if (!problem_.shots.empty() && look_for_events(options))
      problem_ = make_problem(sources_, loaded_.gate.noise, options, settings_);
    if (problem_.shots.empty()) {  // nothing was compared: no answer, least of all "no mismatch"
      throw recording::InputError(
          sources_.front().file, 0, "t", "too short", "no piece of motion to simulate",
          fmt::format("pieces of {:.2g} s without gaps, {} rows or more", options.shot_seconds,
                      settings_.data.least_shot_rows));
    }
    Placement placement = place_library(problem_, options_.effects);
    std::erase_if(placement.candidates, [&](const Candidate& c) {
      return std::find(options_.without.begin(), options_.without.end(), c.effect) !=
             options_.without.end();
    });
    library_.candidates = std::move(placement.candidates);
    library_.nuisances = make_nuisances(problem_);
    for (const auto& [effect, because] : placement.untestable)
      out_.verdict.untestable.push_back({effect, because});
    out_.joints = problem_.joints;
    for (const TreeJoint& joint : model_.tree.joints)
      out_.slides.push_back(joint.prismatic ? 1 : 0);
    out_.verdict.seed = options_.seed;
    out_.verdict.notes = loaded_.gate.notes;
    for (const recording::Recording& r : loaded_.recordings)
      out_.verdict.data_hash[r.file] = data_hash(r);
    progress_(fmt::format(
        "{} shots of {:.3g} s in {} recordings, {} channels, {:.0f} % of the recorded time",
        problem_.shots.size(), options.shot_seconds, sources_.size(), problem_.channels.size(),
        100 * problem_.used_share));
  }

  /// Errors of the nominal model that stand alone: their instants are compared in every recording,
  /// whatever thinning leaves out. True: there are some.
  bool look_for_events(ProblemOptions& options) {
    ProblemOptions all = options;
    all.maximum_rows = 4 * settings_.data.maximum_rows;
    all.maximum_shots = std::numeric_limits<int>::max();
    all.secondary = false;
    Library calibrated;
    whole_ = make_problem(sources_, loaded_.gate.noise, all, settings_);
    calibrated.nuisances = make_nuisances(whole_);
    const std::vector<Event> events = events_left(calibrated, Model{});
    if (repeated(events).energy < practical_energy(whole_)) return false;
    // three shots a recording and instant, as many in all as half the search's
    const std::size_t allowed =
        static_cast<std::size_t>(settings_.data.maximum_shots) / (2 * 3 * sources_.size());
    options.instants = instants_of(whole_, events, std::max<std::size_t>(1, allowed));
    for (const Event& e : events) options.struck.push_back(e.joint);
    return true;
  }

  std::vector<Event> events_left(const Library& library, const Model& model) {
    correct_step(whole_, library, model);
    const StartElimination starts(whole_, library, model);
    const Eigen::VectorXd error = starts.project(prediction_error(whole_, library, model));
    if (model.effects.empty() && model.nuisance.empty()) energy_at_first_ = error.squaredNorm();
    return find_events(whole_, error);
  }

  void search() {
    SelectOptions options;
    options.seed = options_.seed;
    options.progress = progress_;
    options.keep_groups = options_.first_look_by_group;
    selection_ = select(problem_, library_, options);
    out_.log = selection_.log;
    Screening& first = selection_.first;
    out_.first_look.by_group = std::move(first.by_group);
    out_.first_look.nuisances = first.known;
    out_.first_look.nuisance_precision = settings_.tolerances.precision;
    out_.first_look.critical = first.critical;
    for (const ProbeScore& p : first.probes) {
      const Candidate& c = library_.candidates[static_cast<std::size_t>(p.candidate)];
      out_.first_look.effect.push_back(c.effect);
      out_.first_look.family.push_back(c.family);
      out_.first_look.z.push_back(p.z);
    }
    out_.first_look.correlation.assign(first.correlation.data(),
                                       first.correlation.data() + first.correlation.size());
  }

  /// The search divides channels by the error level it reaches; a person reads errors in units of
  /// the noise.
  Eigen::VectorXd in_noise_levels(Eigen::VectorXd r) const {
    for (const Shot& shot : problem_.shots) {
      for (std::size_t c = 0; c < problem_.channels.size(); ++c) {
        r.segment(static_cast<Eigen::Index>(shot.offset + c * shot.rows),
                  static_cast<Eigen::Index>(shot.rows)) *=
            problem_.channels[c].sigma / problem_.channels[c].floor;
      }
    }
    return r;
  }

  void locate_and_conclude() {
    progress_("locate, refute, test what is left");
    const Regimes regimes = find_regimes(problem_);
    out_.regimes = regimes.names;
    out_.before = locate(problem_, regimes,
                         in_noise_levels(selection_.around->starts.project(selection_.nominal.r)));
    out_.after = locate(problem_, regimes,
                        in_noise_levels(selection_.around->starts.project(selection_.final.r)));
    Verdict& v = out_.verdict;
    v.locations = out_.before.cells;
    v.findings = findings_of(library_, selection_, regimes);
    add_limits(v, library_, selection_);
    v.next_experiment = next_experiment(problem_, library_, selection_, v.findings);
    const std::vector<TorqueSample> left =
        missing_torque(sources_, loaded_.gate.noise, library_, selection_.final.model, settings_);
    Remains remains;
    remains.torque = predictable(left, 100);
    remains.velocity = predictable(velocity_errors(sources_, loaded_.gate.noise, settings_), 10000);
    std::erase_if(remains.velocity,
                  [&](const Predictability& p) { return velocity_has_a_name(p.joint); });
    judge_stretches(remains);
    decide(v, problem_, library_, selection_, remains,
           location_sentence(v.findings.empty() ? out_.before : out_.after));
    out_.shown_joints = joints_to_show(v, problem_, out_.before);
    const std::vector<TorqueSample> at_first =
        missing_torque(sources_, loaded_.gate.noise, library_, selection_.nominal.model, settings_);
    for (const int j : out_.shown_joints) {
      out_.curves_before.push_back(shape_curves(at_first, j));
      out_.curves_after.push_back(shape_curves(left, j));
    }
    if (v.unexplained) {
      const auto at =
          std::find(problem_.joints.begin(), problem_.joints.end(), v.unexplained->where);
      v.unexplained->formula =
          sparse_formula(left, static_cast<int>(at - problem_.joints.begin())).text;
      if (!selection_.first.probes.empty()) {
        v.unexplained->nearest_effect =
            library_.candidates[static_cast<std::size_t>(selection_.first.ranking().front())]
                .effect;
      }
    }
  }

  /// By joint; `stream`: of random draws.
  std::vector<Predictability> predictable(const std::vector<TorqueSample>& samples,
                                          std::uint64_t stream) const {
    std::vector<Predictability> out(problem_.joints.size());
    parallel_for(static_cast<int>(out.size()), [&](int j) {
      const auto k = static_cast<std::size_t>(j);
      out[k] = predictability(samples, j, Random(options_.seed, stream + k), settings_);
    });
    return out;
  }

  /// An accepted effect acts on the joint's velocity channel: what that channel shows is in the
  /// model.
  bool velocity_has_a_name(int joint) const {
    return std::any_of(
        selection_.accepted.begin(), selection_.accepted.end(), [&](const Accepted& a) {
          const Candidate& c = library_.candidates[static_cast<std::size_t>(a.candidate)];
          const bool here = std::find(c.joints.begin(), c.joints.end(), joint) != c.joints.end();
          return here && (find_effect(c.effect)->needs & kVelocity) != 0;
        });
  }

  /// Errors of the last model that stand alone, over all of the recorded time.
  void judge_stretches(Remains& remains) {
    const std::vector<Event> events = events_left(library_, selection_.final.model);
    const RepeatedEvents again = repeated(events);
    remains.stretches_matter =
        selection_.expected_scatter.size() == 0 &&  // chance that has a name makes them
        again.energy > std::max(practical_energy(whole_),
                                settings_.decisions.minimum_share * energy_at_first_);
    remains.stretches_joint = again.joint;
    for (const Event& e : events) {
      const Shot& shot = whole_.shots[e.shot];
      const Source& source = whole_.sources[static_cast<std::size_t>(shot.source)];
      out_.verdict.stretches.push_back(
          {source.file, whole_.joints[static_cast<std::size_t>(e.joint)],
           source.drive.t[shot.window.first], source.drive.t[shot.window.last], e.level});
    }
  }

  /// Fits the same structure without the held-out part and scores it there; then writes the model
  /// fitted to everything.
  void prove() {
    progress_("fit again without the held-out recordings, score there");
    const Split split = make_split(sources_);
    const Problem fitted = restricted(problem_, split.fitted);
    Surroundings around = make_surroundings(fitted, library_, selection_.final.model);
    around.shot_scale = selection_.around->shot_scale;
    const FitResult refit = fit(around, selection_.final.model, settings_.fitting.iterations);
    out_.verdict.heldout = heldout_scores(sources_, loaded_.gate.noise, library_, refit.model,
                                          split.heldout, settings_);
    out_.verdict.heldout_recordings = split.heldout_names;
    out_.roll_outs = roll_outs(sources_, loaded_.gate.noise, library_, refit.model, split.heldout,
                               out_.shown_joints, settings_);
    out_.patched = patched_model(model_, library_, selection_.final.model);
  }

  const DiagnoseOptions& options_;
  const Settings& settings_;
  const Progress& progress_;
  const ModelFolder& model_;
  const LoadedRecordings& loaded_;
  std::vector<Source> sources_;
  // what the search compares; all of the recorded time, positions only
  Problem problem_, whole_;
  double energy_at_first_ = 0.0;  // of the nominal model's error in whole_, noise energies
  Library library_;
  Selection selection_;
  Diagnosis out_;
};

Diagnosis refused(std::vector<Defect> defects) {
  Diagnosis out;
  out.verdict.status = VerdictStatus::refused;
  const Defect& first = defects.front();
  out.verdict.answer = "Refused: " + first.file +
                       (first.channel.empty() ? "" : ", " + first.channel) +
                       (first.row >= 0 ? fmt::format(", row {}", first.row) : "") + ": " +
                       first.defect + " (" + first.message + ").";
  out.verdict.refused = std::move(defects);
  return out;
}

}  // namespace

Diagnosis diagnose(const DiagnoseOptions& options, const Progress& progress) {
  require_in_range(options.settings);
  try {
    const ModelFolder model = read_model_folder(options.model);
    progress("read and judge the recordings");
    const LoadedRecordings loaded = load_recordings(options.recordings, gate_joints(model));
    if (loaded.gate.refused()) return refused(loaded.gate.defects);
    return Run(options, progress, model, loaded).all();
  } catch (const recording::InputError& error) {
    return refused({defect_of(error)});
  }
}

}  // namespace sanso::diagnose
