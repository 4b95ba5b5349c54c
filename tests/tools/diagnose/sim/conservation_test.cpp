// Energy, momentum, reversal of time and order of convergence of the integrator.
#include <gtest/gtest.h>

#include "tests/support/small_world.h"
#include "tools/diagnose/sim/tree_dynamics.h"

namespace sanso::diagnose {
namespace {

using namespace test;

const auto kNoCommand = [](int, double) { return 0.0; };

/// The row-th column of a prediction: positions or velocities of all joints.
std::vector<double> at_row(const Prediction& p, const std::vector<double>& channel,
                           std::size_t row) {
  std::vector<double> out;
  for (std::size_t j = 0; j * p.rows < channel.size(); ++j)
    out.push_back(channel[j * p.rows + row]);
  return out;
}

Prediction run(const SimParams& params, const Drive& drive, std::vector<double> q,
               std::vector<double> dq, double step = 1e-3) {
  SimOptions options;
  options.max_step_s = step;
  return simulate(params, drive, std::vector{whole(drive, std::move(q), std::move(dq))}, options)
      .front();
}

/// Kinetic and potential energy of the tree and of the springs of its joints.
class Energy {
 public:
  explicit Energy(const SimParams& params) : params_(params), tree_(params.tree, params.gravity) {}
  double of(const std::vector<double>& q, const std::vector<double>& dq) {
    JointVector p = momentum(q, dq);
    double sum = 0.0;
    for (std::size_t j = 0; j < q.size(); ++j) {
      const Vec3& com = tree_.com(static_cast<int>(j));
      sum += 0.5 * p[j] * dq[j] + 0.5 * params_.joints[j].spring * q[j] * q[j];
      for (std::size_t k = 0; k < 3; ++k)
        sum -= params_.tree.joints[j].body.mass * params_.gravity[k] * com[k];
    }
    return sum;
  }
  /// M(q) dq, rotors included.
  JointVector momentum(const std::vector<double>& q, const std::vector<double>& dq) {
    JointMatrix M{};
    tree_.set_positions(q.data());
    tree_.mass_matrix(M);
    JointVector p{};
    for (std::size_t i = 0; i < q.size(); ++i) {
      for (std::size_t j = 0; j < q.size(); ++j)
        p[i] += M[std::max(i, j) * kMaxJoints + std::min(i, j)] * dq[j];
      p[i] += params_.joints[i].nominal.armature * dq[i];
    }
    return p;
  }

