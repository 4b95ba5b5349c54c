// What must not matter to the gate does not: encoder, rate, clock, order of files, columns, joints.
#include <gtest/gtest.h>

#include <numeric>

#include "tests/tools/diagnose/gate/made_recording.h"
#include "tools/diagnose/gate/checks.h"

namespace sanso::diagnose {
namespace {

using namespace test;

TEST(GateLaws, HealthyDataPassWithAnyEncoderAndRate) {
  std::uint64_t seed = 0;
  for (const int bits : {0, 10, 12, 14, 16, 19}) {
    for (const double period : {0.002, 0.0055, 0.012, 0.02}) {
      const double quantum = bits == 0 ? 0.0 : std::ldexp(6.283185307179586, -bits);
      const Defect d = first_defect(made({++seed, quantum, period}));
      EXPECT_EQ(d.defect, "") << bits << " bits, " << period << " s: " << d.message;
    }
  }
}

TEST(GateLaws, HealthyDataPassWithNoiseOnEveryChannel) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Data d = made({seed, 0.0});
    Random random(seed, 9);
    for (auto& [name, values] : d.columns) {
      const double sigma = name[0] == 'q' ? 1e-3 : name[0] == 'd' ? 0.05 : 0.0;
      for (double& v : values) v += sigma * random.normal();
    }
    EXPECT_EQ(first_defect(d).defect, "") << "seed " << seed;
  }
}

TEST(GateLaws, TheStartOfTheClockDoesNotMatter) {
  Data d = healthy();
  const GateReport before = inspect({d.view()}, joints());
  for (double& t : d.t) t += 1024.0;
  const GateReport after = inspect({d.view()}, joints());
  ASSERT_FALSE(after.refused());
  for (std::size_t k = 0; k < before.noise.size(); ++k)
    EXPECT_EQ(after.noise[k].sigma, before.noise[k].sigma);
  EXPECT_EQ(after.excitation[0].reversals, before.excitation[0].reversals);
}

TEST(GateLaws, TheOrderOfColumnsAndJointsDoesNotMatter) {
  for (const bool broken : {false, true}) {
    Data d = healthy();
    if (broken) scale(d["dq:knee"], kDegrees);
    Data reversed = d;
    std::reverse(reversed.columns.begin(), reversed.columns.end());
    std::vector<GateJoint> other = joints();
    std::reverse(other.begin(), other.end());
    const GateReport a = inspect({d.view()}, joints()), b = inspect({reversed.view()}, other);
    ASSERT_EQ(a.refused(), broken);
    ASSERT_EQ(b.refused(), broken);
    if (!broken) continue;
    EXPECT_EQ(a.defects[0].channel, b.defects[0].channel);
    EXPECT_EQ(a.defects[0].message, b.defects[0].message);
  }
}

TEST(GateLaws, TheOrderOfTheFilesDoesNotMatterToWhatIsMeasured) {
  const Data a = healthy(1), b = healthy(2);
  const GateReport ab = inspect({a.view(), b.view()}, joints()),
                   ba = inspect({b.view(), a.view()}, joints());
  ASSERT_FALSE(ab.refused());
  for (std::size_t j = 0; j < 2; ++j) {
    EXPECT_EQ(ab.excitation[j].range, ba.excitation[j].range);
    EXPECT_EQ(ab.excitation[j].reversals, ba.excitation[j].reversals);
    EXPECT_NEAR(ab.excitation[j].speed_rms, ba.excitation[j].speed_rms, 1e-12);
  }
  for (std::size_t k = 0; k < ab.noise.size(); ++k) EXPECT_EQ(ab.noise[k].sigma, ba.noise[k].sigma);
}

TEST(GateLaws, ColumnsOfNobodyDoNotMatter) {
  Data d = healthy();
  std::vector<double>& foreign = d["q:elbow"];
  std::iota(foreign.begin(), foreign.end(), 0.0);
  EXPECT_EQ(first_defect(d).defect, "");
}

TEST(GateLaws, AMirroredRobotIsAsHealthyAndAsBroken) {
  for (const bool broken : {false, true}) {
    Data d = healthy();
    if (broken) scale(d["u:knee"], kDegrees);
    for (auto& [name, values] : d.columns) scale(values, -1.0);
    EXPECT_EQ(first_defect(d).defect, broken ? defect::kWrongUnit : "");
  }
}

