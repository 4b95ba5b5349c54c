// Laws that every effect of the library obeys on every small robot: nothing at its null, a
// derivative where one is promised, finite inside its bounds, the same motion for a robot of twice
// the torques, the same bits out of a model folder, and the same robot as the setting that it is.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "tests/support/temp_folder.h"
#include "tests/tools/diagnose/effects/small_trials.h"
#include "tools/diagnose/effects/from_model.h"

namespace sanso::diagnose {
namespace {

using namespace test;

/// Positions and velocities of all windows, one after the other.
Values moved(const std::vector<Prediction>& predictions) {
  Values out;
  for (const Prediction& p : predictions) {
    out.insert(out.end(), p.q.begin(), p.q.end());
    out.insert(out.end(), p.dq.begin(), p.dq.end());
  }
  return out;
}

double worst(const Values& a, const Values& b) {
  double most = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

class EveryEffectOnEveryRobot : public testing::TestWithParam<std::string> {
 protected:
  const Effect& effect_ = *find_effect(GetParam());
};

TEST_P(EveryEffectOnEveryRobot, ChangesNoBitAtItsNull) {
  for (const Trial& trial : trials()) {
    EXPECT_TRUE(identical(trial.predict(trial.with(effect_, trial.null(effect_))),
                          trial.predict(make_params(trial.model))))
        << trial.name;
  }
}

TEST_P(EveryEffectOnEveryRobot, HasItsNullBetweenItsBoundsThere) {
  for (const Trial& trial : trials()) {
    for (const EffectParameter& p : trial.parameters(effect_)) {
      EXPECT_LE(p.low, p.null) << trial.name << ' ' << p.name;
      EXPECT_LE(p.null, p.high) << trial.name << ' ' << p.name;
    }
  }
}

/// Each parameter alone at either bound, beside a size at which the effect acts.
TEST_P(EveryEffectOnEveryRobot, MovesFinitelyInsideItsBounds) {
  for (const Trial& trial : trials()) {
    const std::vector<EffectParameter> parameters = trial.parameters(effect_);
    for (const Values& start : scaled_probes(effect_, trial.scale)) {
      for (std::size_t k = 0; k < parameters.size(); ++k) {
        for (const double bound : {parameters[k].low, parameters[k].high}) {
          Values theta = start;
          theta[k] = bound;
          for (const double x : moved(trial.predict(trial.with(effect_, theta))))
            ASSERT_TRUE(std::isfinite(x)) << trial.name << ' ' << parameters[k].name << bound;
        }
      }
    }
  }
}

/// Slopes of the prediction from the null by two steps agree, and so do both sides. What a typical
/// size does not move by 1e-5 rad has the derivative 0 there.
TEST_P(EveryEffectOnEveryRobot, HasADerivativeAtItsNullWhenItIsSmooth) {
  if (!effect_.smooth) GTEST_SKIP() << "judged by probes";
  constexpr double kShare = 1e-3;  // of the typical size
  for (Trial trial : trials()) {
    // sticking is a kink of the robot's own
    for (JointSettings& s : trial.model.joints) s.coulomb = 0.0;
    const std::vector<EffectParameter> parameters = trial.parameters(effect_);
    const Values nominal = moved(trial.predict(make_params(trial.model)));
    for (std::size_t k = 0; k < parameters.size(); ++k) {
      const EffectParameter& p = parameters[k];
      if (p.structural || p.role == Role::delay) continue;
      const auto slope = [&](double step) {
        Values theta = trial.null(effect_);
        theta[k] += step;
        Values y = moved(trial.predict(trial.with(effect_, theta)));
        for (std::size_t i = 0; i < y.size(); ++i) y[i] = (y[i] - nominal[i]) / step;
        return y;
      };
      const double h = kShare * p.typical * (p.null < p.high ? 1.0 : -1.0);
      const Values full = slope(h);
      const double size = worst(full, Values(full.size(), 0.0));
      const double allowed = 0.05 * std::max(size, 1e-5 / p.typical);
      EXPECT_LE(worst(full, slope(0.5 * h)), allowed) << trial.name << ' ' << p.name;
      if (p.low == p.null || p.null == p.high) continue;
      const SimParams params = make_params(trial.model);
      bool gives = true;  // no body gives inertia that it has not
      for (std::size_t j = 0; j < params.tree.joints.size(); ++j)
        gives = gives && (!effect_.lowest || effect_.lowest(params, j) < p.null - h);
      if (!gives) continue;
      EXPECT_LE(worst(full, slope(-h)), allowed) << trial.name << ' ' << p.name;
    }
  }
}

/// Twice the masses, rotors, gains and torques: the same motion, with the effect twice as large in
/// what is torque and as it was in what is not. A power of two keeps every rounding.
TEST_P(EveryEffectOnEveryRobot, IsOneAndTheSameOnARobotOfTwiceTheTorques) {
  for (const Trial& trial : trials()) {
    Trial strong = trial;
    for (JointSettings& s : strong.model.joints) {
      for (double* x :
           {&s.kp, &s.kd, &s.torque_limit, &s.torque_constant, &s.armature, &s.viscous, &s.coulomb})
        *x *= 2.0;
    }
    for (TreeJoint& joint : strong.model.tree.joints) {
      joint.body.mass *= 2.0;
      for (double& i : joint.body.about_com) i *= 2.0;
    }
    for (std::size_t j = 0; j < strong.drive.joints.size(); ++j) {
      if (strong.model.joints[j].actuator != Actuator::torque) continue;
      for (double& u : strong.drive.joints[j].command) u *= 2.0;
    }
    strong.scale.torque *= 2.0;
    strong.scale.inertia *= 2.0;
    const std::vector<Values> here = scaled_probes(effect_, trial.scale);
    const std::vector<Values> there = scaled_probes(effect_, strong.scale);
    for (std::size_t i = 0; i < here.size(); ++i) {
      EXPECT_LE(worst(moved(trial.predict(trial.with(effect_, here[i]))),
                      moved(strong.predict(strong.with(effect_, there[i])))),
                1e-9)
          << trial.name << " probe " << i;
    }
  }
}

TEST_P(EveryEffectOnEveryRobot, ComesBackFromAModelFolderBitForBit) {
  const sanso::test::TempFolder folder;
  for (const Trial& trial : trials()) {
    for (const Values& theta : scaled_probes(effect_, trial.scale)) {
      EffectInstance instance{&effect_, {}, theta};
      for (const TreeJoint& joint : trial.model.tree.joints) {
        if (effect_.scope == Scope::robot) break;
        instance.where.push_back(effect_.scope == Scope::link ? joint.link : joint.name);
      }
      write_model_folder(test::hiding(trial.model, {entry_of(instance)}), folder.path().string());
      const ModelFolder back = read_model_folder(folder.path().string());
      EXPECT_TRUE(identical(trial.predict(params_with_effects(back)),
                            trial.predict(trial.with(effect_, theta))))
          << trial.name;
    }
  }
}

/// Where model.toml has a key for a parameter, the changed key is the same robot. What is added
/// changes no bit; a product is rounded in another order.
TEST_P(EveryEffectOnEveryRobot, IsTheSettingThatItSaysItIs) {
  ASSERT_LE(effect_.settings.size(), effect_.parameters.size());
  ASSERT_LE(effect_.identified.size(), effect_.parameters.size());
  for (const Trial& trial : trials()) {
    const std::vector<EffectParameter> parameters = trial.parameters(effect_);
    for (std::size_t k = 0; k < effect_.settings.size(); ++k) {
      Values theta = trial.null(effect_);
      theta[k] += 0.7 * parameters[k].typical;
      ModelFolder changed = trial.model;
      bool said = true;
      for (JointSettings& joint : changed.joints)
        said = effect_.fold_into(joint, k, theta[k]) && said;
      const auto only = effect_.settings[k].only;
      EXPECT_EQ(said, !only || *only == trial.model.joints.front().actuator) << trial.name;
      if (!said) continue;
      const double rounding = effect_.settings[k].how == SettingChange::How::added ? 0.0 : 1e-9;
      EXPECT_LE(worst(moved(trial.predict(make_params(changed))),
                      moved(trial.predict(trial.with(effect_, theta)))),
                rounding)
          << trial.name << ' ' << parameters[k].name;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Library, EveryEffectOnEveryRobot, testing::ValuesIn(simulated_ids()),
                         [](const auto& p) { return p.param; });

/// A key that would leave its range changes nothing: the caller then writes an [[effect]].
TEST(FoldInto, LeavesSettingsAloneWhereTheyCannotSayIt) {
  JointSettings s;
  s.viscous = 0.1;
  const JointSettings before = s;
  EXPECT_FALSE(find_effect("viscous_friction")->fold_into(s, 0, -0.2));
  EXPECT_FALSE(find_effect("encoder_offset")->fold_into(s, 0, 0.01));
  EXPECT_FALSE(find_effect("torque_constant")->fold_into(s, 7, 1.1));
  s.actuator = Actuator::torque;
  EXPECT_FALSE(find_effect("torque_constant")->fold_into(s, 0, 1.1));
  s.actuator = before.actuator;
  EXPECT_EQ(s, before);
  EXPECT_TRUE(find_effect("viscous_friction")->fold_into(s, 0, -0.05));
  EXPECT_NEAR(s.viscous, 0.05, 1e-15);
}

/// What a nominal model may be wrong by is a direction in the parameters of an effect that has a
/// simulation, told apart by name and order.
TEST(Tolerances, AreDirectionsOfTheirEffects) {
  std::vector<std::string_view> names;
  int order = 0;
  for (const auto& [effect, tolerance] : tolerated_quantities()) {
    EXPECT_EQ(std::count(names.begin(), names.end(), tolerance->name), 0) << tolerance->name;
    names.push_back(tolerance->name);
    EXPECT_GT(tolerance->order, std::exchange(order, tolerance->order)) << tolerance->name;
    EXPECT_TRUE(effect->apply) << tolerance->name;
    bool anywhere = false;
    for (const Trial& trial : trials()) {
      const SimParams params = make_params(trial.model);
      for (std::size_t j = 0; j < params.joints.size(); ++j) {
        const Values direction = tolerance->direction(params, j);
        if (direction.empty()) continue;
        ASSERT_EQ(direction.size(), effect->parameters.size()) << tolerance->name;
        EXPECT_GT(worst(direction, Values(direction.size(), 0.0)), 0.0) << tolerance->name;
        anywhere = true;
      }
    }
    EXPECT_TRUE(anywhere) << tolerance->name;
  }
}

/// Friction takes energy: a free pendulum never rises above where it began. (What differs between
/// directions, or along the angle, is a difference from a friction that has to be there.)
TEST(FrictionEffects, TakeEnergyAndGiveNone) {
  const ModelFolder model = test::pendulum("actuator = \"passive\"\n");
  Drive drive = test::make_test_drive(model, 3.0, 0.005, [](int, double) { return 0.0; });
  drive.joints[0].temp.assign(drive.rows(), 60.0);
  const double over_inertia = 0.5 * 9.81 * 0.1 / (0.5 * 0.01 + 1e-6);
  for (const Effect& effect : library()) {
    if (effect.family != Family::friction || effect.sign <= 0) continue;
    for (const Values& theta : effect.probes) {
      SimParams params = make_params(model);
      effect.apply(params, 0, theta);
      const Prediction p =
          simulate(params, drive, std::vector{test::whole(drive, {0.8}, {0.0})}).front();
      double most = 0.0;
      for (std::size_t r = 0; r < p.rows; ++r) {
        const double height = over_inertia * (1.0 - std::cos(p.q[r]));
        most = std::max(most, height + 0.5 * p.dq[r] * p.dq[r]);
      }
      EXPECT_LE(most, over_inertia * (1.0 - std::cos(0.8)) * (1.0 + 1e-3)) << effect.id;
    }
  }
}

}  // namespace
}  // namespace sanso::diagnose
