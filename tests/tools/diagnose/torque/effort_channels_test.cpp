// Which column an effort is read from, how it becomes rows, and the scale of a drive that states
// none.
#include "tools/diagnose/torque/effort_channels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "shared/files/input_error.h"
#include "tests/support/made_effort.h"
#include "tools/diagnose/torque/drive_gain.h"

namespace sanso::diagnose {
namespace {

using namespace test;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr const char* kTorque = "actuator = \"torque\"\nviscous = 0.05\narmature = 0.01\n";

/// Four instants with these columns, each holding its place in the list (from 1).
recording::Recording with_columns(const std::vector<std::string>& columns) {
  recording::Recording r;
  r.file = "made.csv";
  r.t = {0.0, 0.01, 0.02, 0.03};
  double value = 1.0;
  for (const std::string& column : columns) r.set(column, std::vector<double>(4, value++));
  return r;
}

EffortChannel channel(const ModelFolder& model, const recording::Recording& r,
                      bool free_gain = false) {
  return effort_channels(r, make_params(model), free_gain).front();
}

TEST(EffortChannels, WhatWasMeasuredComesBeforeWhatWasAskedFor) {
  const std::vector<std::string> all{"q:a", "tau_cmd:a", "pwm:a", "i:a", "tau:a"};
  struct Case {
    const char* actuator;
    std::vector<std::string> order;  // of preference
  };
  for (const Case& c :
       {Case{"torque", {"tau:a", "tau_cmd:a", "i:a", "pwm:a"}},
        Case{"dc_servo", {"tau:a", "i:a", "pwm:a"}}, Case{"position_pd", {"tau:a", "i:a", "pwm:a"}},
        Case{"passive", {"tau:a"}}}) {
    const std::string kp = std::string(c.actuator) == "position_pd" ? "kp = 3\n" : "";
    const ModelFolder model = pendulum("actuator = \"" + std::string(c.actuator) + "\"\n" + kp);
    recording::Recording r = with_columns(all);
    for (const std::string& best : c.order) {
      EXPECT_EQ(channel(model, r).column, best) << c.actuator;
      EXPECT_TRUE(channel(model, r).known);
      std::erase_if(r.channels, [&](const auto& x) { return x.name == best; });
    }
    EXPECT_EQ(channel(model, r).column, "") << c.actuator;
    EXPECT_EQ(channel(model, r).known, std::string(c.actuator) == "passive");
  }
}

TEST(EffortChannels, ACurrentWithoutASignIsNoEffort) {
  const ModelFolder model = pendulum("actuator = \"position_pd\"\nkp = 3\n");
  recording::Recording r;
  r.file = "made.csv";
  std::vector<double> q, current, duty;
  for (int k = 0; k < 100; ++k) {
    r.t.push_back(0.01 * k);
    q.push_back(std::sin(0.2 * k));
    duty.push_back(std::cos(0.2 * k)), current.push_back(std::abs(duty.back()));
  }
  r.set("q:a", q), r.set("i:a", current), r.set("pwm:a", duty);
  EXPECT_EQ(channel(model, r).column, "pwm:a");
  r.set("i:a", duty);
  EXPECT_EQ(channel(model, r).column, "i:a");
  // a joint that only rises may need one sign alone
  for (std::size_t k = 0; k < q.size(); ++k) q[k] = 0.01 * static_cast<double>(k);
  r.set("q:a", q), r.set("i:a", current);
  EXPECT_EQ(channel(model, r).column, "i:a");
}

TEST(EffortChannels, APassiveJointGivesNothing) {
  const EffortChannel none = channel(pendulum("actuator = \"passive\"\n"), with_columns({"q:a"}));
  EXPECT_EQ(none.effort, std::vector<double>(4, 0.0));
  EXPECT_FALSE(none.gain_unknown);
}

TEST(EffortChannels, ACurrentIsTorqueOnlyWhereTheConstantIsStated) {
  const recording::Recording r = with_columns({"q:a", "i:a"});
  const ModelFolder servo = pendulum("actuator = \"dc_servo\"\n");
  const EffortChannel stated = channel(servo, r);
  EXPECT_EQ(stated.unit, "N m");
  EXPECT_FALSE(stated.gain_unknown);
  EXPECT_NEAR(stated.effort[2], 2.0 * servo.joints[0].torque_constant, 1e-12);
  const EffortChannel unstated = channel(pendulum(kTorque), r);
  EXPECT_EQ(unstated.unit, "A");
  EXPECT_TRUE(unstated.gain_unknown);
  EXPECT_EQ(unstated.effort[2], 2.0);
  EXPECT_EQ(channel(pendulum(kTorque), with_columns({"pwm:a"})).unit, "duty");
}

TEST(EffortChannels, AFreeGainIsOfWhatWasRecorded) {
  EXPECT_TRUE(channel(pendulum(kTorque), with_columns({"q:a", "tau:a"}), true).gain_unknown);
  EXPECT_FALSE(channel(pendulum(kTorque), with_columns({"q:a", "tau:a"}), false).gain_unknown);
  EXPECT_FALSE(
      channel(pendulum("actuator = \"passive\"\n"), with_columns({"q:a"}), true).gain_unknown);
}

TEST(EffortChannels, ACommandThatIsMissingIsAMotorSwitchedOff) {
  recording::Recording r = with_columns({"q:a", "tau_cmd:a"});
  r.set("tau_cmd:a", {0.5, kNaN, -0.5, kNaN});
  EXPECT_EQ(channel(pendulum(kTorque), r).effort, (std::vector<double>{0.5, 0.0, -0.5, 0.0}));
  // a measurement that is missing is not known
  r.set("tau:a", {0.5, kNaN, -0.5, kNaN});
  EXPECT_TRUE(std::isnan(channel(pendulum(kTorque), r).effort[1]));
}

TEST(EffortChannels, ASlideHasForces) {
  const EffortChannel c = channel(slider(kTorque), with_columns({"q:s", "force_cmd:s"}));
  EXPECT_EQ(c.column, "force_cmd:s");
  EXPECT_EQ(c.unit, "N");
}

TEST(EffortChannels, ADutyIsTheTorqueThatTheServoGave) {
  const ModelFolder servo = pendulum("actuator = \"dc_servo\"\np_gain = 4.0\narmature = 0.02\n");
  const Drive drive =
      make_test_drive(servo, 3.0, 0.002, [](int, double t) { return 0.5 * std::sin(3.0 * t); });
  const Prediction p =
      simulate(make_params(servo), drive, std::vector<Window>{whole_from_rest(drive)}).front();
  Recorded how;
  how.duty = true;
  recording::Recording r = record(servo, drive, how);
  const auto error = [&](const recording::Recording& of) {
    const std::vector<double> effort = channel(servo, of).effort;
    double sum = 0.0, all = 0.0;
    for (std::size_t k = 1; k + 1 < effort.size(); ++k) {
      sum += std::pow(effort[k] - p.tau[k], 2.0);
      all += p.tau[k] * p.tau[k];
    }
    return std::sqrt(sum / all);
  };
  EXPECT_LT(error(r), 0.1);
  how.velocity = true;
  r = record(servo, drive, how);
  EXPECT_LT(error(r), 0.1);
}

TEST(EffortChannels, TheRecordedSupplyStandsForTheStatedOneUntilItIsReadAgain) {
  const ModelFolder servo = pendulum("actuator = \"dc_servo\"\n");
  recording::Recording r = with_columns({"pwm:a", "q:a"});
  r.set("dq:a", {0.0, 0.0, 0.0, 2.0});
  r.set("volt", {kNaN, 10.0, kNaN, 8.0});
  const JointSettings& s = servo.joints.front();
  const std::vector<double> effort = channel(servo, r).effort;
  const double stalled = s.torque_constant / s.resistance;  // N m/V
  EXPECT_NEAR(effort[0], stalled * s.voltage, 1e-9);
  EXPECT_NEAR(effort[1], stalled * 10.0, 1e-9);
  EXPECT_NEAR(effort[2], stalled * 10.0, 1e-9);
  EXPECT_NEAR(effort[3], stalled * (8.0 - 2.0 * s.back_emf), 1e-9);
}

/// A swing of ten seconds under two sines.
recording::Recording swing(const ModelFolder& world) {
  return record(world, make_test_drive(world, 10.0, 0.004, [](int j, double t) {
                  return 0.4 * std::sin((2.1 + 1.3 * j) * t) + 0.2 * std::sin(5.3 * t + j);
                }));
}

TEST(EffortRows, OfTheWorldItselfAreWhatTheModelNeeds) {
  const ModelFolder model = two_links(kTorque);
  const EffortRows rows = effort_rows(model, {swing(model), swing(model)}, false, Settings{});
  double left = 0.0, all = 0.0;
  for (const EffortRow& row : rows.rows) {
    left += std::pow(row.effort - row.nominal, 2.0), all += row.effort * row.effort;
    const EffortRecording& r = rows.recordings[static_cast<std::size_t>(row.recording)];
    double mean = 0.0;
    for (std::size_t k = row.first; k < row.last; ++k) {
      EXPECT_EQ(r.moves[static_cast<std::size_t>(row.joint)][k], 1);
      mean += r.effort[static_cast<std::size_t>(row.joint)][k];
    }
    EXPECT_NEAR(row.effort, mean / static_cast<double>(row.last - row.first), 1e-12);
    EXPECT_EQ(rows.recording_of_block[row.block], row.recording);
  }
  EXPECT_GT(rows.rows.size(), 800u);
  EXPECT_LT(left, 0.01 * all);
}

TEST(EffortRows, WindowsAreOfTheSettingsLengthAndDoNotOverlap) {
  const ModelFolder model = pendulum(kTorque);
  Settings settings;
  settings.effort.window = 0.1;
  const EffortRows rows = effort_rows(model, {swing(model)}, false, settings);
  std::size_t before = 0;
  for (const EffortRow& row : rows.rows) {
    EXPECT_EQ(row.last - row.first, 25u);
    EXPECT_GE(row.first, before);
    before = row.last;
  }
  EXPECT_EQ(rows.blocks, rows.recording_of_block.size());
}

TEST(EffortRows, SayNothingWhereAJointStandsOrItsEffortIsMissing) {
  const ModelFolder model = pendulum(kTorque);
  recording::Recording r = swing(model);
  // the effort is measured but for one second
  std::vector<double> tau(r.find("tau_cmd:a").begin(), r.find("tau_cmd:a").end());
  for (std::size_t k = 1000; k < 1250; ++k) tau[k] = kNaN;
  r.set("tau:a", tau);
  const EffortRows rows = effort_rows(model, {r}, false, Settings{});
  for (const EffortRow& row : rows.rows)
    EXPECT_TRUE(row.last <= 1000 || row.first >= 1250) << row.first;
  // and the last half stands
  std::vector<double> q(r.find("q:a").begin(), r.find("q:a").end());
  for (std::size_t k = 1300; k < q.size(); ++k) q[k] = q[1300];
  r.set("q:a", q);
  for (const EffortRow& row : effort_rows(model, {r}, false, Settings{}).rows)
    EXPECT_LT(row.first, 1350u);
}

TEST(EffortRows, RefuseWhatTheyCannotRead) {
  const ModelFolder model = pendulum(kTorque);
  recording::Recording r = swing(model);
  ModelFolder floating = model;
  floating.floating = true;
  EXPECT_THROW(effort_rows(floating, {r}, false, Settings{}), files::InputError);
  recording::Recording unseen = r;
  unseen.set("q:a", std::vector<double>(r.rows(), kNaN));
  EXPECT_THROW(effort_rows(model, {unseen}, false, Settings{}), files::InputError);
  std::swap(r.t[10], r.t[11]);
  EXPECT_THROW(effort_rows(model, {r}, false, Settings{}), files::InputError);
}

/// Rows of two links whose joint b is recorded in amperes.
EffortRows in_amperes(const Missing& missing, double amperes_per_torque) {
  EffortRows rows = made_effort(two_links(kTorque), 0.01, missing);
  EffortChannel& b = rows.recordings.front().channels[1];
  b.gain_unknown = true, b.unit = "A", b.column = "i:b";
  for (EffortRow& row : rows.rows) row.effort *= row.joint == 1 ? amperes_per_torque : 1.0;
  return rows;
}

TEST(DriveGain, IsFoundBesideFrictionAndAConstant) {
  const EffortRows rows = in_amperes(
      [](int j, const MotionSample& m, const NeededEffort&) {
        return j == 1 ? 0.2 * (m.dq[1] > 0.0 ? 1.0 : -1.0) + 0.03 * m.dq[1] + 0.1 : 0.0;
      },
      2.5);
  EffortDesign design(rows);
  design.append(effort_terms(rows, Settings{}));
  const std::vector<EffortGainFound> gains = scale_unknown_gains(design, Settings{});
  ASSERT_EQ(gains.size(), 1u);
  EXPECT_EQ(gains[0].joint, "b");
  EXPECT_EQ(gains[0].unit, "A");
  EXPECT_FALSE(gains[0].stated);
  EXPECT_TRUE(gains[0].determined);
  EXPECT_NEAR(gains[0].value, 0.4, 0.004);
  EXPECT_EQ(design.unit(1), "N m");
  for (std::size_t i = 0; i < rows.rows.size(); ++i) {
    const EffortRow& row = rows.rows[i];
    const double scale = row.joint == 1 ? gains[0].value : 1.0;
    EXPECT_NEAR(design.target()[static_cast<Eigen::Index>(i)], scale * row.effort - row.nominal,
                1e-12);
  }
}

TEST(DriveGain, OfAnEffortThatDoesNotFollowTheLinksIsNotInvented) {
  // the effort of another motion, and one with the wrong sign
  const auto unrelated = [](int j, const MotionSample& m, const NeededEffort& need) {
    return j == 1 ? 0.3 * (m.dq[1] > 0.0 ? 1.0 : -1.0) - need.total() : 0.0;
  };
  const auto nothing = [](int, const MotionSample&, const NeededEffort&) { return 0.0; };
  for (const EffortRows& rows : {in_amperes(unrelated, 2.5), in_amperes(nothing, -2.5)}) {
    EffortDesign design(rows);
    design.append(effort_terms(rows, Settings{}));
    const std::vector<EffortGainFound> gains = scale_unknown_gains(design, Settings{});
    ASSERT_EQ(gains.size(), 1u);
    EXPECT_FALSE(gains[0].determined);
    EXPECT_EQ(gains[0].value, 1.0);
    EXPECT_EQ(design.unit(1), "A");
    for (std::size_t i = 0; i < rows.rows.size(); ++i) {
      if (rows.rows[i].joint == 1) {
        EXPECT_EQ(design.target()[static_cast<Eigen::Index>(i)], rows.rows[i].effort);
      }
    }
    for (const EffortTerm& term : design.terms()) {
      if (term.where.front() != "b") continue;
      if (term.effect == "torque_constant") {
        EXPECT_EQ(term.high.front(), 0.0);
      }
      if (term.effect == "coulomb_friction") {
        EXPECT_EQ(term.units.front(), "A");
      }
    }
    EXPECT_FALSE(gain_column(design, "none").has_value());
  }
}

}  // namespace
}  // namespace sanso::diagnose