TEST(GateLaws, SwappedNamesOfJointsAreSeenInEitherChannel) {
  for (const char* kind : {"q:", "u:"}) {
    Data d = healthy();
    std::swap(d[std::string(kind) + "hip"], d[std::string(kind) + "knee"]);
    if (kind[0] == 'q') std::swap(d["dq:hip"], d["dq:knee"]);
    EXPECT_EQ(first_defect(d).defect, defect::kSwapped) << kind;
  }
}

TEST(GateLaws, SwappedPositionsWithoutCommandsAreSeenByTheVelocities) {
  Data d = healthy();
  std::swap(d["q:hip"], d["q:knee"]);
  std::erase_if(d.columns, [](const auto& c) { return c.first[0] == 'u'; });
  EXPECT_EQ(first_defect(d).defect, defect::kSwapped);
}

/// Links that swing against each other: either position has the other velocity's sign too.
TEST(GateLaws, SwappedPositionsOfOpposedJointsAreNoWrongSign) {
  Data d = healthy();
  for (const std::string kind : {"q:", "dq:"}) {
    std::vector<double>& knee = d[kind + "knee"];
    for (std::size_t k = 0; k < knee.size(); ++k) knee[k] = 0.3 * knee[k] - d[kind + "hip"][k];
  }
  std::erase_if(d.columns, [](const auto& c) { return c.first[0] == 'u'; });
  EXPECT_EQ(first_defect(d).defect, "");
  std::swap(d["q:hip"], d["q:knee"]);
  EXPECT_EQ(first_defect(d).defect, defect::kSwapped);
}

/// Columns of which one has another sign, or another clock.
void spoil(std::vector<double>& velocity, const char* how) {
  if (how == std::string(defect::kWrongSign)) return scale(velocity, -1.0);
  std::rotate(velocity.begin(), velocity.begin() + 50, velocity.end());
}

void expect_either(const char* how, bool commanded) {
  Data d = healthy();
  spoil(d["dq:hip"], how);
  if (!commanded) std::erase_if(d.columns, [](const auto& c) { return c.first[0] == 'u'; });
  const GateReport report = inspect({d.view()}, joints());
  std::vector<std::string> channels;
  channels.reserve(report.defects.size());
  for (const Defect& found : report.defects) {
    EXPECT_EQ(found.defect, how);
    channels.push_back(found.channel);
  }
  EXPECT_EQ(channels, commanded ? std::vector<std::string>{"dq:hip"}
                                : (std::vector<std::string>{"dq:hip", "q:hip"}));
}

TEST(GateLaws, WhatNoCommandVouchesForMayBeThePositionsOrTheVelocitys) {
  for (const char* how : {defect::kWrongSign, defect::kShiftedClock}) {
    expect_either(how, true);
    expect_either(how, false);
  }
}

struct WrongUnit {
  const char* channel;
  double value, factor;  // amplitude in the right unit, and what it is multiplied by
};

TEST(GateUnits, EveryElectricalChannelIsHeldAgainstTheDataSheet) {
  for (const WrongUnit& w : {WrongUnit{"i:hip", 1.2, 1000}, WrongUnit{"tau:knee", 2.0, 1000},
                             WrongUnit{"tau_cmd:knee", 2.0, 1000}, WrongUnit{"volt", 12, 1000}}) {
    for (const bool wrong : {false, true}) {
      Data d = healthy();
      auto& values = d[w.channel];
      for (std::size_t k = 0; k < values.size(); ++k)
        values[k] = w.value * std::sin(3 * d.t[k]) * (wrong ? w.factor : 1.0);
      const Defect found = first_defect(d);
      EXPECT_EQ(found.defect, wrong ? defect::kWrongUnit : "") << w.channel;
      EXPECT_EQ(found.channel, wrong ? w.channel : "");
    }
  }
}

TEST(GateUnits, TemperaturesAreCelsius) {
  for (const double offset : {0.0, 273.15}) {
    Data d = healthy();
    for (double& v : d["temp:hip"]) v = 35.0 + offset;
    EXPECT_EQ(first_defect(d).defect, offset > 0 ? defect::kWrongUnit : "");
  }
}

