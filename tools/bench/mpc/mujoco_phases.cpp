// Writes the model as MJCF once; each phase then calls MuJoCo with the state of a stage, one
// mjData a thread.
#include "tools/bench/mpc/mujoco_phases.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>

#include "host/mpc/op3_phases.h"
#include "shared/model/state_layout.h"

namespace sanso::bench {
namespace {

using model::Input;
using model::State;
using model::Tangent;

std::string inertial(const model::BodyInertia& b) {
  const double* I = b.inertia;  // xx xy xz yy yz zz; MJCF wants xx yy zz xy xz yz
  return fmt::format(R"(<inertial pos="{} {} {}" mass="{}" fullinertia="{} {} {} {} {} {}"/>)",
                     b.com[0], b.com[1], b.com[2], b.mass, I[0], I[3], I[5], I[1], I[2], I[4]);
}

std::string sole_points(int leg) {
  constexpr double kRadius = 0.001;  // spheres whose lowest points are the four corners
  const double side = leg == 0 ? -1.0 : 1.0;
  std::string out;
  for (const double x : {model::kSoleFront, model::kSoleBack})
    for (const double y : {model::kSoleOuter, model::kSoleInner})
      out += fmt::format(
          R"(<geom type="sphere" size="{}" pos="{} {} {}" condim="3" friction="0.8 0.005 )"
          R"(0.0001"/>)",
          kRadius, x, side * y, model::kSoleHeight + kRadius);
  return out;
}

std::string leg_bodies(const model::ModelParameters& theta, int leg, double h) {
  std::string out, close;
  for (int j = 6 * leg; j < 6 * leg + 6; ++j) {
    const model::JointGeometry& g = model::kOp3Joints[j];
    const model::ServoParameters& s = theta.servo[j];
    double axis[3] = {0, 0, 0};
    axis[g.axis] = g.sign;
    out += fmt::format(
        R"(<body pos="{} {} {}">{}<joint name="j{}" type="hinge" axis="{} {} {}" armature="{}"/>)",
        g.origin[0], g.origin[1], g.origin[2], inertial(theta.body[j + 1]), j, axis[0], axis[1],
        axis[2], s.armature + h * s.damping + h * h * s.stiffness);
    close += "</body>";
  }
  return out + sole_points(leg) + close;
}

}  // namespace

std::string peer_mjcf(const model::ModelParameters& theta, double h) {
  std::string actuators;
  for (int j = 0; j < model::kNumJoints; ++j) {
    const model::ServoParameters& s = theta.servo[j];
    actuators += fmt::format(
        R"(<general joint="j{}" gaintype="fixed" gainprm="{}" biastype="affine" biasprm="0 {} )"
        R"({}"/>)",
        j, s.stiffness, -s.stiffness, -(s.damping + h * s.stiffness));
  }
  return fmt::format(
      R"(<mujoco><compiler angle="radian"/><option timestep="{}" cone="pyramidal" gravity="0 0 )"
      R"(-9.81"/><worldbody>)"
      R"(<geom type="plane" size="10 10 1" condim="3" friction="0.8 0.005 0.0001"/>)"
      R"(<body><freejoint/>{}{}{}</body></worldbody><actuator>{}</actuator></mujoco>)",
      h, inertial(theta.body[0]), leg_bodies(theta, 0, h), leg_bodies(theta, 1, h), actuators);
}

MujocoPhases::MujocoPhases(int horizon, double dt_s, double difference_step, mpc::SpinPool& pool)
    : horizon_(horizon),
      difference_step_(difference_step),
      pool_(pool),
      context_(std::make_unique<mpc::ProblemContext>()) {
  const std::string xml = peer_mjcf(model::nominal_parameters(), dt_s);
  auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  mj_makeEmptyFileVFS(files.get(), "peer.xml", static_cast<int>(xml.size()));
  std::memcpy(files->filedata[0], xml.data(), xml.size());
  char error[500] = "";
  model_ = mj_loadXML("peer.xml", files.get(), error, sizeof error);
  mj_deleteVFS(files.get());
  if (model_ == nullptr)
    throw std::runtime_error(std::string("the peer's model was refused by MuJoCo: ") + error);
  for (int i = 0; i < pool.threads(); ++i) {
    data_.push_back(mj_makeData(model_));
    A_.emplace_back(mpc::kNdx * mpc::kNdx);
    B_.emplace_back(mpc::kNdx * mpc::kNu);
  }
}

MujocoPhases::~MujocoPhases() {
  for (mjData* data : data_) mj_deleteData(data);
  mj_deleteModel(model_);
}

