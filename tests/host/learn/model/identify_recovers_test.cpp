// A whole search finds what makes a robot differ from the model: minutes under the sanitizers, so a
// file of its own.
#include <gtest/gtest.h>

#include "tests/host/learn/model/identify_windows.h"

namespace sanso::learn {
namespace {

double total_mass(const model::ModelParameters& theta) {
  double sum = 0;
  for (const auto& body : theta.body) sum += body.mass;
  return sum;
}

TEST(Identify, RecoversStiffnessPerMassAndCentreOfMass) {
  model::ModelParameters truth = model::nominal_parameters();
  for (auto& servo : truth.servo) servo.stiffness *= 0.7;
  truth.body[0].com[0] += 0.015;
  const auto windows = windows_of_world(truth, 64);
  const ParameterMap map(model::nominal_parameters());
  IdentifySettings settings;
  settings.search.generations = 30;
  settings.prior_weight = 0.005;
  const Identification found =
      identify(windows, map, model::make_plane(), state_weights(), settings, kSeed);
  EXPECT_LT(found.loss, 0.05 * found.loss_initial);
  // Positions alone do not tell the scale of all forces together: stiffness is known relative to
  // the robot's mass.
  const double mass_ratio = total_mass(found.parameters) / total_mass(truth);
  double stiffness_ratio = 0;
  for (int j = 0; j < model::kNumJoints; ++j) {
    stiffness_ratio +=
        found.parameters.servo[j].stiffness / truth.servo[j].stiffness / model::kNumJoints;
  }
  EXPECT_NEAR(stiffness_ratio / mass_ratio, 1.0, 0.05);
  EXPECT_NEAR(found.parameters.body[0].com[0], truth.body[0].com[0], 0.004);
}

}  // namespace
}  // namespace sanso::learn
