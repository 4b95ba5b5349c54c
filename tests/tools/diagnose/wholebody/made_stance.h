// Recordings of a robot on two soles whose drives are not what its model says. Motion is drawn, the
// ground pushes as it has to and as it likes, and drives get the goals by which they make the rest.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <vector>

#include "shared/model/step_model.h"
#include "tools/diagnose/run/planner_model.h"
#include "tools/diagnose/stats/random.h"
#include "tools/diagnose/wholebody/drive_balance.h"
#include "tools/diagnose/wholebody/floating_tree.h"

namespace sanso::diagnose::test {

/// What a joint's drive really is; zero and one: as the model says.
struct TrueDrive {
  double gain = 1.0, coulomb = 0.0, viscous = 0.0, load = 0.0;
  double lag = 0.0;     // s, from a goal to the loop
  double torque = 1.0;  // newton metres of an ampere
};

struct Stance {
  int recordings = 5;
  double seconds = 8.0, interval = 0.01;
  bool current = false;
  double reading_noise = 2e-5;  // rad
  unsigned long seed = 3;
  std::function<TrueDrive(int joint)> drive = [](int) { return TrueDrive{}; };
  // share of the drawn motion: 0 stands still
  std::function<double(int recording)> moves = [](int) { return 1.0; };
  std::function<void(WholeBody&)> links = [](WholeBody&) {};  // what they really weigh
  // newtons on the base's origin, base axes
  std::function<V3(int recording, double t)> push = [](int, double) { return V3(V3::Zero()); };
};

/// Two sines a joint, slow enough for a smoother.
struct DrawnMotion {
  std::vector<std::array<double, 6>> waves;  // by joint: amplitude, rad/s, phase, twice
  DrawnMotion(int joints, double share, Random& random) {
    for (int j = 0; j < joints; ++j)
      waves.push_back({0.10 + 0.05 * random.uniform(), 1.5 + random.uniform(),
                       2 * std::numbers::pi * random.uniform(), 0.04, 3.0 + random.uniform(),
                       2 * std::numbers::pi * random.uniform()});
    for (auto& wave : waves) wave[0] *= share, wave[3] *= share;
  }
  FloatingMotion at(double t) const {
    const auto n = static_cast<Eigen::Index>(waves.size());
    FloatingMotion out;
    out.q.resize(n), out.dq.resize(n), out.ddq.resize(n);
    for (Eigen::Index j = 0; j < n; ++j) {
      const auto& w = waves[static_cast<std::size_t>(j)];
      const double a = w[1] * t + w[2], b = w[4] * t + w[5];
      out.q[j] = 0.2 + w[0] * std::sin(a) + w[3] * std::sin(b);
      out.dq[j] = w[0] * w[1] * std::cos(a) + w[3] * w[4] * std::cos(b);
      out.ddq[j] = -w[0] * w[1] * w[1] * std::sin(a) - w[3] * w[4] * w[4] * std::sin(b);
    }
    out.acc = V3(0.2 * std::sin(1.3 * t), 0.2 * std::cos(1.7 * t), 9.81);
    out.w = V3(0.05 * std::sin(t), 0.04 * std::cos(1.2 * t), 0.02 * std::sin(0.7 * t));
    out.dw = V3(0.05 * std::cos(t), -0.048 * std::sin(1.2 * t), 0.014 * std::cos(0.7 * t));
    return out;
  }
};

/// Joints whose links may touch.
inline std::vector<int> soles_of(const WholeBody& body) {
  std::vector<int> out;
  for (const CollisionShape& s : body.shapes)
    if (std::find(out.begin(), out.end(), s.joint) == out.end()) out.push_back(s.joint);
  return out;
}

/// Torques about the joints by which the motion happens, with forces of the ground that hold the
/// base and a part between the soles that changes with time. `given`: by whoever pushes.
Eigen::VectorXd torques_of(const FloatingTree& tree, const std::vector<int>& soles, double t,
                           const Eigen::VectorXd& given);

/// What the drives do at one moment.
struct Done {
  FloatingMotion motion;
  Eigen::VectorXd motor, goal;
};

class MovedRobot {
 public:
  MovedRobot(const WholeBody& body, const Stance& s, int number, Random& random)
      : stated_(body),
        real_(body),
        s_(s),
        number_(number),
        motion_(static_cast<int>(body.model.tree.size()), s.moves(number), random) {
    s.links(real_);
    soles_ = soles_of(body);
    tree_.emplace(real_);
  }
  Done at(double t) {
    Done out{motion_.at(t), {}, {}};
    tree_->set(out.motion);
    const V3 push = s_.push(number_, t);
    out.motor = torques_of(*tree_, soles_, t, tree_->of_wrench(-1, push, V3::Zero()));
    out.goal = out.motor;
    for (Eigen::Index j = 0; j < out.motor.size(); ++j) {
      const JointSettings& servo = stated_.model.joints[static_cast<std::size_t>(j)];
      const TrueDrive d = s_.drive(static_cast<int>(j));
      const double dq = out.motion.dq[j];
      out.motor[j] +=
          servo.armature * out.motion.ddq[j] + (servo.viscous + d.viscous) * dq +
          (servo.coulomb + d.coulomb + d.load * std::abs(out.motor[j])) * (dq > 0 ? 1.0 : -1.0);
      out.goal[j] = out.motion.q[j] + (out.motor[j] + servo.kd * dq) / (d.gain * servo.kp);
    }
    return out;
  }

