// Key poses become smooth paths of trunk and weight, steps the same plan of footsteps that clips
// give; body, checks and primitives are those of the import.
#include "host/motion/make/compose.h"

#include <algorithm>
#include <cmath>

#include "host/motion/catalogue.h"
#include "host/motion/dmp_fit.h"
#include "host/motion/make/footsteps.h"
#include "host/motion/make/leg_ik.h"
#include "host/motion/make/minimum_jerk.h"
#include "shared/base/time.h"
#include "shared/files/toml.h"

namespace sanso::motion {

const char* const kExampleRecipe =
    R"(# A motion to be: what trunk and feet do, and when. `sanso motions new FILE --as NAME`
# checks it before anything moves and writes the motion with a page to look at.
format = 1
title = "Deep bow of the knees, then a step forwards"
like = "walk_forward"       # whose cost, stop rule and success clauses it has; in place: "squat"
speed = 1.0                 # 0.5: all of it takes twice as long
stand_s = 1.0               # standing before and after

[[pose]]                    # reached at this time, at rest; between two poses the way is smooth
at_s = 1.2
height_m = -0.03            # of the trunk, from standing
# forward_m, left_m         # of the weight, from between the soles; only without steps

[[pose]]
at_s = 2.4                  # the last pose has to be standing again

[[step]]
foot = "right"
lift_s = 3.2
land_s = 3.8
forward_m = 0.04            # where it lands, from where it stood
left_m = 0.0

[[step]]
foot = "left"
lift_s = 4.2
land_s = 4.8
forward_m = 0.04
)";