 private:
  SimParams params_;
  TreeDynamics tree_;
};

/// Largest change of energy over a swing of the frictionless arm with steps of h.
double drift(double h) {
  const ModelFolder model = arm("actuator = \"passive\"\narmature = 0.01\n");
  SimParams params = make_params(model);
  params.joints[2].spring = 40.0;  // keeps the slider within its rail
  const Drive drive = make_test_drive(model, 2.0, 0.02, kNoCommand);
  const Prediction p = run(params, drive, {0.8, -0.5, 0.02}, {0.5, 1.0, 0.0}, h);
  Energy energy(params);
  const double start = energy.of(at_row(p, p.q, 0), at_row(p, p.dq, 0));
  double worst = 0.0;
  for (std::size_t r = 0; r < p.rows; ++r)
    worst = std::max(worst, std::abs(energy.of(at_row(p, p.q, r), at_row(p, p.dq, r)) - start));
  return worst;
}

TEST(Conservation, AnArmWithoutFrictionKeepsItsEnergy) {
  EXPECT_LT(drift(1e-3), 2e-3) << "J, of about 1 J in motion";
}

TEST(Conservation, TheErrorOfTheEnergyIsOfSecondOrderInTheStep) {
  const double coarse = drift(2e-3), fine = drift(1e-3);
  EXPECT_NEAR(coarse / fine, 4.0, 1.0);
}

TEST(Conservation, WithoutGravityTheFirstJointKeepsItsMomentum) {
  // nothing depends on the angle of the joint at the base: its momentum is an integral of motion
  ModelFolder model = arm("actuator = \"passive\"\n");
  model.gravity = {0, 0, 0};
  const SimParams params = make_params(model);
  const Drive drive = make_test_drive(model, 1.5, 0.02, kNoCommand);
  const Prediction p = run(params, drive, {0.3, 0.9, 0.0}, {1.0, 2.0, 0.0});
  Energy energy(params);
  const double start = energy.momentum(at_row(p, p.q, 0), at_row(p, p.dq, 0))[0];
  const auto last = p.rows - 1;
  EXPECT_NEAR(energy.momentum(at_row(p, p.q, last), at_row(p, p.dq, last))[0], start,
              1e-3 * std::abs(start));
  EXPECT_GT(std::abs(at_row(p, p.dq, last)[0] - 1.0), 0.05) << "its speed changes all the same";
}

TEST(Conservation, MotionRunsBackToItsStartWhenTheSpeedsAreTurned) {
  const ModelFolder model = two_links("actuator = \"passive\"\n");
  const SimParams params = make_params(model);
  const Drive drive = make_test_drive(model, 0.8, 0.01, kNoCommand);
  const std::vector<double> q{0.9, -0.4}, dq{0.3, -0.6};
  const Prediction there = run(params, drive, q, dq);
  std::vector<double> turned = at_row(there, there.dq, there.rows - 1);
  for (double& v : turned) v = -v;
  const Prediction back = run(params, drive, at_row(there, there.q, there.rows - 1), turned);
  for (std::size_t j = 0; j < 2; ++j) {
    EXPECT_NEAR(at_row(back, back.q, back.rows - 1)[j], q[j], 2e-4);
    EXPECT_NEAR(at_row(back, back.dq, back.rows - 1)[j], -dq[j], 2e-3);
  }
}

TEST(Conservation, PositionsConvergeAtLeastWithTheSquareOfTheStep) {
  const ModelFolder model = two_links("actuator = \"position_pd\"\nkp = 20\nkd = 0.5\n");
  const SimParams params = make_params(model);
  const Drive drive =
      make_test_drive(model, 1.0, 0.02, [](int j, double t) { return 0.5 * std::sin(6 * t + j); });
  const auto end_with = [&](double h) {
    const Prediction p = run(params, drive, {0, 0}, {0, 0}, h);
    return at_row(p, p.q, p.rows - 1)[0];
  };
  const double exact = end_with(2.5e-4), coarse = end_with(4e-3), fine = end_with(2e-3);
  EXPECT_GT(std::abs(coarse - exact), 3.5 * std::abs(fine - exact));
}

/// J, of the pendulum without a rotor.
double pendulum_energy(const Prediction& p, std::size_t row) {
  return 0.5 * (0.005 + 1e-6) * p.dq[row] * p.dq[row] - 0.5 * 9.81 * 0.1 * std::cos(p.q[row]);
}

TEST(Conservation, ViscousFrictionTakesExactlyThePowerItShould) {
  const ModelFolder model = pendulum("actuator = \"passive\"\nviscous = 0.01\n");
  const SimParams params = make_params(model);
  const Drive drive = make_test_drive(model, 3.0, 0.001, kNoCommand);
  const Prediction p = run(params, drive, {1.2}, {0.0});
  double lost = 0.0;
  for (std::size_t r = 1; r < p.rows; ++r)
    lost += 0.001 * 0.01 * std::pow(0.5 * (p.dq[r] + p.dq[r - 1]), 2);
  EXPECT_NEAR(pendulum_energy(p, 0) - pendulum_energy(p, p.rows - 1), lost, 1e-3 * lost);
}

TEST(Conservation, DryFrictionTakesItsTorqueTimesTheWay) {
  const ModelFolder model = pendulum("actuator = \"passive\"\ncoulomb = 0.02\n");
  const SimParams params = make_params(model);
  const Drive drive = make_test_drive(model, 1.0, 0.001, kNoCommand);
  const Prediction p = run(params, drive, {1.2}, {0.0});
  double way = 0.0;
  for (std::size_t r = 1; r < p.rows; ++r) way += std::abs(p.q[r] - p.q[r - 1]);
  EXPECT_NEAR(pendulum_energy(p, 0) - pendulum_energy(p, p.rows - 1), 0.02 * way,
              2e-3 * way * 0.02 + 1e-5);
}

TEST(Conservation, AFreeSliderKeepsItsSpeedAndAFallingOneGains) {
  ModelFolder model = slider("actuator = \"passive\"\n");
  const Drive drive = make_test_drive(model, 0.5, 0.01, kNoCommand);
  const Prediction falls = run(make_params(model), drive, {0.0}, {0.4});
  // the rail is pitched by 0.3 rad: x points down by sin 0.3
  const double a = 9.81 * std::sin(0.3);
  EXPECT_NEAR(falls.dq.back(), 0.4 + a * 0.5, 1e-9);
  EXPECT_NEAR(falls.q.back(), 0.2 + 0.5 * a * 0.25, 1e-9);
  model.gravity = {0, 0, 0};
  const Prediction free = run(make_params(model), drive, {0.0}, {0.4});
  EXPECT_NEAR(free.dq.back(), 0.4, 1e-12);
}

TEST(Symmetry, AMirroredPendulumSwingsTheMirroredWay) {
  const ModelFolder model =
      pendulum("actuator = \"dc_servo\"\ncoulomb = 0.03\nviscous = 0.02\narmature = 0.01\n");
  SimParams params = make_params(model);
  params.joints[0].backlash = 0.02;
  for (const double side : {1.0, -1.0}) params.joints[0].dead_zone = 0.01 * std::abs(side);
  const auto sweep = [](double sign) {
    return [sign](int, double t) { return sign * 0.7 * std::sin(4 * t); };
  };
  const Drive right = make_test_drive(model, 2.0, 0.01, sweep(1.0)),
              left = make_test_drive(model, 2.0, 0.01, sweep(-1.0));
  const Prediction a = run(params, right, {0.1}, {0.5}), b = run(params, left, {-0.1}, {-0.5});
  for (std::size_t r = 0; r < a.rows; ++r) {
    EXPECT_EQ(b.q[r], -a.q[r]);
    EXPECT_EQ(b.pwm[r], -a.pwm[r]);
    EXPECT_EQ(b.i[r], -a.i[r]);
  }
}

TEST(Symmetry, TheStartOfTheClockDoesNotMatter) {
  const ModelFolder model = two_links("actuator = \"position_pd\"\nkp = 20\nkd = 1\n");
  const auto command = [](int j, double t) { return 0.3 * std::sin(5 * t + j); };
  const Drive drive = make_test_drive(model, 1.0, 0.01, command);
  Drive late = drive;
  for (double& t : late.t) t += 32.0;
  const SimParams params = make_params(model);
  const Prediction a = run(params, drive, {0, 0}, {0, 0}), b = run(params, late, {0, 0}, {0, 0});
  for (std::size_t k = 0; k < a.q.size(); ++k) EXPECT_NEAR(a.q[k], b.q[k], 1e-9);
}

TEST(Symmetry, MassesAndTorquesScaledTogetherMoveTheSame) {
  const auto moved = [](double factor) {
    ModelFolder model = two_links("actuator = \"torque\"\ntorque_limit = 0\nviscous = " +
                                  std::to_string(0.05 * factor) + "\n");
    for (TreeJoint& joint : model.tree.joints) {
      joint.body.mass *= factor;
      for (double& I : joint.body.about_com) I *= factor;
    }
    const Drive drive = make_test_drive(
        model, 1.0, 0.01, [&](int j, double t) { return factor * 0.4 * std::sin(4 * t + j); });
    return run(make_params(model), drive, {0.2, 0.1}, {0, 0});
  };
  const Prediction a = moved(1.0), b = moved(8.0);
  for (std::size_t k = 0; k < a.q.size(); ++k) EXPECT_NEAR(a.q[k], b.q[k], 1e-9);
}

}  // namespace
}  // namespace sanso::diagnose