 private:
  const WholeBody& stated_;
  WholeBody real_;
  const Stance& s_;
  int number_;
  DrawnMotion motion_;
  std::vector<int> soles_;
  std::optional<FloatingTree> tree_;
};

inline WholeRecording recorded(const WholeBody& body, const Stance& s, int number) {
  Random random(s.seed, static_cast<std::uint64_t>(number));
  const auto n = static_cast<Eigen::Index>(body.model.tree.size());
  MovedRobot robot(body, s, number, random);
  const auto rows = static_cast<Eigen::Index>(s.seconds / s.interval);
  WholeRecording r;
  r.file = r.name = "stance " + std::to_string(number);
  r.interval = s.interval;
  // joints are drawn, and soles are where they take them: no attitude, from which one would hang in
  // the air
  r.acc = r.gyro = r.commands = true, r.current = s.current;
  r.q.resize(n, rows), r.u = r.i = r.q;
  for (Eigen::Index k = 0; k < rows; ++k) {
    const double t = s.interval * static_cast<double>(k);
    const Done now = robot.at(t);
    r.t.push_back(t), r.piece.push_back(0), r.R.push_back(M3::Identity());
    r.w.push_back(now.motion.w), r.imu_acc.push_back(now.motion.acc);
    r.imu_gyro.push_back(now.motion.w);
    for (Eigen::Index j = 0; j < n; ++j) {
      const JointSettings& servo = body.model.joints[static_cast<std::size_t>(j)];
      r.q(j, k) = now.motion.q[j] + s.reading_noise * random.normal();
      const double per_ampere = servo.torque_constant * s.drive(static_cast<int>(j)).torque;
      r.i(j, k) = per_ampere > 0.0 ? now.motor[j] / per_ampere : 0.0;
      // the goal that acts now was sent a row before, and by the delay earlier; held for a row, it
      // acts half a row late on whatever moves
      const double lag = s.drive(static_cast<int>(j)).lag - (s.current ? 0.0 : 0.5 * s.interval);
      const double goal = lag != 0.0 ? robot.at(t + lag).goal[j] : now.goal[j];
      if (k > 0) r.u(j, k - 1) = goal;
      r.u(j, k) = goal;
    }
  }
  return r;
}

/// The planner's robot, its recordings, and what is asked of them.
struct StanceWorld {
  WholeBody body = planner_body(model::nominal_parameters());
  std::vector<WholeRecording> recordings;
  explicit StanceWorld(const Stance& stance) {
    for (int k = 0; k < stance.recordings; ++k) recordings.push_back(recorded(body, stance, k));
  }
  Asking asking() const {
    const Settings s;
    return {body, recordings, Known{}, s.whole, s.decisions, s.tolerances, 1, s.stance};
  }
};

}  // namespace sanso::diagnose::test
