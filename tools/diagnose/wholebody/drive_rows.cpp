// Forces of the ground are unknown: a basis of what they cannot make is left of the equations of
// motion. Friction of joints that stand still, and accelerations, are uncertain: a covariance.
#include "tools/diagnose/wholebody/drive_rows.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <set>

#include "tools/diagnose/compare/measured_motion.h"
#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/stats/smoother.h"
#include "tools/diagnose/wholebody/floating_tree.h"

namespace sanso::diagnose {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

/// The first of a step's rows still shows what the command before it did.
struct JointTrack {
  std::vector<double> q, dq, ddq, error, command_rate, current;
};
struct Track {
  std::vector<JointTrack> joints;
  std::vector<V3> acc, w, dw;
};

std::vector<double> differences(const std::vector<double>& t, const std::vector<double>& x) {
  std::vector<double> out(x.size(), 0.0);
  for (std::size_t k = 1; k < x.size(); ++k) out[k] = (x[k] - x[k - 1]) / (t[k] - t[k - 1]);
  return out;
}

JointTrack track_of_joint(const Asking& asking, const WholeRecording& r, Eigen::Index j) {
  JointTrack out;
  const Vector row = r.q.row(j);
  out.q.assign(row.data(), row.data() + row.size());
  const SmoothedState s = smooth_position(r.t, out.q, position_noise(out.q), asking.smoother);
  out.dq = s.dq, out.ddq = s.ddq;
  std::vector<double> before(r.rows());
  for (std::size_t k = 0; k < r.rows(); ++k)
    before[k] = r.u(j, static_cast<Eigen::Index>(k > 0 ? k - 1 : 0));
  out.command_rate = differences(r.t, before);
  for (std::size_t k = 0; k < r.rows(); ++k) {
    out.error.push_back(before[k] - out.q[k]);
    if (r.current) out.current.push_back(r.i(j, static_cast<Eigen::Index>(k)));
  }
  return out;
}

Track track_of(const Asking& asking, const WholeRecording& r) {
  Track out;
  const auto joints = static_cast<std::size_t>(r.q.rows());
  out.joints.resize(joints);
  std::array<SmoothedState, 3> turning;
  parallel_for(joints + 3, [&](std::size_t i) {
    if (i < joints) {
      out.joints[i] = track_of_joint(asking, r, static_cast<Eigen::Index>(i));
      return;
    }
    std::vector<double> w;
    for (const V3& x : r.w) w.push_back(x[static_cast<Eigen::Index>(i - joints)]);
    turning[i - joints] = smooth_position(r.t, w, position_noise(w), asking.smoother);
  });
  const ImuPlace& imu = asking.body.imu;
  const M3 R = eigen(imu.R_joint_imu);
  for (std::size_t k = 0; k < r.rows(); ++k) {
    const V3 w(turning[0].q[k], turning[1].q[k], turning[2].q[k]);
    const V3 dw(turning[0].dq[k], turning[1].dq[k], turning[2].dq[k]);
    const V3 at = eigen(imu.p_joint_imu);
    out.w.push_back(w), out.dw.push_back(dw);
    out.acc.push_back(R * (r.imu_acc[k] - asking.known.acc_bias) - dw.cross(at) -
                      w.cross(w.cross(at)));
  }
  return out;
}

/// Means over a window.
struct Window {
  FloatingMotion motion;
  Vector sign, error, command_rate, current;
};

Window window_of(const Track& track, std::size_t a, std::size_t b, double creeping) {
  const auto n = static_cast<Eigen::Index>(track.joints.size());
  Window out;
  for (Vector* v : {&out.motion.q, &out.motion.dq, &out.motion.ddq, &out.sign, &out.error,
                    &out.command_rate, &out.current})
    *v = Vector::Zero(n);
  const double share = 1.0 / static_cast<double>(b - a);
  for (std::size_t k = a; k < b; ++k) {
    for (Eigen::Index j = 0; j < n; ++j) {
      const JointTrack& t = track.joints[static_cast<std::size_t>(j)];
      out.motion.q[j] += share * t.q[k], out.motion.dq[j] += share * t.dq[k];
      out.motion.ddq[j] += share * t.ddq[k];
      out.sign[j] += share * std::clamp(t.dq[k] / creeping, -1.0, 1.0);
      out.error[j] += share * t.error[k], out.command_rate[j] += share * t.command_rate[k];
      if (!t.current.empty()) out.current[j] += share * t.current[k];
    }
    out.motion.acc += share * track.acc[k], out.motion.w += share * track.w[k];
    out.motion.dw += share * track.dw[k];
  }
  return out;
}

class Builder {
 public:
  Builder(const Asking& asking, DriveRows& out)
      : asking_(asking), tree_(asking.body), out_(out), n_(out.columns.joints) {
    std::set<std::pair<int, std::string>> soles;
    for (const CollisionShape& s : asking.body.shapes) soles.insert({s.joint, s.link});
    for (const auto& sole : soles) {
      soles_.push_back(sole.first);
      out.sole_links.push_back(sole.second);
    }
    std::sort(soles_.begin(), soles_.end());
    soles_.erase(std::unique(soles_.begin(), soles_.end()), soles_.end());
  }

