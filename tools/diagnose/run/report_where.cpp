// Report: where simulation and recording part, and the shape of what is missing.
#include "tools/diagnose/run/report_sections.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/diagnose/model_folder/joint_units.h"

namespace sanso::diagnose {
namespace {

void add_map(report::HtmlPage& page, const Diagnosis& d) {
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
}

void add_error_over_time(report::HtmlPage& page, const Diagnosis& d) {
  report::LineChart strip{
      "error over time", "time, recordings one after the other [s]", "noise levels", {}};
  for (const std::size_t j : d.shown_joints) {
    for (const auto* m : {&d.before, &d.after}) {
      report::Series s;
      s.name = d.joints[j] + (m == &d.before ? ", nominal" : ", patched");
      s.dashed = m == &d.after;
      s.x = m->shot_time;
      for (double e : m->time_strip[j]) s.y.push_back(std::sqrt(e));
      strip.series.push_back(std::move(s));
    }
  }
  page.figure(svg(strip, {720, 240}));
}

void add_cells(report::HtmlPage& page, const Diagnosis& d) {
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

/// A curve with its band of two standard errors to either side.
void add_curve(report::LineChart& chart, const ShapeCurve& curve, const std::string& name,
               bool dashed) {
  report::Series middle{name, {}, {}, dashed, true};
  report::Ribbon band{{}, {}, {}, dashed ? "#e0b0c8" : "#a8cbe6"};
  for (const CurvePoint& p : curve.points) {
    middle.x.push_back(p.x), band.x.push_back(p.x);
    middle.y.push_back(p.mean), band.low.push_back(p.mean - 2 * p.error),
        band.high.push_back(p.mean + 2 * p.error);
  }
  chart.series.push_back(std::move(middle));
  chart.ribbons.push_back(std::move(band));
}

}  // namespace

report::LineChart curve_chart(const std::string& joint, bool slides, const ShapeCurve& before,
                              const std::vector<ShapeCurve>& all_after) {
  report::LineChart chart{joint + ": " + at_joint("missing torque", slides) + " against " +
                              at_joint(before.name, slides),
                          at_joint(before.name + " [" + before.x_unit + "]", slides),
                          at_joint("missing torque [N m]", slides),
                          {}};
  add_curve(chart, before, "nominal", false);
  for (const ShapeCurve& after : all_after) {
    if (after.name == before.name) add_curve(chart, after, "patched", true);
  }
  return chart;
}

void tell_where(report::HtmlPage& page, const Diagnosis& d) {
  page.heading("Where simulation and recording part");
  add_map(page, d);
  add_error_over_time(page, d);
  add_cells(page, d);
}

void tell_curves(report::HtmlPage& page, const Diagnosis& d) {
  page.heading("The shape of what is missing");
  page.paragraph(
      "Torque (force at a sliding joint) that the model lacks, window by window, against what the "
      "joint was doing; "
      "bands are two standard errors "
      "wide to either side. After the patch "
      "the curve should lie on zero.");
  for (std::size_t k = 0; k < d.shown_joints.size(); ++k) {
    const auto joint = d.shown_joints[k];
    for (const ShapeCurve& before : d.curves_before[k]) {
      const report::LineChart chart =
          curve_chart(d.joints[joint], d.slides[joint] != 0, before, d.curves_after[k]);
      page.figure(svg(chart, {720, 240}));
    }
  }
}

}  // namespace sanso::diagnose
