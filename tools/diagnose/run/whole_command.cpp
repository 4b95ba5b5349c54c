// `sanso diagnose` of a base that floats: what the terminal, verdict.txt and the page say.
#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "tools/diagnose/run/ending.h"
#include "tools/diagnose/run/next_motion.h"
#include "tools/diagnose/run/report_sections.h"
#include "tools/diagnose/run/report_words.h"
#include "tools/diagnose/run/whole_options.h"
#include "tools/diagnose/verdict/plain_words.h"

namespace sanso::diagnose {
namespace {

std::string parameters_text(const Finding& f) {
  std::string out;
  for (const auto& [name, p] : f.parameters)
    out += fmt::format("{:<11}{}.{} at {} = {:.4g} {} [{:.4g}, {:.4g}]\n", "", f.effect, name,
                       places(f.where), p.value, p.unit, p.low, p.high);
  return out;
}

std::string next_text(const NextExperiment& e) {
  std::string out = fmt::format("next       {}", e.what);
  if (std::isfinite(e.seconds_to_100_to_1))
    out += fmt::format("; {:.1f} s of it for odds of 100 to 1", e.seconds_to_100_to_1);
  out += "\n";
  if (!e.motion_file.empty())
    out += fmt::format("{:<11}{} can be run: see `sanso motions`, SANSO_MOTIONS names its folder\n",
                       "", e.motion_file);
  return out;
}

std::string whole_text(const Verdict& v) {
  std::string out = wrapped(v.summary, 96) + "\n";
  out += "question   what do pose, IMU and feet say that the model does not?\n";
  out += fmt::format("answer     {}: {}\n", to_string(v.status), v.answer);
  for (const Defect& d : v.refused)
    out += fmt::format("refused    {} {}{}: {}: {}\n", d.file, d.channel,
                       d.row >= 0 ? fmt::format(" row {}", d.row) : "", d.defect, d.message);
  if (v.status == VerdictStatus::refused) return out;
  for (const Finding& f : v.findings) out += parameters_text(f);
  const auto scores = v.heldout.find(Horizon::recorded_motion());
  if (scores != v.heldout.end()) {
    for (const auto& [channel, s] : scores->second.channels)
      out += fmt::format("held out   {}: {:.4g} -> {:.4g} (noise {:.2g})\n", channel, s.nominal,
                         s.patched, s.noise);
  }
  if (v.next_experiment) out += next_text(*v.next_experiment);
  for (const Untestable& u : v.untestable)
    out += fmt::format("untestable {}: {}\n", u.effect, u.because);
  for (const std::string& note : v.notes) out += fmt::format("note       {}\n", note);
  return out;
}

void tell_scores(report::HtmlPage& page, const Verdict& v) {
  const auto scores = v.heldout.find(Horizon::recorded_motion());
  if (scores == v.heldout.end() || scores->second.channels.empty()) return;
  page.heading("Proof on data that were not fitted");
  report::Table table{{"what", "nominal", "patched", "noise"}, {}};
  for (const auto& [channel, s] : scores->second.channels)
    table.rows.push_back({channel, fmt::format("{:.4g}", s.nominal),
                          fmt::format("{:.4g}", s.patched), fmt::format("{:.2g}", s.noise)});
  page.table(table);
}

std::string page_of(const WholeDiagnosis& d, double creeping) {
  const Verdict& v = d.verdict;
  report::HtmlPage page("Diagnosis of the whole robot");
  page.paragraph(v.summary);
  page.answer(fmt::format("{}: {}", to_string(v.status), v.answer),
              v.status == VerdictStatus::absent);
  if (v.status == VerdictStatus::refused) {
    tell_refusal(page, v);
    return page.finish();
  }
  if (d.nominal && d.patched)
    tell_robot(page, v, d.patched->model, shown_motions(d.recordings, *d.nominal, *d.patched));
  if (d.nominal && d.stance) tell_stance(page, v, d.nominal->model.tree, *d.stance, creeping);
  for (const Finding& f : v.findings) tell_finding(page, f);
  tell_scores(page, v);
  if (v.next_experiment) tell_next_experiment(page, v);
  tell_limits(page, v);
  tell_log(page, v, d.log);
  return page.finish();
}

/// What the library has against the first set of names that no motion tells apart; how much that
/// would tell nobody has simulated.
std::optional<NextExperiment> setting_for(const Verdict& v) {
  for (const Finding& f : v.findings) {
    if (f.one_of.size() < 2) continue;
    NextExperiment out;
    out.nats_per_second = out.seconds_to_100_to_1 = std::numeric_limits<double>::quiet_NaN();
    out.separates = f.one_of;
    for (const std::string& name : f.one_of) {
      const Effect* effect = find_effect(name);
      for (const Experiment& e : effect ? effect->experiments : std::vector<Experiment>{}) {
        if (e.kind == Experiment::Kind::motion || out.what.find(e.what) != std::string::npos)
          continue;
        out.what += (out.what.empty() ? "" : ", or ") + std::string(e.what);
      }
    }
    if (!out.what.empty()) return out;
  }
  return std::nullopt;
}

/// What to record next, into the verdict; returns the motion, where one decides anything.
std::optional<OwnFile> ask_for_more(WholeDiagnosis& d, const Settings& settings, bool kept,
                                    const Progress& progress) {
  Verdict& v = d.verdict;
  NextMotion next;
  if (d.apart) {
    progress("looks for a motion that tells what is undecided");
    next = next_motion(*d.apart, settings);
    if (!next.motion)
      v.notes.push_back(fmt::format("undecided: {}: {}", fmt::join(next.experiment.separates, ", "),
                                    next.why_not));
  }
  if (!next.motion) {
    v.next_experiment = setting_for(v);
    if (v.next_experiment) v.summary = plain_words(v) + d.proof;
    return std::nullopt;
  }
  v.next_experiment = next.experiment;
  OwnFile file{"motions/" + next.motion->name + ".toml", motion::to_toml(*next.motion)};
  if (kept) v.next_experiment->motion_file = file.path;
  v.summary = plain_words(v) + d.proof;
  return file;
}

Ending ending_of(WholeDiagnosis d, double creeping) {
  Ending out;
  out.text = whole_text(d.verdict);
  out.report = page_of(d, creeping);
  out.verdict = std::move(d.verdict);
  out.patched_body = std::move(d.patched);
  return out;
}

/// Nothing is kept of a run that was ended: it takes seconds.
Ending ended_early(double seconds) {
  WholeDiagnosis d;
  d.verdict.status = VerdictStatus::unfinished;
  d.verdict.unfinished = Unfinished{"what do pose, IMU and feet say?", seconds, 0.0};
  d.verdict.answer = fmt::format("Unfinished after {:.0f} s.", seconds);
  d.verdict.summary = plain_words(d.verdict);
  return ending_of(std::move(d), 0.0);
}

}  // namespace

int run_diagnose_whole(const DiagnoseOptions& options) {
  const WholeOptions whole = whole_options(options);
  const auto run = [&](const Progress& progress) {
    WholeDiagnosis d = diagnose_whole(whole, progress);
    std::optional<OwnFile> motion = ask_for_more(d, whole.settings, !options.out.empty(), progress);
    Ending out = ending_of(std::move(d), whole.settings.stance.creeping);
    out.motion = std::move(motion);
    return out;
  };
  return run_command(options, {run, ended_early});
}

}  // namespace sanso::diagnose
