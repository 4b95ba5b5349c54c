// A smooth arm in MuJoCo, which reads the same URDF by its own code, against our simulator.
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <memory>

#include "tests/support/small_world.h"

namespace sanso::diagnose {
namespace {

double command(int j, double t) { return (j == 2 ? 2.0 : 1.2) * std::sin((3.0 + j) * t + 0.5 * j); }

TEST(SimulatorAgainstMuJoCo, SmoothArmUnderTorques) {
  const auto path = std::filesystem::temp_directory_path() /
                    ("sanso_arm_" + std::to_string(::getpid()) + ".urdf");
  std::ofstream(path) << test::kArmUrdf;
  char error[500] = {};
  const std::unique_ptr<mjModel, void (*)(mjModel*)> model(
      mj_loadXML(path.c_str(), nullptr, error, sizeof error), mj_deleteModel);
  std::filesystem::remove(path);
  ASSERT_NE(model, nullptr) << error;
  ASSERT_EQ(model->nv, 3);
  model->opt.timestep = 2e-4;
  model->opt.integrator = mjINT_RK4;
  model->opt.disableflags |= mjDSBL_LIMIT | mjDSBL_CONTACT;
  for (int j = 0; j < 3; ++j) {
    model->dof_damping[j] = 0.05;
    model->dof_armature[j] = 0.01;
  }
  const std::unique_ptr<mjData, void (*)(mjData*)> data(mj_makeData(model.get()), mj_deleteData);
  data->qpos[0] = 0.2;
  data->qpos[1] = -0.1;

  const ModelFolder ours =
      test::arm("actuator = \"torque\"\ntorque_limit = 0\nviscous = 0.05\narmature = 0.01\n");
  const Drive drive = test::make_test_drive(ours, 3.0, 0.002, command);
  const auto out = simulate(make_params(ours), drive,
                            std::vector{test::whole(drive, {0.2, -0.1, 0}, {0, 0, 0})});

  for (std::size_t r = 0; r + 1 < drive.rows(); ++r) {
    for (int j = 0; j < 3; ++j) {
      ASSERT_NEAR(out[0].of(out[0].q, j)[r], data->qpos[j], 1e-4)
          << "joint " << j << " at " << drive.t[r] << " s";  // second order: h = 1 ms
      data->qfrc_applied[j] = command(j, drive.t[r]);        // held, as in the recording
    }
    for (int s = 0; s < 10; ++s) mj_step(model.get(), data.get());
  }
  EXPECT_GT(std::abs(data->qpos[0]) + std::abs(data->qpos[1]), 0.1) << "the arm moved";
}

}  // namespace
}  // namespace sanso::diagnose
