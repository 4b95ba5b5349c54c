// Report: the proof on data that were not fitted, what stays open, and the limits of the answer.
#include "tools/diagnose/run/report_sections.h"

#include <fmt/format.h>

#include <filesystem>

#include "tools/diagnose/model_folder/joint_units.h"
#include "tools/diagnose/run/report_words.h"

namespace sanso::diagnose {
namespace {

void add_scores(report::HtmlPage& page, const Diagnosis& d) {
  report::Table table{{"horizon", "position of", "nominal", "as it went", "named", "patched",
                       "noise", "unit", "explained"},
                      {}};
  for (const auto& [horizon, scores] : d.verdict.heldout) {
    const auto add = [&, &at = horizon](const std::string& of, const FitScore& s,
                                        const std::string& unit) {
      table.rows.push_back({at.text() + " s", of, fmt::format("{:.4g}", s.nominal),
                            fmt::format("{:.4g}", s.baseline), fmt::format("{:.4g}", s.named),
                            fmt::format("{:.4g}", s.patched), fmt::format("{:.2g}", s.noise), unit,
                            fmt::format("{:.0f} %", 100 * s.explained())});
    };
    if (scores.all) add("all joints", *scores.all, position_unit(d));
    for (const auto& [channel, s] : scores.channels) {
      const std::string joint = channel.substr(channel.find(':') + 1);
      add(joint, s, at_joint("rad", slides_of(d, joint)));
    }
  }
  page.paragraph(
      "As it went: the joint goes on at the speed that it had; a model that does not beat it "
      "predicts nothing. Named: with the effects alone that are confirmed, or one of a set.");
  page.table(table);
}

void add_roll_out(report::HtmlPage& page, const Diagnosis& d, const RollOut& r) {
  report::LineChart chart{r.joint + " in " + std::filesystem::path(r.recording).stem().string() +
                              ", restarted every 2 s",
                          "time [s]",
                          at_joint("position [rad]", slides_of(d, r.joint)),
                          {}};
  report::Ribbon noise{r.t, r.measured, r.measured, "#bbbbbb"};
  for (std::size_t k = 0; k < r.t.size(); ++k)
    noise.low[k] -= 2 * r.noise, noise.high[k] += 2 * r.noise;
  chart.ribbons.push_back(std::move(noise));
  chart.series.push_back({"measured", r.t, r.measured});
  chart.series.push_back({"nominal", r.t, r.nominal, true});
  chart.series.push_back({"patched", r.t, r.patched, true});
  page.figure(
      svg(chart, {720, 260}),
      fmt::format("Grey band: two standard deviations of the measurement noise ({:.2g} {}).",
                  r.noise, at_joint("rad", slides_of(d, r.joint))));
}

/// How what is left shows, in words.
std::string what_is_left(const Unexplained& u) {
  switch (u.shows_in) {
    case ShowsIn::torque:
      return fmt::format(
          "{:.0f} % of the remaining missing torque can be predicted from the joint's state on "
          "data not used (p = {:.3g}).",
          100 * u.predictable, u.p);
    case ShowsIn::velocity_channel:
      return fmt::format(
          "The velocity channel tells another motion than the position channel: {:.0f} % of the "
          "difference can be predicted from the joint's state (p = {:.3g}).",
          100 * u.predictable, u.p);
    case ShowsIn::stretches:
      return "Errors far above noise stand alone in the stretches below, and they repeat.";
    case ShowsIn::position:
      break;
  }
  return "The position error is more than noise, or what describes it is not confirmed.";
}

void add_stretches(report::HtmlPage& page, const Verdict& v) {
  constexpr std::size_t kRows = 20;
  report::Table table{{"recording", "joint", "from, s", "until, s", "position error, noise levels"},
                      {}};
  for (const Stretch& s : v.stretches) {
    if (table.rows.size() == kRows) break;
    table.rows.push_back({s.recording, s.where, fmt::format("{:.2f}", s.from),
                          fmt::format("{:.2f}", s.until), fmt::format("{:.1f}", s.level)});
  }
  page.heading("Stretches that the last model misses");
  page.paragraph(fmt::format(
      "One shot each, at least three times the joint's usual error: a blow, a breakaway, a lost "
      "command. A single one "
      "is taken for an accident. The strongest {} of {}.",
      table.rows.size(), v.stretches.size()));
  page.table(table);
}

}  // namespace

void tell_proof(report::HtmlPage& page, const Diagnosis& d) {
  page.heading("Proof on data that were not fitted: " +
               joined(d.verdict.heldout_recordings, "none"));
  add_scores(page, d);
  for (const RollOut& r : d.roll_outs) add_roll_out(page, d, r);
}

void tell_unexplained(report::HtmlPage& page, const Verdict& v) {
  if (v.unexplained) {
    const Unexplained& u = *v.unexplained;
    page.heading("What stays without a name");
    page.paragraph(fmt::format(
        "At {}: {} {:.0f} % of the first model's error beyond noise is still there. {}. Nearest "
        "name of "
        "the library: {} (a "
        "hint, not a finding). A formula describes the shape; it is no diagnosis.",
        u.where, what_is_left(u), 100 * u.energy_share,
        u.formula.empty() ? "No short formula pays" : u.formula, u.nearest_effect));
  }
  if (!v.stretches.empty()) add_stretches(page, v);
}

void tell_next_experiment(report::HtmlPage& page, const Verdict& v) {
  page.heading("What to record next");
  if (!v.next_experiment) {
    page.paragraph("Nothing is open that a further recording of the menu would decide.");
    return;
  }
  const NextExperiment& e = *v.next_experiment;
  page.paragraph(e.what);
  std::string text = "Separates " + joined(e.separates, "the candidates");
  if (std::isfinite(e.nats_per_second))
    text += fmt::format("; expected {:.3g} nats a second, {:.3g} s to odds of 100 to 1",
                        e.nats_per_second, e.seconds_to_100_to_1);
  page.paragraph(text + ".");
  if (!e.motion_file.empty()) page.paragraph("Motion to run: " + e.motion_file);
}

void tell_limits(report::HtmlPage& page, const Verdict& v) {
  page.heading("What could not be tested, and how small it would have been seen");
  report::Table untestable{{"effect", "because"}, {}};
  for (const Untestable& u : v.untestable) untestable.rows.push_back({u.effect, u.because});
  if (!untestable.rows.empty()) page.table(untestable);
  report::Table sizes{{"effect", "where", "smallest size that would have been seen"}, {}};
  for (const Detectable& s : v.detectable) {
    if (sizes.rows.size() < 80)
      sizes.rows.push_back(
          {s.effect, s.where, fmt::format("{} {:.3g} {}", s.parameter, s.size, s.unit)});
  }
  if (!sizes.rows.empty()) {
    page.paragraph("80 % power at the family-wise level of 1 %, linear in the size.");
    page.table(sizes);
  }
}

void tell_log(report::HtmlPage& page, const Verdict& v, const std::vector<std::string>& log) {
  page.heading("How it was found");
  std::string text;
  for (const std::string& line : log) text += line + "\n";
  page.code(text);
  for (const std::string& note : v.notes) page.paragraph("Note: " + note);
}

}  // namespace sanso::diagnose
