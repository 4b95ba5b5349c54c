// The two balances of a window as rows y = X figures + noise of deviation one. Forces of the ground
// are unknown: a basis of what they cannot make is left of the equations of motion. Friction of
// joints that stand still, and accelerations, are uncertain: a covariance.
#include "tools/diagnose/wholebody/drive_rows.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <set>

#include "tools/diagnose/wholebody/drive_holds.h"
#include "tools/diagnose/wholebody/drive_track.h"
#include "tools/diagnose/wholebody/soles_apart.h"

namespace sanso::diagnose {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

class Builder {
 public:
  Builder(const Asking& asking, const DriveGuess& guess, DriveRows& out)
      : asking_(asking), tree_(asking.body), guess_(guess), out_(out), n_(out.columns.joints) {
    if (guess_.scales.size() == 0) guess_.scales = Vector::Ones(n_);
    if (guess_.lags.size() == 0) guess_.lags = Vector::Zero(n_);
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

  /// Rows of every window in which no foot comes down or off.
  void build() {
    Vector lags = guess_.lags;
    for (Eigen::Index j = 0; j < n_; ++j) lags[j] += law(j).lag;
    const std::vector<StandingWindow> windows = windows_of(asking_, lags);
    const std::vector<Vector> alike = holds_alike(windows, asking_.tolerances.zero);
    for (std::size_t k = 0; k < windows.size(); ++k) {
      const StandingWindow& taken = windows[k];
      const WindowMeans& w = taken.means;
      const std::vector<double>& t = asking_.recordings[taken.recording].t;
      piece_ = static_cast<std::size_t>((taken.from - t.front()) / asking_.settings.block);
      recording_ = taken.recording;
      alike_ = alike[k];
      out_.windows.push_back(
          {recording_, taken.from, taken.to, w.motion.q, w.motion.dq, w.error, given(w)});
      if (out_.current) add_loops(w);
      add_motion(w);
      for (std::size_t i = 1; i < taken.feet.size(); ++i)
        add_soles(w, taken.feet[i - 1], taken.feet[i]);
    }
  }

  void finish() {
    const auto rows = static_cast<Eigen::Index>(rows_.size());
    out_.X.resize(rows, out_.columns.count());
    out_.y.resize(rows);
    out_.unknown.resize(rows, 3 + n_);
    out_.loop = Eigen::Map<const Vector>(loop_.data(), rows);
    for (Eigen::Index k = 0; k < rows; ++k) {
      const Vector& row = rows_[static_cast<std::size_t>(k)];
      out_.X.row(k) = row.head(out_.columns.count());
      out_.y[k] = row[out_.columns.count()];
      out_.unknown.row(k) = row.tail(3 + n_);
    }
    const std::vector<std::size_t>& kinds = out_.channel;
    const bool soles = std::find(kinds.begin(), kinds.end(), sole_channel()) != kinds.end();
    out_.channels = sole_channel() + (soles ? 1 : 0);
  }

 private:
  /// Of what is no joint's loop; what the feet carry comes after it, then how soles lie.
  std::size_t motion_channel() const { return out_.current ? static_cast<std::size_t>(n_) : 0; }
  std::size_t sole_channel() const { return motion_channel() + (out_.weighed ? 2 : 1); }
  const DriveLaw& law(Eigen::Index j) const { return out_.laws[static_cast<std::size_t>(j)]; }

  /// Of the goal that would act with the model's delay alone: linear about the guess, where it is
  /// that of the track.
  double error_of(const WindowMeans& w, Eigen::Index j) const {
    return w.error[j] + guess_.lags[j] * w.command_rate[j];
  }

  /// Figures, what is missing, what is unknown.
  Eigen::Index width() const { return out_.columns.count() + 1 + 3 + n_; }

  /// Standard deviation of a joint's balance, N m: readings, and what no model knows of a drive.
  double deviation(Eigen::Index j, double torque, double dq) const {
    const StanceSettings& s = asking_.stance;
    return std::hypot(s.torque_noise, s.drive_share * torque, s.drive_share * law(j).damping * dq);
  }

  void put(const Vector& row, std::size_t channel, double loop = 0.0) {
    rows_.push_back(row), out_.channel.push_back(channel), loop_.push_back(loop);
    out_.recording.push_back(recording_), out_.piece.push_back(piece_);
    out_.window.push_back(out_.windows.size() - 1);
  }

  /// The current's torque against that of the position loop, joint by joint, over `deviation`:
  ///
  ///   torque - stiffness error + damping dq =
  ///       (gain - torque figure) stiffness error - lag stiffness command_rate - back_emf dq
  ///
  /// torque = torque_constant current; error is that of the goal that acts, `error_of`.
  void add_loops(const WindowMeans& w) {
    const DriveColumns& c = out_.columns;
    for (Eigen::Index j = 0; j < n_; ++j) {
      const DriveLaw& l = law(j);
      const double torque = l.torque_constant * w.current[j];
      Vector row = Vector::Zero(width());
      row[c.joint(JointFigure::gain, j)] = l.stiffness * error_of(w, j);
      row[c.joint(JointFigure::lag, j)] = -l.stiffness * w.command_rate[j];
      // what the loop says is given, by which the current's torque is a share too little
      row[c.joint(JointFigure::torque, j)] = -l.stiffness * error_of(w, j);
      row[c.back_emf()] = -w.motion.dq[j];
      row[c.count()] = torque - l.stiffness * error_of(w, j) + l.damping * w.motion.dq[j];
      const double off = deviation(j, torque, w.motion.dq[j]);
      put(row / off, static_cast<std::size_t>(j), 1.0 / off);
    }
  }

  /// Columns: a unit force along each axis, then a unit moment, at each link that may carry.
  Matrix jacobians() const {
    Matrix J(6 + n_, 6 * static_cast<Eigen::Index>(carrying_.size()));
    for (std::size_t s = 0; s < carrying_.size(); ++s) {
      for (Eigen::Index i = 0; i < 3; ++i) {
        const auto at = 6 * static_cast<Eigen::Index>(s) + i;
        J.col(at) = tree_.of_wrench(carrying_[s], V3::Unit(i), V3::Zero());
        J.col(at + 3) = tree_.of_wrench(carrying_[s], V3::Zero(), V3::Unit(i));
      }
    }
    return J;
  }

  /// Friction that a joint which stands still may be held by, N m.
  double may_hold(Eigen::Index j, double torque) const {
    const StanceSettings& s = asking_.stance;
    if (guess_.dry.size() == 0) return s.held_friction;
    return std::min(s.held_friction,
                    s.stiction * (guess_.dry[j] + guess_.load[j] * std::abs(torque)));
  }

  /// Spreads of readings, of friction of what stands still, of accelerations (every joint's by
  /// itself):
  ///
  ///   V = diag(noise) + sum over j of off off',  off = needed(ddq_j + its spread) - needed
  Matrix covariance(const WindowMeans& w, const Vector& needed) {
    const StanceSettings& s = asking_.stance;
    Vector noise = Vector::Constant(6 + n_, s.torque_noise * s.torque_noise);
    noise.head<3>().setConstant(s.force_noise * s.force_noise);
    for (Eigen::Index j = 0; j < n_; ++j)
      noise[6 + j] = std::pow(deviation(j, needed[6 + j], w.motion.dq[j]), 2);
    for (Eigen::Index j = 0; j < n_; ++j) {
      const double held = may_hold(j, needed[6 + j]) * (1.0 - std::abs(w.sign[j]));
      noise[6 + j] += alike_[j] * held * held;
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

  /// Forces of the ground that hold the whole up. Soles may press against each other, which the
  /// motion does not show: as the torques that were given would have it, as little as may be else.
  ///
  ///   B f = needed of the base        f = B'(BB')^-1 needed + N z,  B N = 0
  ///   min over z  |(needed - J f) of the joints - given|^2 + tiny |z|^2
  Vector ground(const Matrix& J, const Vector& given) const {
    const Matrix B = J.topRows(6);
    const Vector needed = tree_.needed();
    Vector f = B.transpose() * (B * B.transpose()).ldlt().solve(Vector(needed.head(6)));
    const Eigen::Index free = J.cols() - 6;
    if (free <= 0) return f;
    const Matrix Q = Eigen::HouseholderQR<Matrix>(B.transpose()).householderQ();
    const Matrix N = Q.rightCols(free), A = J.bottomRows(n_) * N;
    const Vector left = (needed - J * f).tail(n_) - given;
    Matrix AA = A.transpose() * A;
    AA.diagonal().array() += 1e-9 * AA.trace();  // against directions that nothing decides
    return f + N * AA.ldlt().solve(A.transpose() * left);
  }

  /// Torques at the joints as measured: by current, or else by the position loop.
  Vector given(const WindowMeans& w) const {
    Vector out(n_);
    for (Eigen::Index j = 0; j < n_; ++j) out[j] = given_at(w, j, w.error[j]);
    return out.cwiseProduct(guess_.scales);
  }
  double given_at(const WindowMeans& w, Eigen::Index j, double error) const {
    const DriveLaw& l = law(j);
    return out_.current ? l.torque_constant * w.current[j]
                        : l.stiffness * error - l.damping * w.motion.dq[j];
  }

  /// Motion needed less torques given, and what each figure makes of it. Rows of a joint:
  ///
  ///   y = needed of the tree + armature ddq + (coulomb + load |needed|) sign - given
  ///
  /// `needed` is what the ground leaves of the tree's. Nothing is given at the base. Columns of the
  /// result: the figures, y, what is unknown.
  Matrix equations(const WindowMeans& w, const Vector& needed) {
    const DriveColumns& c = out_.columns;
    Matrix E = Matrix::Zero(6 + n_, width());
    auto y = E.col(c.count());
    y = tree_.needed();
    // scales of a torque take the torque that the motion needs: what is measured has noise, which
    // would make every scale too small
    for (Eigen::Index j = 0; j < n_; ++j) {
      const DriveLaw& l = law(j);
      const Eigen::Index at = 6 + j;
      const double dq = w.motion.dq[j];
      y[at] += l.armature * w.motion.ddq[j] - given_at(w, j, error_of(w, j)) +
               (l.coulomb + l.load * std::abs(needed[at])) * w.sign[j];
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
    const V3 centre = eigen(asking_.body.base.com);
    for (Eigen::Index axis = 0; axis < 3; ++axis)
      E.col(c.count() + 1 + axis) =
          tree_.of_wrench(-1, V3::Unit(axis), centre.cross(V3::Unit(axis)));
    for (Eigen::Index j = 0; j < n_; ++j) E(6 + j, c.count() + 4 + j) = 1.0;
    return E;
  }

  /// Of readings that are off: zeros of joints, the accelerometer. The ground's forces hold in the
  /// sole's axes.
  ///
  ///   zero of j: d (needed - J f) / d q_j, f turning with the soles;  acc_bias: d needed / d acc
  void add_readings(const WindowMeans& w, const Vector& ground, const Matrix& J, Matrix& E) {
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
      for (std::size_t i = 0; i < carrying_.size(); ++i) {
        const auto at = 6 * static_cast<Eigen::Index>(i);
        const M3 turn = now[i] * turned[i].transpose();
        held += tree_.of_wrench(carrying_[i], turn * ground.segment<3>(at),
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
    for (const int sole : carrying_) out.push_back(tree_.rotation(sole));
    return out;
  }

  /// The equations of motion, whitened, less all that forces at the soles can make:
  ///
  ///   V = L L',  L^-1 J = Q R of rank r,  rows = Q' L^-1 E from row r on
  void add_motion(const WindowMeans& w) {
    tree_.set(w.motion);
    carrying_ = soles_;
    std::erase_if(carrying_, [&](int sole) {
      return std::find(w.in_air.begin(), w.in_air.end(), sole) != w.in_air.end();
    });
    if (carrying_.empty()) carrying_ = soles_;  // it stands on something that is no sensor
    const Matrix J = jacobians();
    const Vector pushed = ground(J, given(w));
    const Vector needed = tree_.needed() - J * pushed;
    Matrix E = equations(w, needed);
    add_readings(w, pushed, J, E);
    const Matrix V = covariance(w, needed);
    if (out_.weighed) add_weight(w, E, V);
    const Eigen::LLT<Matrix> root(V);
    const Eigen::ColPivHouseholderQR<Matrix> made(root.matrixL().solve(J));
    const Matrix left = made.householderQ().transpose() * Matrix(root.matrixL().solve(E));
    for (auto i = made.rank(); i < left.rows(); ++i) put(left.row(i), motion_channel());
  }

  /// What the feet carry against the vertical force that the motion needs: no torque is in it.
  ///
  ///   up'needed - weight = up'(columns of links and accelerometer) - force_scale up'needed
  ///
  /// `needed` is the tree's force on the base.
  void add_weight(const WindowMeans& w, const Matrix& E, const Matrix& V) {
    const DriveColumns& c = out_.columns;
    const double needed = w.up.dot(tree_.needed().head<3>());
    Vector row = E.topRows(3).transpose() * w.up;
    row.head(c.mass(-1)).setZero(), row[c.back_emf()] = 0.0;
    row[c.force_scale()] = -needed, row[c.count()] = needed - w.weight;
    const double deviation = std::hypot(std::sqrt(w.up.dot(V.topLeftCorner<3, 3>() * w.up)),
                                        asking_.settings.scale * needed);
    put(row / deviation, motion_channel() + 1);
  }

  /// Two soles against each other, over the deviation of a floor that is flat.
  void add_soles(const WindowMeans& w, const FootForce& one, const FootForce& other) {
    const auto apart = soles_apart(asking_.body, tree_, w.motion, one, other);
    if (!apart) return;
    for (Eigen::Index i = 0; i < 2; ++i) {
      Vector row = Vector::Zero(width());
      row[out_.columns.count()] = apart->lean[i];
      for (Eigen::Index j = 0; j < n_; ++j)
        row[out_.columns.joint(JointFigure::zero, j)] = apart->by_zero(i, j);
      put(row / asking_.stance.flat, sole_channel());
    }
  }

  const Asking& asking_;
  FloatingTree tree_;
  DriveGuess guess_;
  DriveRows& out_;
  Eigen::Index n_;
  std::vector<int> soles_, carrying_;  // joints; those that may carry in a window
  std::vector<Vector> rows_;
  std::vector<double> loop_;
  Vector alike_;  // by joint: windows in which it is held as in this one
  std::size_t recording_ = 0, piece_ = 0;
};

}  // namespace

DriveRows drive_rows(const Asking& asking, const DriveGuess& guess) {
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
  for (std::size_t j = 0; j < asking.known.load.size(); ++j)
    out.laws[j].load = asking.known.load[j];
  out.current = std::all_of(asking.recordings.begin(), asking.recordings.end(),
                            [](const WholeRecording& r) { return r.current; });
  out.weighed = std::all_of(asking.recordings.begin(), asking.recordings.end(),
                            [](const WholeRecording& r) { return r.attitude && !r.feet.empty(); });
  Builder builder(asking, guess, out);
  if (!builder.determined()) {
    out.why_not = "more links may touch than the joints' torques can tell apart";
    return out;
  }
  builder.build();
  builder.finish();
  if (out.y.size() == 0) out.why_not = "no stretch without a foot that comes down or off";
  return out;
}

}  // namespace sanso::diagnose
