// Report of a base that floats: three pictures of what drives and links leave.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tools/diagnose/run/report_sections.h"
#include "tools/diagnose/verdict/predictability.h"

namespace sanso::diagnose {
namespace {

/// Squares of missing torque by joint, of joints that stand still and that move.
struct Missing {
  std::vector<double> squares[2], counts[2];
  explicit Missing(std::size_t joints) {
    for (auto* all : {squares, counts})
      for (int moves = 0; moves < 2; ++moves) all[moves].assign(joints, 0.0);
  }
  void add(const TorqueSample& s, double creeping) {
    const int moves = std::abs(s.dq) > creeping ? 1 : 0;
    squares[moves][s.joint] += s.missing * s.missing, counts[moves][s.joint] += 1.0;
  }
  /// RMS, N m; NaN where the joint is never so.
  double rms(std::size_t joint, int moves) const {
    const double n = counts[moves][joint];
    return n > 0.0 ? std::sqrt(squares[moves][joint] / n) : NAN;
  }
};

Missing missing_of(const std::vector<TorqueSample>& samples, std::size_t joints, double creeping) {
  Missing out(joints);
  for (const TorqueSample& s : samples) out.add(s, creeping);
  return out;
}

void add_map(report::HtmlPage& page, const StanceShown& shown, const RobotTree& tree,
             double creeping) {
  const std::size_t n = tree.size();
  const Missing nominal = missing_of(shown.nominal, n, creeping),
                patched = missing_of(shown.patched, n, creeping);
  report::HeatMap map;
  map.title = "where: torque that the model's drives lack (RMS)", map.unit = "N m";
  map.columns = {"still, nominal", "still, patched", "moving, nominal", "moving, patched"};
  for (std::size_t j = 0; j < n; ++j) {
    map.rows.push_back(tree.joints[j].name);
    map.values.push_back(
        {nominal.rms(j, 0), patched.rms(j, 0), nominal.rms(j, 1), patched.rms(j, 1)});
  }
  page.figure(svg(map, {720, 150 + 26 * static_cast<int>(n)}),
              "Joint by joint, as if all that is missing in a moment were missing there; where two "
              "feet stand, a torque at one joint also shows at others. Patched: with what the "
              "verdict names. An empty field: the joint never does that.");
}

void add_time(report::HtmlPage& page, const StanceShown& shown) {
  report::LineChart chart{"when: what drives and links leave",
                          "time, recordings one after the other [s]",
                          "deviations",
                          {},
                          {},
                          {},
                          {{1.0, "what readings and models are known by"}}};
  report::Series nominal{"nominal", {}, {}}, patched{"patched", {}, {}, true};
  double begin = 0.0, last = 0.0;
  std::size_t recording = 0;
  for (const StanceShown::Moment& m : shown.moments) {
    if (m.recording != recording) {
      for (report::Series* s : {&nominal, &patched})
        s->x.push_back(last), s->y.push_back(NAN);  // pen up
      begin = last, recording = m.recording;
    }
    last = begin + m.t;
    nominal.x.push_back(last), nominal.y.push_back(m.nominal);
    patched.x.push_back(last), patched.y.push_back(m.patched);
  }
  chart.series = {std::move(nominal), std::move(patched)};
  page.figure(svg(chart, {720, 240}),
              "Moment by moment, all balances together. Patched still has all in it that a nominal "
              "model may be wrong by, which fits take up and no name is needed for.");
}

/// Of the joints that the verdict lights, that which lacks most; of all, where it lights none.
std::size_t telling_joint(const Verdict& v, const RobotTree& tree, const StanceShown& shown) {
  std::set<std::string> lit;
  for (const Finding& f : v.findings) lit.insert(f.where.begin(), f.where.end());
  std::vector<double> squares(tree.size(), 0.0);
  for (const TorqueSample& s : shown.nominal) squares[s.joint] += s.missing * s.missing;
  const bool any = std::any_of(tree.joints.begin(), tree.joints.end(),
                               [&](const TreeJoint& j) { return lit.contains(j.name); });
  std::size_t best = tree.size();
  for (std::size_t j = 0; j < tree.size(); ++j) {
    if (any && !lit.contains(tree.joints[j].name)) continue;
    if (best == tree.size() || squares[j] > squares[best]) best = j;
  }
  return best;
}

/// The quantity that says most of what a joint lacks.
void add_shape(report::HtmlPage& page, const Verdict& v, const StanceShown& shown,
               const RobotTree& tree) {
  const std::size_t joint = telling_joint(v, tree, shown);
  std::vector<ShapeCurve> curves = shape_curves(shown.nominal, joint);
  std::erase_if(curves, [](const ShapeCurve& c) { return c.name == "time"; });
  const auto best = std::max_element(
      curves.begin(), curves.end(),
      [](const ShapeCurve& a, const ShapeCurve& b) { return a.explained < b.explained; });
  if (best == curves.end()) return;
  page.figure(svg(curve_chart(tree.joints[joint].name, tree.joints[joint].prismatic, *best,
                              shape_curves(shown.patched, joint)),
                  {720, 240}),
              fmt::format("The shape of what is missing: of speed, position, motor torque and "
                          "tracking error, {} says most of it ({:.0f} %). Bands are two standard "
                          "errors wide to either side; patched, the curve should lie on zero.",
                          best->name, 100 * best->explained));
}

}  // namespace

void tell_stance(report::HtmlPage& page, const Verdict& v, const RobotTree& tree,
                 const StanceShown& shown, double creeping) {
  if (shown.moments.empty()) return;
  page.heading("Where, when and how drives and motion disagree");
  add_map(page, shown, tree, creeping);
  add_time(page, shown);
  add_shape(page, v, shown, tree);
}

}  // namespace sanso::diagnose