TEST(GateUnits, ASlidingJointIsHeldAgainstItsTravel) {
  for (const double factor : {1.0, 1000.0}) {
    Data d = healthy();
    std::erase_if(d.columns, [](const auto& c) { return c.first != "q:hip"; });
    scale(d["q:hip"], 0.1 * factor);
    const GateReport report = inspect({d.view()}, {{"hip", true, -0.1, 0.1}});
    EXPECT_EQ(report.refused(), factor > 1.0);
  }
}

TEST(GateUnits, DegreesAreSeenByEachOfThreeWitnesses) {
  Data d = healthy();
  std::erase_if(d.columns, [](const auto& c) { return c.first[0] != 'q'; });
  scale(d["q:hip"], kDegrees);
  scale(d["q:knee"], kDegrees);
  const auto refused = [&](const GateJoint& knee) {
    const GateReport report = inspect({d.view()}, {knee});
    return report.refused() ? report.defects[0].message : std::string();
  };
  EXPECT_NE(refused({"knee", false, -1, 1}).find("limits allow"), std::string::npos);
  EXPECT_NE(refused({"knee", false, 0, 0, 4.8}).find("the motor at most"), std::string::npos);
  EXPECT_NE(refused({"knee"}).find("an encoder's steps in degrees"), std::string::npos);
}

TEST(GateUnits, MilliradiansAreToldFromDegrees) {
  Data d = healthy();
  std::erase_if(d.columns, [](const auto& c) { return c.first[0] == 'q'; });
  Data source = made({3, 0.0});
  d["q:hip"] = source["q:hip"];
  scale(d["q:hip"], 1000.0);
  const GateReport report = inspect({d.view()}, {{"hip"}});
  ASSERT_TRUE(report.refused());
  EXPECT_EQ(report.defects[0].channel, "q:hip");
  EXPECT_NE(report.defects[0].message.find("thousandths"), std::string::npos);
}

TEST(GateSize, FiftyRowsAndHalfASecondAreEnoughAndNotLess) {
  const auto cut = [](std::size_t rows, double period) {
    Data d = made({3, kQuantum, period, 9.0});
    d.t.resize(rows);
    for (auto& [name, values] : d.columns) values.resize(rows);
    return first_defect(d).defect;
  };
  EXPECT_EQ(cut(50, 0.02), "");
  EXPECT_EQ(cut(49, 0.02), defect::kTooShort);
  EXPECT_EQ(cut(60, 0.005), defect::kTooShort) << "0.3 s";
}

TEST(GateNotes, GlitchesAndJitterAreSaidAndNotRefused) {
  Data d = healthy();
  for (const std::size_t k : {150u, 700u, 1111u}) d["q:hip"][k] += 0.8;
  Random random(4);
  for (double& t : d.t) t += 0.002 * random.uniform();
  const GateReport report = inspect({d.view()}, joints());
  ASSERT_FALSE(report.refused()) << report.defects[0].message;
  const auto said = [&](const char* words) {
    return std::any_of(report.notes.begin(), report.notes.end(), [&](const std::string& note) {
      return note.find(words) != std::string::npos;
    });
  };
  EXPECT_TRUE(said("sampling varies"));
  EXPECT_TRUE(said("q:hip has"));
  EXPECT_FALSE(said("u:hip")) << "commands may jump";
}

TEST(Glitches, AreReplacedByTheirNeighboursAndNothingElseIsTouched) {
  for (const double quantum : {0.0, kQuantum}) {
    Data d = made({5, quantum});
    std::vector<double> x = d["q:hip"];
    x[400] += 1.0, x[900] -= 2.0, x[901 + 7] = NAN;
    int replaced = 0;
    const std::vector<double> clean = gate::without_glitches(x, &replaced);
    EXPECT_EQ(replaced, 2);
    for (std::size_t k = 0; k < x.size(); ++k) {
      if (std::isnan(x[k])) {
        EXPECT_TRUE(std::isnan(clean[k])) << k;
      } else {
        EXPECT_NEAR(clean[k], d["q:hip"][k], k == 400 || k == 900 ? 0.02 : 0.0) << k;
      }
    }
  }
}

TEST(Glitches, AReversalHoweverHardIsNone) {
  // a joint that rests, then bounces between two stops: the steps change their sign in one sample
  std::vector<double> x(4000, 0.1);
  for (int k = 0; k < 600; ++k) x.push_back(0.1 + 0.02 * std::abs(k % 40 - 20));
  int replaced = 0;
  EXPECT_EQ(gate::without_glitches(x, &replaced), x);
  EXPECT_EQ(replaced, 0);
}