namespace {

using files::TomlTable;

constexpr double kLongest_s = 30.0;
constexpr double kLeastSupport_s = 0.1;  // both feet down between two swings

struct KeyPose {
  double at_s = 0.0, height_m = 0.0;
  Eigen::Vector2d weight{0, 0};
  bool standing() const { return height_m == 0.0 && weight.isZero(); }
};

struct Composition {
  std::string title, like;
  double speed = 1.0, stand_s = 1.0, kappa = 0.93;
  std::vector<KeyPose> poses;
  StepPlan plan;
  double end_s = 0.0;  // of the moving part
};

double need(const TomlTable& table, std::string_view key, double low, double high) {
  return table.need(key, table.number(key, low, high),
                    "a number from " + files::toml_number(low) + " to " + files::toml_number(high));
}

void read_poses(const TomlTable& root, Composition& c, bool steps) {
  c.poses.push_back({});
  for (const TomlTable& entry : root.tables("pose")) {
    KeyPose pose{need(entry, "at_s", 0.05, kLongest_s), 0.0, {0, 0}};
    if (pose.at_s <= c.poses.back().at_s)
      entry.fail("at_s", "not later than the pose before", files::toml_number(pose.at_s),
                 "more than " + files::toml_number(c.poses.back().at_s));
    TomlTable::into(pose.height_m, entry.number("height_m", -0.12, 0.03));
    TomlTable::into(pose.weight.x(), entry.number("forward_m", -0.05, 0.05));
    TomlTable::into(pose.weight.y(), entry.number("left_m", -0.08, 0.08));
    if (steps && !pose.weight.isZero())
      entry.fail("at_s", "a shift of the weight beside steps", "",
                 "no forward_m and left_m: the steps say where the weight is");
    entry.finish();
    c.poses.push_back(pose);
  }
  if (!c.poses.back().standing())
    root.fail("pose", "the last pose is not standing", "",
              "a last [[pose]] with at_s alone: the robot ends as it began");
  c.end_s = c.poses.back().at_s;
}

void read_steps(const TomlTable& root, Composition& c) {
  std::array<Eigen::Vector2d, 2> at;
  for (int side : {kRight, kLeft})
    at[side] = c.plan.start[side] = {0.0, side_sign(side) * LegGeometry::kHipY};
  double free_s = kTransfer_s;
  for (const TomlTable& entry : root.tables("step")) {
    const auto foot =
        entry.need("foot", entry.choice("foot", {"right", "left"}), "\"right\" or \"left\"");
    Swing swing;
    swing.side = foot == 0 ? kRight : kLeft;
    swing.lift_s = need(entry, "lift_s", 0.0, kLongest_s);
    if (swing.lift_s < free_s)
      entry.fail("lift_s", "too early", files::toml_number(swing.lift_s),
                 "at least " + files::toml_number(free_s) +
                     ": the weight has to go over the other foot first");
    swing.land_s = need(entry, "land_s", swing.lift_s + 0.1, kLongest_s);
    Eigen::Vector2d ahead{0, 0};
    TomlTable::into(ahead.x(), entry.number("forward_m", -0.2, 0.2));
    TomlTable::into(ahead.y(), entry.number("left_m", -0.2, 0.2));
    entry.finish();
    swing.from = at[swing.side];
    swing.to = at[swing.side] += ahead;
    free_s = swing.land_s + kLeastSupport_s;
    c.plan.swings.push_back(swing);
  }
  if (c.plan.swings.empty()) return;
  c.end_s = std::max(c.end_s, c.plan.swings.back().land_s + kTransfer_s);
}

Composition read_composition(const TomlTable& root) {
  Composition c;
  if (root.need("format", root.integer("format"), "format = 1") != 1)
    root.fail("format", "another format", "", "1: this program reads format 1");
  c.title = root.need("title", root.string("title"), "what it is, in a few words");
  c.like = root.need("like", root.string("like"), "the name of a shipped motion");
  TomlTable::into(c.speed, root.number("speed", 0.1, 4.0));
  TomlTable::into(c.stand_s, root.number("stand_s", 0.5, 5.0));
  TomlTable::into(c.kappa, root.number("kappa", 0.7, 0.98));
  c.plan.swing_height_m = 0.032;
  c.plan.swing_sharpness = 2.0;
  c.plan.swing_dwell = 0.15;
  TomlTable::into(c.plan.swing_height_m, root.number("swing_height_m", 0.01, 0.08));
  read_poses(root, c, !root.tables("step").empty());
  read_steps(root, c);
  root.finish();
  if (c.end_s <= 0.0) root.fail("pose", "nothing moves", "", "at least one [[pose]] or [[step]]");
  return c;
}

/// On the way from one key pose to the next, at rest in each.
KeyPose pose_at(const std::vector<KeyPose>& poses, double t) {
  std::size_t k = 1;
  while (k < poses.size() && poses[k].at_s < t) ++k;
  if (k >= poses.size()) return poses.back();
  const KeyPose &a = poses[k - 1], &b = poses[k];
  const double u = minimum_jerk((t - a.at_s) / (b.at_s - a.at_s));
  return {t, a.height_m + u * (b.height_m - a.height_m), a.weight + u * (b.weight - a.weight)};
}

BodyTarget target_of(const Composition& c) {
  BodyTarget target;
  target.ground_is_com = c.plan.swings.empty();
  const double standing =
      c.kappa * LegGeometry::kLength + LegGeometry::kSoleBelowAnkle - LegGeometry::kHipZ;
  const int ticks =
      static_cast<int>(std::ceil((2.0 * c.stand_s + c.end_s / c.speed) / (10 * kTick_s))) * 10;
  StepPlan plan = c.plan;
  plan.duration_s = c.end_s;
  for (int k = 0; k <= ticks; ++k) {
    const double t = std::max(0.0, (k * kTick_s - c.stand_s) * c.speed);  // of the recipe
    const KeyPose pose = pose_at(c.poses, t);
    target.p_world_foot.push_back({plan.foot_at(kRight, t), plan.foot_at(kLeft, t)});
    target.carries.push_back({plan.carries(kRight, t), plan.carries(kLeft, t)});
    target.base_height.push_back(standing + pose.height_m);
    target.ground.emplace_back(plan.support_at(t, 0.0) + pose.weight);
  }
  return target;
}

/// The import's words, with what can be changed here.
std::string refusal(const std::string& file, const std::vector<std::string>& wrong) {
  std::string text = file + ": the robot cannot do it:";
  for (const std::string& line : wrong) text += "\n  " + line.substr(0, line.find(';'));
  return text +
         "\nNext: lower speed, make poses and steps smaller, or give the weight more time "
         "between landing and lift";
}

}  // namespace

ImportedMotion compose_motion(const std::string& text, const std::string& file,
                              const std::string& name) {
  const Composition composition = read_composition(TomlTable::parse(text, file));
  ImportedMotion out;
  out.motion = catalogue_entry(composition.like);
  out.motion.name = name;
  out.motion.title = composition.title;
  out.motion.source = {"not stated", "not stated", "composed from " + file};
  Recipe& recipe = out.motion.recipe;
  recipe.clip = file;
  recipe.kind = composition.plan.swings.empty() ? MotionKind::in_place : MotionKind::gait;
  recipe.stand_s = composition.stand_s;
  recipe.kappa = composition.kappa;
  out.retargeted = solve_body(target_of(composition));
  out.check = check_reference(out.retargeted);
  const auto wrong = complaints(out.check, recipe.kind);
  if (!wrong.empty()) throw ClipError(refusal(file, wrong));
  finish_motion(out);
  return out;
}

}  // namespace sanso::motion
