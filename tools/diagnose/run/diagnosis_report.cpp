#include "tools/diagnose/run/diagnosis_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "tools/diagnose/effects/effect.h"
#include "tools/diagnose/model_folder/joint_units.h"
#include "tools/report/html.h"

namespace sanso::diagnose {
namespace {

std::string joined(const std::vector<std::string>& parts, const char* empty) {
  std::string text;
  for (const std::string& p : parts) text += (text.empty() ? "" : ", ") + p;
  return text.empty() ? empty : text;
}

/// The library's name of an effect in words, with the id that model.toml and verdict.json use.
std::string in_words(const std::string& id) {
  const Effect* effect = find_effect(id);
  return effect == nullptr ? id : std::string(effect->name) + " (" + id + ")";
}

const char* meaning(VerdictStatus status) {
  switch (status) {
    case VerdictStatus::confirmed:
      return "Every name below passed every gate: it predicts data that were not fitted, its "
             "rivals do not, and what "
             "it promised happened.";
    case VerdictStatus::one_of:
      return "Something is missing for certain. Where a set is given, these data cannot tell its "
             "members apart; see "
             "what to record next.";
    case VerdictStatus::present_unnamed:
      return "Something is missing that the names below explain in part or not at all. Read the "
             "shape curves.";
    case VerdictStatus::absent:
      return "Nothing stands out of noise and of what a nominal model may be wrong by. The end of "
             "the page lists how "
             "small an effect would have been seen.";
    case VerdictStatus::refused:
      return "The recordings are broken. Nothing was fitted.";
  }
  return "";
}

/// Unit of an error over all joints.
std::string position_unit(const Diagnosis& d) {
  const auto sliding =
      std::count_if(d.slides.begin(), d.slides.end(), [](char s) { return s != 0; });
  if (sliding == 0) return "rad";
  return sliding == static_cast<std::ptrdiff_t>(d.slides.size()) ? "m"
                                                                 : "rad (m at sliding joints)";
}

bool slides_of(const Diagnosis& d, const std::string& joint) {
  const auto at = std::find(d.joints.begin(), d.joints.end(), joint) - d.joints.begin();
  return static_cast<std::size_t>(at) < d.slides.size() &&
         d.slides[static_cast<std::size_t>(at)] != 0;
}

/// The answer in figures: error on held-out data before and after, at the shortest horizon of half
/// a second or more.
void add_summary(report::HtmlPage& page, const Diagnosis& d) {
  const Verdict& v = d.verdict;
  page.paragraph(meaning(v.status));
  for (const char* horizon : {"0.5", "2"}) {
    const auto at = v.heldout.find(horizon);
    if (at == v.heldout.end() || !at->second.contains("all")) continue;
    const FitScore& s = at->second.at("all");
    page.paragraph(fmt::format(
        "On recordings that were not fitted, {} s ahead, the error {} from {:.3g} to {:.3g} {} "
        "(measurement noise "
        "{:.2g}): {:.0f} % of the error beyond noise is explained.",
        horizon, s.patched < s.nominal ? "falls" : "goes", s.nominal, s.patched, position_unit(d),
        s.noise, 100 * s.explained()));
    return;
  }
}

void add_refusal(report::HtmlPage& page, const Verdict& v) {
  report::Table table{{"file", "channel", "row", "defect", "what was seen"}, {}};
  for (const Defect& d : v.refused) {
    table.rows.push_back(
        {d.file, d.channel, d.row >= 0 ? std::to_string(d.row) : "all", d.defect, d.message});
  }
  page.heading("Why these data cannot be used");
  page.table(table);
}

void add_where(report::HtmlPage& page, const Diagnosis& d) {
  page.heading("Where simulation and recording part");
  report::HeatMap map;
  map.title = "prediction error of the nominal model, shots from the measured state (RMS)";
  map.unit = "noise levels";
  map.rows = d.joints;
  for (std::size_t g = 0; g < d.regimes.size(); ++g) {
    bool any = false;
    for (const auto& row : d.before.heat) any |= std::isfinite(row[g]);
    if (!any) continue;
    map.columns.push_back(d.regimes[g]);
    for (std::size_t j = 0; j < d.joints.size(); ++j) {
      map.values.resize(d.joints.size());
      map.values[j].push_back(std::sqrt(d.before.heat[j][g]));
    }
  }
  if (!map.columns.empty()) {
    page.figure(svg(map, {std::max(720, 84 * static_cast<int>(map.columns.size()) + 140),
                          150 + 26 * static_cast<int>(d.joints.size())}),
                "Joint by regime. An empty field: the recordings hold no such moments.");
  }
  report::LineChart strip{
      "error over time", "time, recordings one after the other [s]", "noise levels", {}};
  for (const int j : d.shown_joints) {
    for (const auto* m : {&d.before, &d.after}) {
      report::Series s;
      s.name = d.joints[static_cast<std::size_t>(j)] + (m == &d.before ? ", nominal" : ", patched");
      s.dashed = m == &d.after;
      s.x = m->shot_time;
      for (double e : m->time_strip[static_cast<std::size_t>(j)]) s.y.push_back(std::sqrt(e));
      strip.series.push_back(std::move(s));
    }
  }
  page.figure(svg(strip, {720, 240}));
  report::Table table{{"joint", "regime", "share of the error", "lift", "q"}, {}};
  for (const LocationCell& c : d.verdict.locations) {
    if (table.rows.size() >= 8 || c.q_value > 0.05) break;
    table.rows.push_back({c.where, c.regime, fmt::format("{:.0f} %", 100 * c.share),
                          fmt::format("{:.1f}", c.lift), fmt::format("{:.2g}", c.q_value)});
  }
  if (!table.rows.empty()) {
    page.paragraph(
        "Cells in which the error is larger than elsewhere. Lift: error energy a row in the cell "
        "over that outside it; "
        "q: "
        "expected share of false alarms among the cells down to this one (listed up to 5 %).");
    page.table(table);
  }
}

void add_finding(report::HtmlPage& page, const Finding& f) {
  page.heading("Why " + in_words(f.effect) + " at " + joined(f.where, "the whole robot") +
               ", and not its rivals");
  page.paragraph(fmt::format(
      "Removes {:.0f} % (standard error {:.0f} %) of the whole prediction error on held-out data; "
      "family-wise p = {:.3g}; "
      "shows most: {}.",
      100 * f.heldout_gain, 100 * f.heldout_gain_se, f.p_family, f.regime));
  report::Table parameters{{"parameter", "value", "95 % interval", "unit"}, {}};
  for (const auto& [name, p] : f.parameters) {
    parameters.rows.push_back({name, fmt::format("{:.4g}", p.value),
                               p.low == p.high ? "fixed by the form"
                                               : fmt::format("{:.4g} to {:.4g}", p.low, p.high) +
                                                     (p.at_bound ? ", at the bound" : ""),
                               p.unit});
  }
  page.table(parameters);
  report::Table promised{
      {"what it promised to change", "size, noise levels", "share that happened", "95 % interval"},
      {}};
  for (const IncidenceRow& row : f.incidence) {
    promised.rows.push_back({row.residual, fmt::format("{:.0f}", row.predicted),
                             fmt::format("{:.0f} %", 100 * row.slope),
                             fmt::format("{:.0f} to {:.0f} %", 100 * row.low, 100 * row.high)});
  }
  page.paragraph(
      "An explanation is refuted when a change that it promises did not happen (interval below 50 "
      "%) or happened twice "
      "over.");
  page.table(promised);
  report::Table rivals{{"rival", "where", "held-out gain", "behind, standard errors",
                        "similar signature", "what it said wrong"},
                       {}};
  for (const Rival& r : f.rivals) {
    rivals.rows.push_back(
        {r.effect, joined(r.where, "robot"), fmt::format("{:.0f} %", 100 * r.heldout_gain),
         fmt::format("{:.1f}", r.behind_in_se), fmt::format("{:.2f}", r.similarity),
         r.said_wrong.empty() ? "nothing that these data show" : r.said_wrong});
  }
  if (!rivals.rows.empty()) page.table(rivals);
}

void add_curves(report::HtmlPage& page, const Diagnosis& d) {
  page.heading("The shape of what is missing");
  page.paragraph(
      "Torque (force at a sliding joint) that the model lacks, window by window, against what the "
      "joint was doing; "
      "bands are two standard errors "
      "wide to either side. After the patch "
      "the curve should lie on zero.");
  for (std::size_t k = 0; k < d.shown_joints.size(); ++k) {
    const auto joint = static_cast<std::size_t>(d.shown_joints[k]);
    const bool slides = d.slides[joint] != 0;
    for (const ShapeCurve& before : d.curves_before[k]) {
      report::LineChart chart{d.joints[joint] + ": " + at_joint("missing torque", slides) +
                                  " against " + at_joint(before.name, slides),
                              at_joint(before.name + " [" + before.x_unit + "]", slides),
                              at_joint("missing torque [N m]", slides),
                              {}};
      const auto add = [&](const ShapeCurve& curve, const std::string& name, bool dashed) {
        report::Series middle{name, {}, {}, dashed, true};
        report::Ribbon band{{}, {}, {}, dashed ? "#e0b0c8" : "#a8cbe6"};
        for (const CurvePoint& p : curve.points) {
          middle.x.push_back(p.x), band.x.push_back(p.x);
          middle.y.push_back(p.mean), band.low.push_back(p.mean - 2 * p.error),
              band.high.push_back(p.mean + 2 * p.error);
        }
        chart.series.push_back(std::move(middle));
        chart.ribbons.push_back(std::move(band));
      };
      add(before, "nominal", false);
      for (const ShapeCurve& after : d.curves_after[k]) {
        if (after.name == before.name) add(after, "patched", true);
      }
      page.figure(svg(chart, {720, 240}));
    }
  }
}

void add_proof(report::HtmlPage& page, const Diagnosis& d) {
  page.heading("Proof on data that were not fitted: " +
               joined(d.verdict.heldout_recordings, "none"));
  report::Table table{
      {"horizon", "position of", "nominal", "patched", "noise", "unit", "explained"}, {}};
  for (const auto& [horizon, scores] : d.verdict.heldout) {
    for (const auto& [channel, s] : scores) {
      const bool all = channel == "all";
      const std::string joint = all ? "all joints" : channel.substr(channel.find(':') + 1);
      table.rows.push_back({horizon + " s", joint, fmt::format("{:.4g}", s.nominal),
                            fmt::format("{:.4g}", s.patched), fmt::format("{:.2g}", s.noise),
                            all ? position_unit(d) : at_joint("rad", slides_of(d, joint)),
                            fmt::format("{:.0f} %", 100 * s.explained())});
    }
  }
  page.table(table);
  for (const RollOut& r : d.roll_outs) {
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
}

void add_limits(report::HtmlPage& page, const Verdict& v) {
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

/// How what is left shows, in words.
std::string what_is_left(const Unexplained& u) {
  if (u.channel == "torque") {
    return fmt::format(
        "{:.0f} % of the remaining missing torque can be predicted from the joint's state on data "
        "not used (p = "
        "{:.3g}).",
        100 * u.predictable, u.p);
  }
  if (u.channel == "velocity channel") {
    return fmt::format(
        "The velocity channel tells another motion than the position channel: {:.0f} % of the "
        "difference can be "
        "predicted from the "
        "joint's state (p = {:.3g}).",
        100 * u.predictable, u.p);
  }
  if (u.channel == "stretches")
    return "Errors far above noise stand alone in the stretches below, and they repeat.";
  return "The position error is more than noise, or what describes it is not confirmed.";
}

void add_unexplained(report::HtmlPage& page, const Verdict& v) {
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
  if (v.stretches.empty()) return;
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

void add_next(report::HtmlPage& page, const Verdict& v) {
  page.heading("What to record next");
  if (!v.next_experiment) {
    page.paragraph("Nothing is open that a further recording of the menu would decide.");
    return;
  }
  const NextExperiment& e = *v.next_experiment;
  page.paragraph(e.what);
  page.paragraph(
      fmt::format("Separates {}; expected {:.3g} nats a second, {:.3g} s to odds of 100 to 1.",
                  joined(e.separates, "the candidates"), e.nats_per_second, e.seconds_to_100_to_1));
}

}  // namespace

std::string diagnosis_report(const Diagnosis& d) {
  const Verdict& v = d.verdict;
  report::HtmlPage page("Diagnosis: simulation versus recording");
  page.paragraph(
      "Question: where do simulation and recording part, what physics is missing, and does adding "
      "it help on data not "
      "used?");
  page.answer(fmt::format("{}: {}", to_string(v.status), v.answer),
              v.status == VerdictStatus::absent);
  add_summary(page, d);
  if (v.status == VerdictStatus::refused) {
    add_refusal(page, v);
    return page.finish();
  }
  add_where(page, d);
  for (const Finding& f : v.findings) add_finding(page, f);
  add_curves(page, d);
  add_proof(page, d);
  add_unexplained(page, v);
  add_next(page, v);
  add_limits(page, v);
  page.heading("How it was found");
  std::string log;
  for (const std::string& line : d.log) log += line + "\n";
  page.code(log);
  for (const std::string& note : v.notes) page.paragraph("Note: " + note);
  return page.finish();
}

}  // namespace sanso::diagnose