  /// Wrenches may leave nothing of the equations.
  bool determined() const { return 6 * static_cast<Eigen::Index>(soles_.size()) < 6 + n_; }

  void add(std::size_t recording) {
    const WholeRecording& r = asking_.recordings[recording];
    const Track track = track_of(asking_, r);
    const StanceSettings& s = asking_.stance;
    const auto step = static_cast<std::size_t>(std::max(2.0, std::round(s.window / r.interval)));
    for (std::size_t a = 1; a + step <= r.rows(); a += step) {
      if (r.piece[a - 1] != r.piece[a + step - 1]) continue;
      const Window w = window_of(track, a, a + step, s.creeping);
      if (!w.motion.acc.allFinite() || !w.error.allFinite() || !w.current.allFinite()) continue;
      piece_ = static_cast<std::size_t>((r.t[a] - r.t.front()) / asking_.settings.block);
      recording_ = recording;
      if (out_.current) add_loops(w);
      add_motion(w);
    }
  }

  void finish() {
    out_.X.resize(static_cast<Eigen::Index>(rows_.size()), out_.columns.count());
    out_.y.resize(static_cast<Eigen::Index>(rows_.size()));
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      out_.X.row(k) = rows_[i].head(out_.columns.count());
      out_.y[k] = rows_[i][out_.columns.count()];
    }
    out_.channels = motion_channel() + 1;
  }

 private:
  /// Of what is no joint's loop: the last.
  std::size_t motion_channel() const { return out_.current ? static_cast<std::size_t>(n_) : 0; }
  const DriveLaw& law(Eigen::Index j) const { return out_.laws[static_cast<std::size_t>(j)]; }

  /// Standard deviation of a joint's balance, N m: readings, and what no model knows of a drive.
  double deviation(Eigen::Index j, double torque, double dq) const {
    const StanceSettings& s = asking_.stance;
    return std::hypot(s.torque_noise, s.drive_share * torque, s.drive_share * law(j).damping * dq);
  }

  void put(const Vector& row, std::size_t channel) {
    rows_.push_back(row), out_.channel.push_back(channel);
    out_.recording.push_back(recording_), out_.piece.push_back(piece_);
  }

  /// The current's torque against that of the position loop.
  void add_loops(const Window& w) {
    const DriveColumns& c = out_.columns;
    for (Eigen::Index j = 0; j < n_; ++j) {
      const DriveLaw& l = law(j);
      const double torque = l.torque_constant * w.current[j];
      Vector row = Vector::Zero(c.count() + 1);
      row[c.joint(JointFigure::gain, j)] = l.stiffness * w.error[j];
      row[c.joint(JointFigure::lag, j)] = -l.stiffness * w.command_rate[j];
      row[c.joint(JointFigure::torque, j)] = -torque;
      row[c.back_emf()] = -w.motion.dq[j];
      row[c.count()] = torque - l.stiffness * w.error[j] + l.damping * w.motion.dq[j];
      put(row / deviation(j, torque, w.motion.dq[j]), static_cast<std::size_t>(j));
    }
  }