void MujocoPhases::set(mjData* data, const double* x, int stage, const double* u_upper) const {
  std::copy_n(x, model::kNq, data->qpos);
  std::copy_n(x + model::kNq, model::kNv, data->qvel);
  for (int i = 0; i < mpc::kNu; ++i) data->ctrl[i] = context_->stage[stage].u_fixed[i] + u_upper[i];
  // the same start for every evaluation: a function of x and u
  std::fill_n(data->qacc_warmstart, model::kNv, 0.0);
}

void MujocoPhases::step(const double* x, const double* u, double* x_next, int thread) {
  mjData* data = data_[static_cast<std::size_t>(thread)];
  std::copy_n(x, model::kNq, data->qpos);
  std::copy_n(x + model::kNq, model::kNv, data->qvel);
  std::copy_n(u, model::kNu, data->ctrl);
  std::fill_n(data->qacc_warmstart, model::kNv, 0.0);
  mj_step(model_, data);
  std::copy_n(data->qpos, model::kNq, x_next);
  std::copy_n(data->qvel, model::kNv, x_next + model::kNq);
}

void MujocoPhases::linearize(const mpc::Trajectory& nominal, mpc::StageDerivatives* derivatives,
                             mpc::StageCost* costs) {
  pool_.run(stages(), [&](int stage, int thread) {
    linearize_stage(nominal, stage, thread, derivatives[stage]);
    mpc::cost_model(*context_, stage, nominal.x[stage], nominal.u[stage], costs[stage]);
  });
  mpc::cost_model(*context_, stages(), nominal.x[stages()], nullptr, costs[stages()]);
}

void MujocoPhases::linearize_stage(const mpc::Trajectory& nominal, int stage, int thread,
                                   mpc::StageDerivatives& out) {
  const auto t = static_cast<std::size_t>(thread);
  set(data_[t], nominal.x[stage], stage, nominal.u[stage]);
  mjd_transitionFD(model_, data_[t], difference_step_, 0, A_[t].data(), B_[t].data(), nullptr,
                   nullptr);
  for (int i = 0; i < mpc::kNdx; ++i) {
    for (int j = 0; j < mpc::kNdx; ++j)
      out.AB[i][j] = A_[t][static_cast<std::size_t>(i * mpc::kNdx + j)];
    for (int j = 0; j < mpc::kNu; ++j)
      out.AB[i][mpc::kNdx + j] = B_[t][static_cast<std::size_t>(i * mpc::kNu + j)];
    out.F[i] = 0;
  }
}

void MujocoPhases::roll_out(const mpc::LinePolicy& policy, const double* steps,
                            mpc::LaneTrajectories& out) {
  pool_.run(mpc::kLineSearchLanes,
            [&](int lane, int thread) { roll_out_lane(policy, steps[lane], lane, thread, out); });
}

void MujocoPhases::roll_out_lane(const mpc::LinePolicy& policy, double step_length, int lane,
                                 int thread, mpc::LaneTrajectories& out) {
  mjData* data = data_[static_cast<std::size_t>(thread)];
  const mpc::Trajectory& nominal = *policy.nominal;
  State x = Eigen::Map<const State>(nominal.x[0]);
  double cost = 0;
  const auto add_state_cost = [&](int knot) {
    const Tangent e = model::minus(x, Eigen::Map<const State>(context_->x_ref[knot]));
    cost += e.dot(Eigen::Map<const Tangent>(context_->state_weight).cwiseProduct(e));
    for (int i = 0; i < mpc::kNx; ++i) out.x(knot, i, lane) = x[i];
  };
  for (int k = 0; k < stages(); ++k) {
    add_state_cost(k);
    Input u = Eigen::Map<const Input>(nominal.u[k]);
    if (policy.gains != nullptr) {
      const Tangent dx = model::minus(x, Eigen::Map<const State>(nominal.x[k]));
      for (int i = 0; i < mpc::kNu; ++i) {
        u[i] += step_length * policy.gains[k].k[i];
        for (int j = 0; j < mpc::kNdx; ++j) u[i] += policy.gains[k].K[i][j] * dx[j];
      }
    }
    u = u.cwiseMax(-policy.input_limit_rad).cwiseMin(policy.input_limit_rad);
    for (int i = 0; i < mpc::kNu; ++i) out.u(k, i, lane) = u[i];
    cost += u.dot(Eigen::Map<const Input>(context_->input_weight).cwiseProduct(u));
    set(data, x.data(), k, u.data());
    mj_step(model_, data);
    std::copy_n(data->qpos, model::kNq, x.data());
    std::copy_n(data->qvel, model::kNv, x.data() + model::kNq);
  }
  add_state_cost(stages());
  out.cost(lane) = std::isfinite(cost) ? cost : std::numeric_limits<double>::infinity();
  out.noise_cost(lane) = 0;
}

}  // namespace sanso::bench
