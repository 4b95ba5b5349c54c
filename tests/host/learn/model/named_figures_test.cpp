// Figures under their names: against formulas written here, and refused without a trace.
#include "host/learn/model/named_figures.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "shared/model/joints.h"

namespace sanso::learn {
namespace {

using model::ModelParameters;

bool same(const ModelParameters& a, const ModelParameters& b) {
  return std::memcmp(&a, &b, sizeof(a)) == 0;
}

TEST(NamedFigures, ServosChangeWhereTheyAreNamed) {
  const ModelParameters nominal = model::nominal_parameters();
  ModelParameters theta = nominal;
  EXPECT_EQ(put_figure({"servo_p_gain", {"l_knee", "r_knee"}, {{"gain", 0.6}}}, theta), "");
  EXPECT_EQ(put_figure({"viscous_friction", {"l_knee"}, {{"viscous", 0.2}}}, theta), "");
  EXPECT_EQ(put_figure({"coulomb_friction", {"r_hip_yaw"}, {{"coulomb", 0.1}}}, theta), "");
  EXPECT_EQ(put_figure({"rotor_inertia", {"r_hip_yaw"}, {{"armature", 0.01}}}, theta), "");
  for (int j = 0; j < model::kNumJoints; ++j) {
    const std::string name = model::kJoints[static_cast<std::size_t>(j)].name;
    const bool knee = name == "l_knee" || name == "r_knee", yaw = name == "r_hip_yaw";
    EXPECT_DOUBLE_EQ(theta.servo[j].stiffness, nominal.servo[j].stiffness * (knee ? 0.6 : 1.0));
    EXPECT_DOUBLE_EQ(theta.servo[j].damping,
                     nominal.servo[j].damping + (name == "l_knee" ? 0.2 : 0.0));
    EXPECT_DOUBLE_EQ(theta.servo[j].coulomb, nominal.servo[j].coulomb + (yaw ? 0.1 : 0.0));
    EXPECT_DOUBLE_EQ(theta.servo[j].armature, nominal.servo[j].armature + (yaw ? 0.01 : 0.0));
  }
}

TEST(NamedFigures, ZerosAreReadTooMuchAndLagsOfJointsAreTheirMean) {
  ModelParameters theta = model::nominal_parameters();
  ASSERT_EQ(
      put_figure({"encoder_offset", {"l_knee"}, {{"offset", 0.03}, {"of_record", 0.0}}}, theta),
      "");
  for (int j = 0; j < model::kNumJoints; ++j)
    EXPECT_DOUBLE_EQ(
        theta.servo[j].zero,
        model::kJoints[static_cast<std::size_t>(j)].name == std::string("l_knee") ? 0.03 : 0.0);
  std::vector<std::string> all;
  for (const model::JointInfo& joint : model::kJoints) all.emplace_back(joint.name);
  ASSERT_EQ(put_figure({"command_delay", all, {{"delay", 0.012}}}, theta), "");
  EXPECT_NEAR(theta.target_lag_s, 0.012, 1e-12);
  ASSERT_EQ(put_figure({"command_delay", {"l_knee"}, {{"delay", 0.012}}}, theta), "");
  EXPECT_NEAR(theta.target_lag_s, 0.013, 1e-12);
}

TEST(NamedFigures, APayloadKeepsTheMomentsOfAllThatIsThere) {
  const ModelParameters nominal = model::nominal_parameters();
  ModelParameters theta = nominal;
  const double m = 0.5, at[3] = {0.05, -0.03, 0.12};
  ASSERT_EQ(put_figure(
                {"payload", {"body_link"}, {{"mass", m}, {"x", at[0]}, {"y", at[1]}, {"z", at[2]}}},
                theta),
            "");
  const model::BodyInertia &a = nominal.body[0], &b = theta.body[0];
  EXPECT_NEAR(b.mass, a.mass + m, 1e-12);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(b.mass * b.com[i], a.mass * a.com[i] + m * at[i], 1e-12);
  // about the link's origin moments of inertia add up: xx and xy
  const auto about_origin = [](const model::BodyInertia& body, int k) {
    const double* c = body.com;
    return k == 0 ? body.inertia[0] + body.mass * (c[1] * c[1] + c[2] * c[2])
                  : body.inertia[1] - body.mass * c[0] * c[1];
  };
  EXPECT_NEAR(about_origin(b, 0), about_origin(a, 0) + m * (at[1] * at[1] + at[2] * at[2]), 1e-12);
  EXPECT_NEAR(about_origin(b, 1), about_origin(a, 1) - m * at[0] * at[1], 1e-12);
}

TEST(NamedFigures, MassAndGroundChangeAsTheirNamesSay) {
  const ModelParameters nominal = model::nominal_parameters();
  ModelParameters theta = nominal;
  ASSERT_EQ(put_figure({"link_mass", {"base"}, {{"share", 0.2}}}, theta), "");
  EXPECT_DOUBLE_EQ(theta.body[0].mass, 1.2 * nominal.body[0].mass);
  EXPECT_DOUBLE_EQ(theta.body[0].inertia[0], 1.2 * nominal.body[0].inertia[0]);
  ASSERT_EQ(put_figure({"link_com", {"body_link"}, {{"x", 0.02}}}, theta), "");
  EXPECT_DOUBLE_EQ(theta.body[0].com[0], nominal.body[0].com[0] + 0.02);
  ASSERT_EQ(put_figure({"contact_friction", {}, {{"mu", 0.4}}}, theta), "");
  EXPECT_DOUBLE_EQ(theta.friction_forward, 0.4);
  EXPECT_DOUBLE_EQ(theta.friction_sideways, 0.4);
}

TEST(NamedFigures, WhatItCannotHoldIsRefusedAndNothingChanges) {
  const ModelParameters nominal = model::nominal_parameters();
  for (const NamedFigure& figure :
       std::vector<NamedFigure>{{"imu_misalignment", {"body_link"}, {{"x", 0.1}}},
                                {"servo_p_gain", {"elbow"}, {{"gain", 0.5}}},
                                {"encoder_offset", {"l_knee"}, {{"offset", 0.1}, {"of_record", 1}}},
                                {"command_delay", {"l_knee"}, {{"delay", 0.6}}},
                                {"command_delay", {"l_knee"}, {{"delay", -0.01}}},
                                {"servo_p_gain", {}, {{"gain", 0.5}}},
                                {"servo_p_gain", {"l_knee", "elbow"}, {{"gain", 0.5}}},
                                {"servo_p_gain", {"l_knee"}, {{"gain", -0.5}}},
                                {"viscous_friction", {"l_knee"}, {{"viscous", -50.0}}},
                                {"link_mass", {"body_link"}, {{"share", -1.5}}},
                                {"link_mass", {"wing"}, {{"share", 0.1}}},
                                {"contact_friction", {}, {{"mu", 0.0}}},
                                {"servo_p_gain", {"l_knee"}, {{"gain", NAN}}}}) {
    ModelParameters theta = nominal;
    EXPECT_NE(put_figure(figure, theta), "") << figure.effect;
    EXPECT_TRUE(same(theta, nominal)) << figure.effect;
  }
}

}  // namespace
}  // namespace sanso::learn