  Matrix jacobians() const {
    Matrix J(6 + n_, 6 * static_cast<Eigen::Index>(soles_.size()));
    for (std::size_t s = 0; s < soles_.size(); ++s) {
      for (Eigen::Index i = 0; i < 3; ++i) {
        const auto at = 6 * static_cast<Eigen::Index>(s) + i;
        J.col(at) = tree_.of_wrench(soles_[s], V3::Unit(i), V3::Zero());
        J.col(at + 3) = tree_.of_wrench(soles_[s], V3::Zero(), V3::Unit(i));
      }
    }
    return J;
  }

  /// Spreads of readings, of friction of what stands still, of accelerations.
  Matrix covariance(const Window& w, const Vector& needed) {
    const StanceSettings& s = asking_.stance;
    Vector noise = Vector::Constant(6 + n_, s.torque_noise * s.torque_noise);
    noise.head<3>().setConstant(s.force_noise * s.force_noise);
    for (Eigen::Index j = 0; j < n_; ++j)
      noise[6 + j] = std::pow(deviation(j, needed[6 + j], w.motion.dq[j]), 2);
    for (Eigen::Index j = 0; j < n_; ++j) {
      const double held = s.held_friction * (1.0 - std::abs(w.sign[j]));
      noise[6 + j] += held * held;
    }
    Matrix V = noise.asDiagonal();
    const Vector as_is = tree_.needed();
    FloatingMotion moved = w.motion;
    for (Eigen::Index j = 0; j < n_; ++j) {
      const double before = moved.ddq[j];
      moved.ddq[j] += s.acceleration_noise + s.acceleration * std::abs(before);
      tree_.set(moved);
      const Vector off = tree_.needed() - as_is;
      V += off * off.transpose();
      moved.ddq[j] = before;
    }
    tree_.set(w.motion);
    return V;
  }

  /// The smallest forces of the ground that hold the whole up.
  Vector ground(const Matrix& J) const {
    const Matrix on_base = J.topRows(6);
    return on_base.transpose() *
           (on_base * on_base.transpose()).ldlt().solve(Vector(tree_.needed().head(6)));
  }

  /// Motion needed less torques given, and what each figure makes of it.
  Matrix equations(const Window& w, const Vector& needed) {
    const DriveColumns& c = out_.columns;
    Matrix E = Matrix::Zero(6 + n_, c.count() + 1);
    auto y = E.col(c.count());
    y = tree_.needed();
    // scales of a torque take the torque that the motion needs: what is measured has noise, which
    // would make every scale too small
    for (Eigen::Index j = 0; j < n_; ++j) {
      const DriveLaw& l = law(j);
      const Eigen::Index at = 6 + j;
      const double dq = w.motion.dq[j], by_current = l.torque_constant * w.current[j];
      const double by_loop = l.stiffness * w.error[j] - l.damping * dq;
      const double torque = out_.current ? by_current : by_loop;
      y[at] += l.armature * w.motion.ddq[j] + l.coulomb * w.sign[j] - torque;
      E(at, c.joint(JointFigure::speed, j)) = -dq;
      E(at, c.joint(JointFigure::dry, j)) = -w.sign[j];
      E(at, c.joint(JointFigure::load, j)) = -w.sign[j] * std::abs(needed[at]);
      E(at, c.joint(JointFigure::rotor, j)) = -w.motion.ddq[j];
      if (out_.current) {
        E(at, c.joint(JointFigure::torque, j)) = needed[at];
        E(at, c.back_emf()) = dq;
      } else {
        E(at, c.joint(JointFigure::gain, j)) = needed[at] + l.damping * dq;
        E(at, c.joint(JointFigure::lag, j)) = -l.stiffness * w.command_rate[j];
      }
    }
    for (int link = -1; link < n_; ++link) {
      E.col(c.mass(link)) = -tree_.of_mass(link);
      for (int axis = 0; axis < 3; ++axis)
        E.col(c.mass(link) + 1 + axis) = -tree_.of_moment(link, axis);
    }
    return E;
  }

