// The menu: poses of the trunk at rest, both soles down, one after the other and back.
#include "tools/diagnose/run/next_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "host/app/model_trial.h"
#include "host/app/motion_judge.h"
#include "host/motion/make/compose.h"
#include "host/motion/make/retarget.h"
#include "shared/files/input_error.h"
#include "shared/model/joints.h"
#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/run/session_recordings.h"
#include "tools/diagnose/wholebody/whole_data.h"

namespace sanso::diagnose {
namespace {

constexpr const char* kName = "next_experiment";

/// Trunk and weight from standing, m; seconds from a pose to the next.
struct Shape {
  double down = 0.0, left = 0.0, forward = 0.0;
  bool up_between = false;  // the second pose is at standing height
  double seconds = 1.0;
};

std::vector<Shape> menu() {
  return {
      {0.005, 0.0, 0.0, true, 1.5},     // stand
      {0.03, 0.0, 0.0, true, 1.0},      // squat
      {0.06, 0.0, 0.0, true, 1.0},      //
      {0.06, 0.0, 0.0, true, 0.6},      // fast
      {0.06, 0.0, 0.0, true, 2.0},      // slow
      {0.0, 0.03, 0.0, false, 1.0},     // sway
      {0.0, 0.03, 0.0, false, 0.6},     //
      {0.0, 0.045, 0.0, false, 1.5},    //
      {0.0, 0.0, 0.025, false, 1.0},    // lean
      {0.05, 0.03, 0.0, false, 1.0},    // sway while down
      {0.05, 0.03, 0.0, true, 1.0},     // down to one side, up to the other
      {0.05, 0.0, 0.025, true, 1.0},    // down and forward
      {0.04, 0.025, 0.015, true, 0.8},  // all at once
  };
}

const char* like(const Shape& s) {
  if (s.down >= 0.02) return "squat";
  return s.left >= 0.01 ? "sway" : "stand";
}

std::string in_words(const Shape& s) {
  std::string text;
  const auto add = [&](const std::string& part) { text += (text.empty() ? "" : ", ") + part; };
  if (s.down >= 0.02) add(fmt::format("squat {:.0f} mm", 1e3 * s.down));
  if (s.left >= 0.01) add(fmt::format("sway {:.0f} mm to either side", 1e3 * s.left));
  if (s.forward >= 0.005) add(fmt::format("lean {:.0f} mm to and fro", 1e3 * s.forward));
  if (text.empty()) return "stand";
  return text + fmt::format(", {:.2g} s from pose to pose", s.seconds);
}

/// The recipe, as a person would write it (docs/motions.md).
std::string recipe_of(const Shape& s, const NextSettings& next) {
  std::string out = fmt::format(
      "format = 1\ntitle = \"To tell causes apart: {}\"\nlike = \"{}\"\nstand_s = 1.0\n",
      in_words(s), like(s));
  double t = 0.0;
  const auto pose = [&](double height, double left, double forward) {
    t += s.seconds;
    out += fmt::format(
        "[[pose]]\nat_s = {:.3f}\nheight_m = {:.4f}\nleft_m = {:.4f}\n"
        "forward_m = {:.4f}\n",
        t, height, left, forward);
  };
  for (int k = 0; k < next.times; ++k) {
    pose(-s.down, s.left, s.forward);
    pose(s.up_between ? 0.0 : -s.down, -s.left, -s.forward);
  }
  return out + fmt::format("[[pose]]\nat_s = {:.3f}\n", t + s.seconds);
}

bool has_legs(const WholeBody& body) {
  const std::vector<TreeJoint>& joints = body.model.tree.joints;
  return std::all_of(model::kJoints.begin(), model::kJoints.end(), [&](const auto& info) {
    return std::any_of(joints.begin(), joints.end(),
                       [&](const TreeJoint& j) { return j.name == info.name; });
  });
}

void add(recording::Recording& r, const std::string& kind, const std::vector<V3>& values) {
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    std::vector<double> column;
    column.reserve(values.size());
    for (const V3& v : values) column.push_back(v[axis]);
    r.set(kind + ":" + "xyz"[axis], std::move(column));
  }
}

/// Base readings as the model's IMU, wherever it is, has them.
void mount_imu(recording::Recording& r, const WholeBody& body) {
  const M3 R = eigen(body.imu.R_joint_imu).transpose();
  const V3 at = eigen(body.imu.p_joint_imu);
  std::vector<V3> acc, gyro;
  const auto read = [&](const std::string& kind, std::size_t k) {
    return V3(r.find(kind + ":x")[k], r.find(kind + ":y")[k], r.find(kind + ":z")[k]);
  };
  for (std::size_t k = 0; k < r.rows(); ++k) {
    const V3 w = read("imu_gyro", k);
    const V3 dw = k + 1 < r.rows() ? V3((read("imu_gyro", k + 1) - w) / (r.t[k + 1] - r.t[k]))
                                   : V3(V3::Zero());
    acc.push_back(R * (read("imu_acc", k) + dw.cross(at) + w.cross(w.cross(at))));
    gyro.push_back(R * w);
  }
  add(r, "imu_acc", acc), add(r, "imu_gyro", gyro);
}

/// Amperes that the stated drive would take for what its loop gives.
std::vector<double> currents(const recording::Recording& r, const JointSettings& drive,
                             const std::string& joint) {
  const DriveLaw law = law_of(drive);
  std::vector<double> out;
  for (std::size_t k = 0; k < r.rows(); ++k) {
    const double torque = law.stiffness * (r.find("u:" + joint)[k] - r.find("q:" + joint)[k]) -
                          law.damping * r.find("dq:" + joint)[k];
    out.push_back(torque / std::max(law.torque_constant, 1e-9));
  }
  return out;
}

/// The trial with the columns of what it is laid beside.
recording::Recording recording_like(const learn::Episode& trial, const NamesApart& apart) {
  recording::Recording out = recording_of(trial);
  const std::vector<double> nothing(out.rows(), 0.0);
  const RobotTree& tree = apart.body().model.tree;
  for (std::size_t j = 0; j < tree.size(); ++j) {
    const std::string& name = tree.joints[j].name;
    for (const char* kind : {"q:", "dq:", "u:"})
      if (!out.has(kind + name)) out.set(kind + name, nothing);
    if (apart.current()) out.set("i:" + name, currents(out, apart.body().model.joints[j], name));
  }
  if (!apart.current())
    std::erase_if(out.channels,
                  [](const recording::Channel& c) { return c.name.starts_with("i:"); });
  for (const std::string& foot : apart.feet()) {
    const int joint = tree.links.at(foot).joint;
    const bool left = joint >= 0 && tree.joints[static_cast<std::size_t>(joint)].name[0] == 'l';
    std::vector<double> load;
    for (std::size_t k = 0; k < out.rows(); ++k)
      load.push_back(static_cast<double>(trial.truth[k].foot_load_N[left ? 1 : 0]));
    out.set("fz:" + foot, std::move(load));
  }
  mount_imu(out, apart.body());
  return out;
}

struct Tried {
  Shape shape;
  std::optional<motion::Motion> motion;  // nothing: the robot cannot, or does not hold a clause
  double nats_per_second = 0.0;
};

Tried tried(const Shape& shape, const NamesApart& apart, const Settings& settings) {
  Tried out{shape, {}, 0.0};
  motion::Motion made;
  try {
    made = motion::compose_motion(recipe_of(shape, settings.next), kName, kName).motion;
  } catch (const motion::ClipError&) {
    return out;
  } catch (const files::InputError&) {  // further than a recipe may go
    return out;
  }
  made.source = {"own", "Apache-2.0", "composed to tell causes apart"};
  const learn::Episode trial = app::trial_in_model(made);
  if (!app::broken_clauses(made, trial).empty()) return out;
  const WholeData data = judge_whole({recording_like(trial, apart)}, apart.body(), settings);
  if (!data.defects.empty()) return out;
  out.motion = std::move(made);
  out.nats_per_second = apart.nats(data.recordings.front()) / out.motion->duration_s();
  return out;
}

Tried best_of(const std::vector<Shape>& shapes, const NamesApart& apart, const Settings& settings,
              Tried best) {
  std::vector<Tried> all(shapes.size());
  parallel_for(shapes.size(), [&](std::size_t i) { all[i] = tried(shapes[i], apart, settings); });
  for (Tried& t : all)
    if (t.nats_per_second > best.nats_per_second) best = std::move(t);
  return best;
}

/// One figure of it more or less.
std::vector<Shape> near(const Shape& s, const NextSettings& next) {
  std::vector<Shape> out;
  for (const double factor : {1.0 / (1.0 + next.varied), 1.0 + next.varied}) {
    for (double Shape::*figure : {&Shape::down, &Shape::left, &Shape::forward, &Shape::seconds}) {
      Shape other = s;
      other.*figure *= factor;
      other.seconds = std::max(other.seconds, next.fastest);
      if (other.*figure != s.*figure) out.push_back(other);
    }
  }
  return out;
}

}  // namespace

NextMotion next_motion(const NamesApart& apart, const Settings& settings) {
  NextMotion out;
  out.experiment.kind = ExperimentKind::motion;
  out.experiment.separates = apart.names();
  if (!has_legs(apart.body())) {
    out.why_not =
        "motions are made for the joints of the OP3's legs, which this model does not have";
    return out;
  }
  const NextSettings& next = settings.next;
  Tried best = best_of(menu(), apart, settings, {});
  for (double before = 0.0; best.nats_per_second > (1.0 + next.better) * before;) {
    before = best.nats_per_second;
    best = best_of(near(best.shape, next), apart, settings, best);
  }
  if (!best.motion || best.nats_per_second < next.least) {
    out.why_not = "no squat, sway or lean within the success clauses tells them apart";
    return out;
  }
  out.experiment.what = in_words(best.shape);
  out.experiment.nats_per_second = best.nats_per_second;
  out.experiment.seconds_to_100_to_1 = std::log(100.0) / best.nats_per_second;
  out.motion = std::move(best.motion);
  return out;
}

}  // namespace sanso::diagnose
