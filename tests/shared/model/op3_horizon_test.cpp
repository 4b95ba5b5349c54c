// How far the 60 ms step is from continuous physics: the same robot and servo law in MuJoCo at 0.5
// ms, soft contact of its own. Prints the table of docs/results/dynamics.md; the checks are on
// order and rough size only.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "shared/model/ground.h"
#include "shared/model/op3_step.h"
#include "tests/oracle/op3_tree.h"
#include "tests/shared/model/op3_states.h"
#include "tests/support/mjcf_of_tree.h"
#include "tests/support/mujoco_model.h"

namespace sanso::model {
namespace {

constexpr unsigned kSeed = 5;
constexpr int kSteps = 12, kTrials = 40;
constexpr double kStep = 0.06, kPhysicsStep = 5e-4;

// Sole corners as tiny spheres on a plane; feet do not touch each other.
std::string world_of(const Tree& tree) {
  std::string xml = testing::mjcf_of(tree);
  for (const int foot : {kRightFoot, kLeftFoot}) {
    std::string geoms;
    for (int c = 0; c < kCornersPerFoot; ++c) {
      Vec3 p = sole_corner_in_foot(foot, c);
      p[2] += 1e-3;
      geoms += "<geom type=\"sphere\" size=\"0.001\" pos=\"" + testing::text(p) +
               "\" contype=\"1\" conaffinity=\"0\" friction=\"0.8 0 0\" solref=\"0.004 1\"/>";
    }
    const std::string joint = "<joint name=\"joint" + std::to_string(foot_body(foot) - 1) + "\"";
    xml.insert(xml.find(joint), geoms);
  }
  const std::string world = "<worldbody>";
  xml.insert(
      xml.find(world) + world.size(),
      "<geom type=\"plane\" size=\"9 9 1\" contype=\"0\" conaffinity=\"1\" friction=\"0.8 0 0\" "
      "solref=\"0.004 1\"/>");
  return xml;
}

class Physics {
 public:
  explicit Physics(const ModelParameters& theta) : theta_(theta), mj_(world_of(op3_tree(theta))) {
    mj_.model->opt.timestep = kPhysicsStep;
    for (int j = 0; j < kNumJoints; ++j) mj_.model->dof_damping[6 + j] = theta.servo[j].damping;
  }
  State advance(const State& x, const Input& u) {
    std::copy_n(x.data(), kNq, mj_.data->qpos);
    std::copy_n(x.data() + kNq, kNv, mj_.data->qvel);
    for (int i = 0; i < std::lround(kStep / kPhysicsStep); ++i) {
      for (int j = 0; j < kNumJoints; ++j) {
        const ServoParameters& s = theta_.servo[j];
        const double torque = s.stiffness * (u[j] - mj_.data->qpos[kXJoint + j]);
        mj_.data->qfrc_applied[6 + j] =
            std::fmin(std::fmax(torque, -s.torque_limit), s.torque_limit);
      }
      mj_step(mj_.model.get(), mj_.data.get());
    }
    State next;
    std::copy_n(mj_.data->qpos, kNq, next.data());
    std::copy_n(mj_.data->qvel, kNv, next.data() + kNq);
    return next;
  }

 private:
  ModelParameters theta_;
  testing::Mujoco mj_;
};

struct Recorded {
  std::array<State, kSteps + 1> x;
  std::array<Input, kSteps> u;
};

// Sway, squat and twist the standing robot by smooth random targets, from a disturbed start.
Recorded random_run(Physics& physics, std::mt19937& rng) {
  std::normal_distribution<double> normal;
  Recorded run;
  run.x[0] = plus(standing_state(), random_tangent(rng, 0.0, 0.02, 0.03, 0.05, 0.1, 0.3));
  Input amplitude, phase;
  for (int j = 0; j < kNu; ++j) {
    amplitude[j] = 0.1 * normal(rng);
    phase[j] = normal(rng);
  }
  for (int k = 0; k < kSteps; ++k) {
    for (int j = 0; j < kNu; ++j)
      run.u[k][j] =
          joints(standing_state())[j] + amplitude[j] * std::sin(6.0 * k * kStep + phase[j]);
    run.x[k + 1] = physics.advance(run.x[k], run.u[k]);
  }
  return run;
}

struct Error {
  double base = 0, tilt = 0, joint = 0;  // sums of squares
  int n = 0;
  void add(const State& a, const State& b) {
    const Tangent d = minus(a, b);
    base += d.segment<3>(kDPos).squaredNorm();
    tilt += d.segment<3>(kDTheta).squaredNorm();
    joint += d.segment<kNumJoints>(kDJoint).squaredNorm() / kNumJoints;
    ++n;
  }
  double base_mm() const { return 1e3 * std::sqrt(base / n); }
  double tilt_mrad() const { return 1e3 * std::sqrt(tilt / n); }
  double joint_mrad() const { return 1e3 * std::sqrt(joint / n); }
};

struct Errors {
  Error one_step, horizon;
};

Errors errors_of(const StepModel& model, const std::vector<Recorded>& runs, int substeps) {
  Errors e;
  for (const Recorded& run : runs) {
    State x = run.x[0];
    StepScratch scratch;
    for (int k = 0; k < kSteps; ++k) {
      State next;
      analytical_step(model, make_plane(), run.x[k].data(), run.u[k].data(), kStep, substeps,
                      next.data(), scratch);
      e.one_step.add(next, run.x[k + 1]);
      analytical_step(model, make_plane(), x.data(), run.u[k].data(), kStep, substeps, x.data(),
                      scratch);
      e.horizon.add(x, run.x[k + 1]);
    }
  }
  return e;
}

TEST(Op3Horizon, ErrorAgainstFinePhysicsFallsWithSubsteps) {
  std::mt19937 rng(kSeed);
  const ModelParameters theta = nominal_parameters();
  Physics physics(theta);
  std::vector<Recorded> runs;
  for (int i = 0; i < kTrials; ++i) runs.push_back(random_run(physics, rng));

  std::printf(
      "substeps | one step: base mm  tilt mrad  joint mrad | 0.72 s: base mm  tilt mrad  joint "
      "mrad\n");
  const auto row = [&](int substeps) {
    const StepModel model = make_step_model(theta);
    const Errors e = errors_of(model, runs, substeps);
    std::printf("%8d | %17.2f %10.2f %11.2f | %15.2f %10.2f %11.2f\n", substeps,
                e.one_step.base_mm(), e.one_step.tilt_mrad(), e.one_step.joint_mrad(),
                e.horizon.base_mm(), e.horizon.tilt_mrad(), e.horizon.joint_mrad());
    return e;
  };
  const Errors one = row(1);
  row(2);
  row(3);
  row(6);
  const Errors twelve = row(12);
  EXPECT_LT(twelve.one_step.joint_mrad(), 0.5 * one.one_step.joint_mrad())
      << "the step is consistent";
  EXPECT_LT(twelve.horizon.joint_mrad(), one.horizon.joint_mrad());
  EXPECT_LT(one.one_step.joint_mrad(), 40.0) << "a 60 ms step, servo time constant 75 ms";
}

}  // namespace
}  // namespace sanso::model
