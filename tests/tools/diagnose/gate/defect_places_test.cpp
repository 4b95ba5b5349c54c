// Defects put at random places of random recordings are found there: file, channel and row.
#include <gtest/gtest.h>

#include "tests/tools/diagnose/gate/made_recording.h"

namespace sanso::diagnose {
namespace {

using namespace test;

/// A random recording, a random joint of it and a random row away from its ends.
struct Place {
  explicit Place(std::uint64_t trial) : random(77, trial), data(made({trial % 7})) {
    data.file = "recording_" + std::to_string(trial) + ".csv";
    joint = random.below(2) == 0 ? "hip" : "knee";
    row = 200 + random.below(static_cast<int>(data.t.size()) - 600);
  }
  std::vector<double>& column(const std::string& kind) { return data[kind + ":" + joint]; }
  std::size_t at() const { return static_cast<std::size_t>(row); }

  Random random;
  Data data;
  std::string joint;
  long row = 0;
};

/// The one defect that `place` must be refused for.
void expect_refused(const Place& place, const std::string& channel, const char* defect) {
  const GateReport report = inspect({place.data.view()}, joints());
  ASSERT_EQ(report.defects.size(), 1u) << place.data.file << ", row " << place.row;
  EXPECT_EQ(report.defects[0].defect, defect) << report.defects[0].message;
  EXPECT_EQ(report.defects[0].file, place.data.file);
  EXPECT_EQ(report.defects[0].channel, channel);
  EXPECT_EQ(report.defects[0].row, place.row) << report.defects[0].message;
  EXPECT_FALSE(report.defects[0].message.empty());
}

TEST(GatePlaces, TimeThatStepsBack) {
  for (std::uint64_t trial = 0; trial < 20; ++trial) {
    Place p(trial);
    p.data.t[p.at()] = p.data.t[p.at() - 1] - 0.02 * p.random.uniform() - 1e-6;
    expect_refused(p, "t", defect::kBackwards);
  }
}

TEST(GatePlaces, AnInstantThatIsThereTwice) {
  for (std::uint64_t trial = 0; trial < 20; ++trial) {
    Place p(trial);
    p.data.t[p.at()] = p.data.t[p.at() - 1];
    expect_refused(p, "t", defect::kDuplicateTime);
  }
}

TEST(GatePlaces, AGapOfAnyLengthAboveATenthOfASecond) {
  for (std::uint64_t trial = 0; trial < 20; ++trial) {
    Place p(trial);
    const double gap = 0.11 + 5.0 * p.random.uniform() * p.random.uniform();
    for (std::size_t k = p.at(); k < p.data.t.size(); ++k) p.data.t[k] += gap;
    expect_refused(p, "t", defect::kGap);
  }
}

TEST(GatePlaces, ARowWithoutTime) {
  for (std::uint64_t trial = 0; trial < 20; ++trial) {
    Place p(trial);
    p.data.t[p.at()] = trial % 2 == 0 ? NAN : INFINITY;
    expect_refused(p, "t", defect::kNotANumber);
  }
}

TEST(GatePlaces, AnInfiniteCellOfAnyChannel) {
  for (std::uint64_t trial = 0; trial < 20; ++trial) {
    Place p(trial);
    const char* kinds[] = {"q", "u", "dq", "pwm"};
    const std::string kind = kinds[p.random.below(4)];
    p.column(kind)[p.at()] = p.random.sign() * INFINITY;
    p.column(kind)[p.at() + 9] = INFINITY;  // the first is named
    expect_refused(p, kind + ":" + p.joint, defect::kNotANumber);
  }
}

TEST(GatePlaces, AnAngleThatJumpsByATurn) {
  for (std::uint64_t trial = 0; trial < 20; ++trial) {
    Place p(trial);
    const double turn = 6.283185307179586 * p.random.sign();
    for (std::size_t k = p.at(); k < p.data.t.size(); ++k) p.column("q")[k] += turn;
    expect_refused(p, "q:" + p.joint, defect::kEncoderWrap);
  }
}

TEST(GatePlaces, ARegisterLoggedWithoutItsSign) {
  for (std::uint64_t trial = 0; trial < 20; ++trial) {
    Place p(trial);
    auto& pwm = p.column("pwm");
    std::size_t first = pwm.size();
    for (std::size_t k = 0; k < pwm.size(); ++k) {
      if (pwm[k] < 0.0) pwm[k] += 65536.0 / 885.0, first = std::min(first, k);
    }
    p.row = static_cast<long>(first);
    expect_refused(p, "pwm:" + p.joint, defect::k16BitWrap);
  }
}

TEST(GatePlaces, ASensorThatHangsWhileTheCommandGoesOn) {
  for (std::uint64_t trial = 0; trial < 20; ++trial) {
    Place p(trial);
    p.row = 200 + p.random.below(300);  // some seconds must be left for the proof
    auto& q = p.column("q");
    std::fill(q.begin() + p.row, q.end(), q[p.at()]);
    const Defect d = first_defect(p.data);
    EXPECT_EQ(d.defect, defect::kStuck) << "trial " << trial;
    EXPECT_EQ(d.channel, "q:" + p.joint);
    const double waited = p.data.t[static_cast<std::size_t>(d.row)] - p.data.t[p.at()];
    EXPECT_GT(waited, 0.9) << "trial " << trial << ": named where it is proven";
    EXPECT_LT(waited, 3.0) << "trial " << trial;
  }
}

/// Of a joint under torque, whose velocity nobody records.
void make_torque_driven(Data& data) {
  std::erase_if(data.columns, [](const auto& c) {
    return c.first.rfind("dq:", 0) == 0 || c.first.rfind("pwm:", 0) == 0;
  });
  for (auto& [name, values] : data.columns)
    if (name.rfind("u:", 0) == 0) name = "tau_cmd:" + name.substr(2);
}

// Nothing says that the joint moves but the place in which it is afterwards.
TEST(GatePlaces, ASensorThatHangsForAWhile) {
  int tried = 0;
  for (std::uint64_t trial = 0; trial < 40; ++trial) {
    Place p(trial);
    p.row = 200 + p.random.below(300);
    auto& q = p.column("q");
    const std::size_t first = p.at(), after = first + 240;  // 1.3 s
    if (std::abs(q[after] - q[first]) < 0.3) continue;
    ++tried;
    std::fill(q.begin() + p.row, q.begin() + static_cast<std::ptrdiff_t>(after), q[first]);
    make_torque_driven(p.data);
    const Defect d = first_defect(p.data);
    EXPECT_EQ(d.defect, defect::kStuck) << "trial " << trial;
    EXPECT_EQ(d.channel, "q:" + p.joint);
    EXPECT_EQ(d.row, static_cast<long>(after) - 1) << "trial " << trial;
  }
  EXPECT_GT(tried, 8);
}

// The same rows again and again, three times; once a robot may have been set to zero at rest.
TEST(GatePlaces, RowsThatWereWrittenAgain) {
  for (const int times : {1, 4}) {
    Place p(7);
    for (int k = 0; k < times; ++k) {
      const std::size_t first = 200 + 250 * static_cast<std::size_t>(k);
      for (auto& [name, values] : p.data.columns)
        for (std::size_t i = first; i < first + 60; ++i) values[i] = values[first];
    }
    const Defect d = first_defect(p.data);
    EXPECT_EQ(d.defect == defect::kStuck, times == 4) << d.defect;
  }
}

TEST(GatePlaces, AChannelCutOffAtALevel) {
  for (std::uint64_t trial = 0; trial < 20; ++trial) {
    Place p(trial);
    auto& q = p.column("q");
    const double level = kQuantum * std::round((0.25 + 0.1 * p.random.uniform()) / kQuantum);
    const double side = p.random.sign();
    for (double& v : q) v = side > 0 ? std::min(v, level) : std::max(v, -level);
    const Defect d = first_defect(p.data);
    ASSERT_EQ(d.defect, defect::kClipped) << "trial " << trial;
    EXPECT_EQ(d.channel, "q:" + p.joint);
    EXPECT_EQ(q[static_cast<std::size_t>(d.row)], side * level);
    EXPECT_NE(q[static_cast<std::size_t>(d.row) - 1], side * level);
  }
}

TEST(GatePlaces, TheFileThatIsBrokenIsNamedWhereverItStands) {
  for (std::size_t broken = 0; broken < 3; ++broken) {
    std::vector<Data> files{healthy(1), healthy(2), healthy(4)};
    for (std::size_t k = 0; k < files.size(); ++k) files[k].file = std::to_string(k) + ".csv";
    files[broken].t[300] = files[broken].t[299];
    const GateReport report =
        inspect({files[0].view(), files[1].view(), files[2].view()}, joints());
    ASSERT_EQ(report.defects.size(), 1u);
    EXPECT_EQ(report.defects[0].file, std::to_string(broken) + ".csv");
  }
}

TEST(GatePlaces, EveryBrokenFileOfACallIsNamed) {
  std::vector<Data> files{healthy(1), healthy(2), healthy(4)};
  files[0].file = "first.csv", files[2].file = "last.csv";
  scale(files[0]["q:knee"], kDegrees);
  files[2]["q:hip"][5] = INFINITY;
  const GateReport report = inspect({files[0].view(), files[1].view(), files[2].view()}, joints());
  ASSERT_EQ(report.defects.size(), 2u);
  EXPECT_EQ(report.defects[0].file, "first.csv");
  EXPECT_EQ(report.defects[0].channel, "q:knee");
  EXPECT_EQ(report.defects[1].file, "last.csv");
  EXPECT_EQ(report.defects[1].row, 5);
}

}  // namespace
}  // namespace sanso::diagnose