TEST(Glitches, ACountThatFlickersIsNone) {
  // at rest for nine samples in ten, so that the usual departure is none at all
  Random random(12);
  std::vector<double> x(5000, 100 * kQuantum);
  for (double& v : x) v += random.uniform() < 0.03 ? kQuantum * (1 + random.below(2)) : 0.0;
  int replaced = 0;
  gate::without_glitches(x, &replaced);
  EXPECT_EQ(replaced, 0);
  x[2500] += 64 * kQuantum;  // a bit that fails
  gate::without_glitches(x, &replaced);
  EXPECT_EQ(replaced, 1);
}

TEST(RestingJoint, IsAsNoisyAsItsEncoderIsCoarse) {
  Data d = healthy();
  std::erase_if(d.columns, [](const auto& c) { return c.first[0] != 'q'; });
  std::fill(d["q:knee"].begin(), d["q:knee"].end(), 0.3);
  std::vector<GateJoint> robot = joints();
  const auto sigma_of_knee = [&](const GateReport& report) {
    for (const NoiseLevel& n : report.noise) {
      if (n.channel == "q:knee") return n.sigma;
    }
    return 0.0;
  };
  const GateReport of_neighbours = inspect({d.view()}, robot);
  ASSERT_FALSE(of_neighbours.refused());
  EXPECT_GE(sigma_of_knee(of_neighbours), kQuantum / std::sqrt(12.0));
  EXPECT_LT(sigma_of_knee(of_neighbours), kQuantum);
  robot[1].position_quantum = 1e-4;
  EXPECT_NEAR(sigma_of_knee(inspect({d.view()}, robot)), 1e-4 / std::sqrt(12.0), 1e-12);
}

TEST(RestingJoint, TakesNoPartInTheNoiseOfTheRecordingsInWhichItMoves) {
  Data moving = made({5, 0.0});
  std::erase_if(moving.columns, [](const auto& c) { return c.first[0] != 'q'; });
  Data noisy = moving, resting = moving;
  Random random(3);
  for (double& v : noisy["q:knee"]) v += 1e-3 * random.normal();
  std::fill(resting["q:knee"].begin(), resting["q:knee"].end(), 0.3);
  resting["q:hip"][3] += 1e-9;  // no copy
  const GateReport one = inspect({noisy.view()}, joints());
  const GateReport both = inspect({noisy.view(), resting.view()}, joints());
  ASSERT_EQ(one.noise.size(), both.noise.size());
  for (std::size_t k = 0; k < one.noise.size(); ++k) {
    if (one.noise[k].channel != "q:knee") continue;
    EXPECT_EQ(both.noise[k].sigma, one.noise[k].sigma);
  }
}

TEST(SamplingInterval, IsTheUsualStepWhateverOneGapSays) {
  std::vector<double> t;
  for (int k = 0; k < 100; ++k) t.push_back(0.01 * k + (k > 50 ? 3.0 : 0.0));
  EXPECT_NEAR(gate::sampling_interval(t), 0.01, 1e-12);
}

TEST(Excitation, CountsTheTurnsOfASineAndMeasuresItsSpeed) {
  Data d;
  for (int k = 0; k < 1600; ++k) d.t.push_back(0.005 * k);
  for (std::size_t k = 0; k < d.t.size(); ++k) {
    d["q:hip"][k] = 0.5 * std::sin(6.283185307 * d.t[k]);  // eight periods
    d["q:knee"][k] = kQuantum * static_cast<double>(k % 2);
  }
  const GateReport report = inspect({d.view()}, {{"hip"}, {"knee"}});
  ASSERT_FALSE(report.refused()) << report.defects[0].message;
  EXPECT_NEAR(report.excitation[0].range, 1.0, 1e-3);
  EXPECT_NEAR(report.excitation[0].reversals, 16, 1);
  EXPECT_NEAR(report.excitation[0].speed_rms, 0.5 * 6.2832 / std::sqrt(2.0), 0.03);
  EXPECT_TRUE(report.excitation[0].moves);
  EXPECT_FALSE(report.excitation[1].moves) << "a step of the encoder is no motion";
}

}  // namespace
}  // namespace sanso::diagnose
