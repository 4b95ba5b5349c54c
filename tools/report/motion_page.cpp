// Plays the primitives, then draws what they ask for; nothing here runs a robot.
#include "tools/report/motion_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/motion/make/balance.h"
#include "host/motion/make/body_kinematics.h"
#include "host/motion/make/retarget.h"
#include "shared/model/joints.h"
#include "tools/report/html.h"

namespace sanso::report {
namespace {

using motion::BodyPoints;
using motion::kLeft;
using motion::kRight;
using motion::Trajectory;

constexpr double kDegree = M_PI / 180.0;
const char* const kSideColour[2] = {"#d55e00", "#0072b2"};  // right, left

/// One leg as a polyline; `lateral` looks from the front, else from the right side.
std::string leg_line(const BodyPoints& points, int side, bool lateral, double centre_px,
                     double origin, double scale) {
  std::string line;
  const auto add = [&](const math::Vec3& p) {
    const double across = lateral ? -(p.y() - origin) : p.x() - origin;
    line += fmt::format("{:.1f},{:.1f} ", centre_px + scale * across, 150.0 - scale * p.z());
  };
  for (std::size_t k : {0u, 2u, 3u, 4u}) add(points.leg[side][k]);
  if (lateral) {
    add(points.p_world_foot[side] + math::Vec3(0, 0, model::kSoleHeight));
  } else {
    const auto corners = points.sole_corners(side);
    add(corners[1]);
    add(corners[0]);
  }
  return fmt::format("<polyline points='{}' fill='none' stroke='{}' stroke-width='2'/>", line,
                     kSideColour[side]);
}

/// Twelve moments, evenly spaced over the motion, each drawn about its own base.
std::string stick_figures(const Trajectory& trajectory, bool lateral) {
  constexpr int kFigures = 12;
  constexpr double kPitch_px = 74, kScale = 420;  // px, px per m
  std::string svg_text = fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' width='{0}' height='176' viewBox='0 0 {0} 176'>"
      "<line x1='0' y1='150' x2='{0}' y2='150' stroke='#888888'/>",
      kFigures * kPitch_px);
  for (int i = 0; i < kFigures; ++i) {
    const std::size_t k = static_cast<std::size_t>(i) * (trajectory.x.size() - 1) / (kFigures - 1);
    const model::State& x = trajectory.x[k];
    const BodyPoints points = motion::body_points(x);
    const double centre = (i + 0.5) * kPitch_px, origin = lateral ? x[1] : x[0];
    svg_text += fmt::format("<circle cx='{:.1f}' cy='{:.1f}' r='5' fill='#333333'/>", centre,
                            150.0 - kScale * x[2]);
    for (int side : {kRight, kLeft})
      svg_text += leg_line(points, side, lateral, centre, origin, kScale);
    svg_text += fmt::format(
        "<text x='{:.1f}' y='168' font-size='11' text-anchor='middle' fill='#555555'>{:.1f} "
        "s</text>",
        centre, static_cast<double>(k) * trajectory.dt_s);
  }
  return svg_text + "</svg>";
}

template <class Value>
Series over_time(const std::string& name, const Trajectory& trajectory, Value&& value) {
  Series series{name, {}, {}};
  for (std::size_t k = 0; k < trajectory.x.size(); ++k) {
    series.x.push_back(static_cast<double>(k) * trajectory.dt_s);
    series.y.push_back(value(k));
  }
  return series;
}

std::string joint_chart(const Trajectory& trajectory, int offset, double unit,
                        const std::string& title, const std::string& label) {
  LineChart chart{title, "time [s]", label, {}};
  for (int j = 0; j < model::kNumJoints; ++j) {
    chart.series.push_back(over_time(model::kJoints[j].name, trajectory, [&](std::size_t k) {
      return trajectory.x[k][offset + j] / unit;
    }));
  }
  return svg(chart);
}

std::string zmp_chart(const Trajectory& trajectory, int axis) {
  const auto zmp = motion::zmp_of(trajectory);
  const std::string name = axis == 0 ? "x" : "y";
  LineChart chart{"ground plan along " + name, "time [s]", name + " [mm]", {}};
  chart.series.push_back(
      over_time("base", trajectory, [&](std::size_t k) { return 1e3 * trajectory.x[k][axis]; }));
  chart.series.push_back(over_time(
      "ZMP", trajectory, [&](std::size_t k) { return 1e3 * (axis == 0 ? zmp[k].x : zmp[k].y); }));
  for (int side : {kRight, kLeft}) {
    for (const auto& [corner, edge] : {std::pair{0, axis == 0 ? "front" : "outer"},
                                       std::pair{2, axis == 0 ? "back" : "inner"}}) {
      Series series =
          over_time(fmt::format("{} sole, {} edge", side == kLeft ? "left" : "right", edge),
                    trajectory, [&, c = corner](std::size_t k) {
                      const auto point = motion::body_points(trajectory.x[k]).sole_corners(side)[c];
                      return point.z() < 0.001 ? 1e3 * point[axis] : std::nan("");
                    });
      series.dashed = true;
      series.colour = kSideColour[side];
      chart.series.push_back(series);
    }
  }
  return svg(chart);
}

std::string height_chart(const Trajectory& trajectory) {
  LineChart chart{"heights", "time [s]", "height [mm]", {}};
  for (int side : {kRight, kLeft}) {
    chart.series.push_back(
        over_time(side == kLeft ? "left sole" : "right sole", trajectory, [&](std::size_t k) {
          return 1e3 *
                 (motion::body_points(trajectory.x[k]).p_world_foot[side].z() + model::kSoleHeight);
        }));
  }
  const double standing = trajectory.x.front()[2];
  chart.series.push_back(over_time("base, above its lowest", trajectory, [&](std::size_t k) {
    double lowest = standing;
    for (const auto& x : trajectory.x) lowest = std::min(lowest, x[2]);
    return 1e3 * (trajectory.x[k][2] - lowest);
  }));
  return svg(chart);
}

Table clause_table(const motion::Motion& m) {
  Table table{{"measure", "at least", "at most"}, {}};
  for (const auto& clause : m.success) {
    table.rows.push_back({clause.measure,
                          clause.at_least ? fmt::format("{}", *clause.at_least) : "",
                          clause.at_most ? fmt::format("{}", *clause.at_most) : ""});
  }
  return table;
}

}  // namespace

std::string motion_page(const motion::Motion& m) {
  const Trajectory reference = m.reference();
  HtmlPage page("Motion " + m.name);
  page.paragraph(m.title + fmt::format(". {:.2f} s, {} basis functions per degree of freedom.",
                                       m.duration_s(), m.primitives.num_basis));
  page.paragraph("Clip: " + m.recipe.clip + ". " + m.source.credit + "; " + m.source.licence +
                 "; " + m.source.changes + ".");
  page.figure(stick_figures(reference, false),
              "from the right side; orange right leg, blue left leg");
  page.figure(stick_figures(reference, true), "from the front");
  page.heading("Joints");
  page.figure(joint_chart(reference, model::kXJoint, kDegree, "joint angles", "angle [deg]"));
  page.figure(joint_chart(reference, model::kXJointRate, 1.0, "joint rates", "rate [rad/s]"),
              fmt::format("the servo allows {} rad/s without load", motion::kMaxReferenceSpeed));
  page.heading("Balance");
  page.figure(zmp_chart(reference, 0));
  page.figure(zmp_chart(reference, 1),
              "the ZMP of all bodies has to stay between the edges of the soles that are down");
  page.figure(height_chart(reference));
  page.heading("Success");
  page.table(clause_table(m));
  return page.finish();
}

}  // namespace sanso::report