  /// Of readings that are off: zeros of joints, the accelerometer. The ground's forces hold in the
  /// sole's axes.
  void add_readings(const Window& w, const Vector& ground, const Matrix& J, Matrix& E) {
    const DriveColumns& c = out_.columns;
    FloatingMotion moved = w.motion;
    constexpr double kStep = 1e-4;
    const Vector needed = tree_.needed();
    const std::vector<M3> turned = sole_axes();
    for (Eigen::Index j = 0; j < n_; ++j) {
      moved.q[j] += kStep;
      tree_.set(moved);
      const std::vector<M3> now = sole_axes();
      Vector held = Vector::Zero(6 + n_);
      for (std::size_t i = 0; i < soles_.size(); ++i) {
        const auto at = 6 * static_cast<Eigen::Index>(i);
        const M3 turn = now[i] * turned[i].transpose();
        held += tree_.of_wrench(soles_[i], turn * ground.segment<3>(at),
                                turn * ground.segment<3>(at + 3));
      }
      E.col(c.joint(JointFigure::zero, j)) = (tree_.needed() - held - needed + J * ground) / kStep;
      moved.q[j] -= kStep;
    }
    for (Eigen::Index i = 0; i < 3; ++i) {
      moved.acc[i] += 1.0;
      tree_.set(moved);
      E.col(c.acc_bias() + i) = tree_.needed() - needed;
      moved.acc[i] -= 1.0;
    }
    tree_.set(w.motion);
  }

  std::vector<M3> sole_axes() const {
    std::vector<M3> out;
    for (const int sole : soles_) out.push_back(tree_.rotation(sole));
    return out;
  }

  void add_motion(const Window& w) {
    tree_.set(w.motion);
    const Matrix J = jacobians();
    const Vector pushed = ground(J);
    const Vector needed = tree_.needed() - J * pushed;
    Matrix E = equations(w, needed);
    add_readings(w, pushed, J, E);
    const Eigen::LLT<Matrix> root(covariance(w, needed));
    const Eigen::ColPivHouseholderQR<Matrix> made(root.matrixL().solve(J));
    const Matrix left = made.householderQ().transpose() * Matrix(root.matrixL().solve(E));
    for (auto i = made.rank(); i < left.rows(); ++i) put(left.row(i), motion_channel());
  }

  const Asking& asking_;
  FloatingTree tree_;
  DriveRows& out_;
  Eigen::Index n_;
  std::vector<int> soles_;
  std::vector<Vector> rows_;
  std::size_t recording_ = 0, piece_ = 0;
};

std::string drive_unknown(const WholeBody& body) {
  for (std::size_t j = 0; j < body.model.joints.size(); ++j) {
    const JointSettings& s = body.model.joints[j];
    const bool follows = s.actuator == Actuator::position_pd ||
                         (s.actuator == Actuator::dc_servo && s.i_gain == 0.0);
    if (!follows)
      return "the drive of " + body.model.tree.joints[j].name +
             " follows no goal position (position_pd, dc_servo without i_gain)";
  }
  return {};
}

DriveLaw law_of(const JointSettings& s) {
  DriveLaw out;
  const double per_duty = s.torque_constant * s.voltage / s.resistance;
  const bool servo = s.actuator == Actuator::dc_servo;
  out.stiffness = servo ? s.p_gain * per_duty : s.kp;
  out.damping = servo ? s.d_gain * per_duty + s.torque_constant * s.back_emf / s.resistance : s.kd;
  out.damping += s.viscous;
  out.torque_constant = s.torque_constant, out.armature = s.armature, out.coulomb = s.coulomb;
  return out;
}

}  // namespace

DriveRows drive_rows(const Asking& asking) {
  DriveRows out;
  const WholeBody& body = asking.body;
  out.columns.joints = static_cast<Eigen::Index>(body.model.tree.size());
  if (out.columns.joints == 0) out.why_not = "the robot has no joints";
  for (const WholeRecording& r : asking.recordings) {
    if (!r.commands) out.why_not = r.file + ": not every joint's goal and position is recorded";
    if (!r.acc) out.why_not = r.file + ": no imu_acc, and so no motion of the base";
  }
  if (out.why_not.empty()) out.why_not = drive_unknown(body);
  if (!out.why_not.empty()) return out;
  for (const JointSettings& s : body.model.joints) out.laws.push_back(law_of(s));
  out.current = std::all_of(asking.recordings.begin(), asking.recordings.end(),
                            [](const WholeRecording& r) { return r.current; });
  Builder builder(asking, out);
  if (!builder.determined()) {
    out.why_not = "more links may touch than the joints' torques can tell apart";
    return out;
  }
  for (std::size_t r = 0; r < asking.recordings.size(); ++r) builder.add(r);
  builder.finish();
  return out;
}

}  // namespace sanso::diagnose
