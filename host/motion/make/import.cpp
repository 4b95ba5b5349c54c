// Clip, recipe, retarget, fit, check, file: the pipeline in order, with what it complains about
// at the end.
#include "host/motion/make/import.h"

#include <algorithm>
#include <cstdio>
#include <sstream>

#include "host/motion/catalogue.h"
#include "host/motion/dmp_fit.h"

namespace sanso::motion {
namespace {

std::string complaint(const char* format, double value, double bound,
                      const std::string& more = "") {
  char buffer[240];
  std::snprintf(buffer, sizeof buffer, format, value, bound);
  return buffer + more;
}

/// From the first moment the joints move to the last one.
Window moving_window(const BodyTarget& target, const Trajectory& trajectory) {
  constexpr double kStill = 0.02;  // rad/s
  const auto still = [&](std::size_t k) {
    const bool both = target.carries[k][kRight] && target.carries[k][kLeft];
    return both && model::joint_rates(trajectory.x[k]).cwiseAbs().maxCoeff() < kStill;
  };
  std::size_t from = 0, to = trajectory.x.size() - 1;
  while (from < to && still(from)) ++from;
  while (to > from && still(to)) --to;
  if (from == to) return {0.0, trajectory.duration_s()};  // a motion that does not move: all of it
  return {trajectory.dt_s * static_cast<double>(from), trajectory.dt_s * static_cast<double>(to)};
}

/// Of a gait: from the first lift to the last landing.
Window stepping_window(const BodyTarget& target, double dt_s) {
  const auto both = [&](std::size_t k) {
    return target.carries[k][kRight] && target.carries[k][kLeft];
  };
  std::size_t from = 0, to = target.carries.size() - 1;
  while (from < to && both(from)) ++from;
  while (to > from && both(to)) --to;
  return {dt_s * static_cast<double>(from), dt_s * static_cast<double>(to)};
}

template <class T>
T parsed(const std::string& figure, const std::string& value) {
  T number{};
  std::istringstream text(value);
  text >> std::boolalpha >> number;
  if (text.fail() || !(text >> std::ws).eof())
    throw MotionError("--set " + figure + ": '" + value + "' is not a value of this figure");
  return number;
}

/// Replaces one figure of the recipe by `figure`, "key=value".
void set_figure(Recipe& recipe, const std::string& figure) {
  const std::size_t sign = figure.find('=');
  const std::string key = figure.substr(0, sign),
                    value = sign == std::string::npos ? "" : figure.substr(sign + 1);
  std::string known;
  bool found = false;
  visit_recipe(recipe, [&](const char* name, auto& field) {
    known += (known.empty() ? "" : ", ") + std::string(name);
    if (key != name) return;
    found = true;
    field = parsed<std::remove_reference_t<decltype(field)>>(figure, value);
  });
  if (!found) throw MotionError("--set " + figure + ": no such figure; there are: " + known);
}

}  // namespace

FitError fit_error(const policy::PrimitiveSet& set, const Trajectory& wanted) {
  FitError error;
  const Trajectory played = play(set);
  for (std::size_t k = 0; k < std::min(played.x.size(), wanted.x.size()); ++k) {
    const model::Tangent d = model::minus(played.x[k], wanted.x[k]);
    error.position_m = std::max(error.position_m, d.head<3>().cwiseAbs().maxCoeff());
    error.joint_rad = std::max(error.joint_rad,
                               d.segment<model::kNumJoints>(model::kDJoint).cwiseAbs().maxCoeff());
  }
  return error;
}

std::vector<std::string> complaints(const ReferenceCheck& check, MotionKind kind) {
  std::vector<std::string> found;
  if (check.peak_joint_speed > kMaxReferenceSpeed) {
    found.push_back(complaint(
        "joint speed %.2f rad/s, the servo allows %.2f; raise kt or lower kx or swing_height_m",
        check.peak_joint_speed, kMaxReferenceSpeed, " (" + check.fastest_joint + ")"));
  }
  if (check.reach > kMaxReach) {
    found.push_back(
        complaint("leg stretched to %.3f of its length, at most %.3f; lower kappa or kx",
                  check.reach, kMaxReach));
  }
  if (check.joint_margin_rad < 0.0) {
    found.push_back(
        complaint("a joint is %.3f rad beyond its limit (margin at least %.0f); lower kz",
                  -check.joint_margin_rad, 0.0));
  }
  if (check.zmp_margin_worst_m < 0.0) {
    found.push_back(complaint(
        "ZMP %.1f mm outside the soles (margin at least %.0f mm); raise kt or double_support_s",
        -1e3 * check.zmp_margin_worst_m, 0.0));
  }
  if (check.feet_gap_m < 0.005) {
    found.push_back(complaint("the soles come within %.1f mm, at least %.1f mm; the steps cross",
                              1e3 * check.feet_gap_m, 5.0));
  }
  if (kind == MotionKind::gait && check.lowest_swing_peak_m < 0.010) {
    found.push_back(complaint("a swing rises only %.1f mm, at least %.0f mm; raise swing_height_m",
                              1e3 * check.lowest_swing_peak_m, 10.0));
  }
  return found;
}

void finish_motion(ImportedMotion& made) {
  const Recipe& recipe = made.motion.recipe;
  const Retargeted& body = made.retargeted;
  made.motion.window = recipe.kind == MotionKind::gait
                           ? stepping_window(body.target, body.trajectory.dt_s)
                           : moving_window(body.target, body.trajectory);
  made.motion.primitives = fit_discrete(body.trajectory, {recipe.basis_per_second, 0.9});
  // what the file holds is what is checked and returned
  made.motion = parse_motion(to_toml(made.motion), made.motion.name);
  made.fit = fit_error(made.motion.primitives, body.trajectory);
}

ImportedMotion import_motion(const ImportRequest& request) {
  ImportedMotion out;
  out.motion = catalogue_entry(request.like.empty() ? request.name : request.like);
  out.motion.name = request.name;
  Recipe& recipe = out.motion.recipe;
  if (std::filesystem::path(recipe.clip).filename() != request.clip.filename()) {
    // another clip: its cut and its licence are not known
    recipe.clip = request.clip.filename().string();
    recipe.first_frame = 0;
    recipe.last_frame = -1;
    out.motion.title = request.name + ", from " + recipe.clip;
    out.motion.source = {"not stated", "not stated", "retargeted, fitted by movement primitives"};
  }
  for (const std::string& figure : request.figures) set_figure(recipe, figure);
  out.retargeted = retarget(read_human_motion(request.clip.string()), recipe);
  out.check = check_reference(out.retargeted);
  const auto wrong = complaints(out.check, recipe.kind);
  if (!wrong.empty()) {
    std::string text = request.clip.string() + ": as " + request.name + " the robot cannot do it:";
    for (const auto& line : wrong) text += "\n  " + line;
    throw ClipError(text);
  }
  finish_motion(out);
  return out;
}

}  // namespace sanso::motion
