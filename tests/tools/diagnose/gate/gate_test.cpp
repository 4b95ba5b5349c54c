// Every kind of broken recording must be refused by its own name, and healthy data must pass,
// effects included.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>

#include "tests/support/temp_folder.h"
#include "tests/tools/diagnose/gate/made_recording.h"
#include "tools/diagnose/gate/checks.h"
#include "tools/diagnose/gate/gate.h"
#include "tools/diagnose/gate/noise.h"
#include "tools/diagnose/stats/random.h"

namespace sanso::diagnose {
namespace {

using namespace test;

TEST(Gate, PassesAHealthyRecordingAndMeasuresItsNoise) {
  const Data d = healthy();
  const GateReport report = inspect({d.view()}, joints());
  ASSERT_FALSE(report.refused()) << report.defects.front().defect << ": "
                                 << report.defects.front().message;
  for (const NoiseLevel& n : report.noise) {
    if (n.channel != "q:hip") continue;
    EXPECT_NEAR(n.quantum, kQuantum, 1e-3 * kQuantum);
    EXPECT_GT(n.sigma, 0.2 * kQuantum);
    EXPECT_LT(n.sigma, 0.7 * kQuantum);
  }
  EXPECT_TRUE(report.excitation[0].moves);
  EXPECT_GT(report.excitation[1].reversals, 5);
}

struct Corruption {
  const char* name;
  const char* expected;
  std::function<void(Data&)> apply;
};

const std::vector<Corruption>& of_clock_and_units() {
  static const std::vector<Corruption> all{
      {"header only", defect::kHeaderOnly,
       [](Data& d) {
         d.t.clear();
         for (auto& [name, values] : d.columns) values.clear();
       }},
      {"time backwards", defect::kBackwards, [](Data& d) { std::swap(d.t[500], d.t[510]); }},
      {"duplicate row", defect::kDuplicateTime, [](Data& d) { d.t[500] = d.t[499]; }},
      {"gap", defect::kGap,
       [](Data& d) {
         for (std::size_t k = 700; k < d.t.size(); ++k) d.t[k] += 0.6;
       }},
      {"milliseconds", defect::kWrongUnit, [](Data& d) { scale(d.t, 1000.0); }},
      {"position in degrees", defect::kWrongUnit, [](Data& d) { scale(d["q:knee"], 57.29577951); }},
      {"command in degrees", defect::kWrongUnit, [](Data& d) { scale(d["u:hip"], 57.29577951); }},
      {"all angles in degrees", defect::kWrongUnit,
       [](Data& d) {
         for (auto& [name, values] : d.columns) {
           if (name.rfind("pwm", 0) != 0) scale(values, 57.29577951);
         }
       }},
      {"velocity in degrees", defect::kWrongUnit,
       [](Data& d) { scale(d["dq:knee"], 57.29577951); }},
  };
  return all;
}

const std::vector<Corruption>& of_channels() {
  static const std::vector<Corruption> all{
      {"flipped sign", defect::kWrongSign,
       [](Data& d) {
         scale(d["q:hip"], -1);
         scale(d["dq:hip"], -1);
       }},
      {"swapped joints", defect::kSwapped,
       [](Data& d) {
         std::swap(d["q:hip"], d["q:knee"]);
         std::swap(d["dq:hip"], d["dq:knee"]);
       }},
      {"encoder wrap", defect::kEncoderWrap,
       [](Data& d) {
         for (double& v : d["q:knee"]) v = v > 0.2 ? v - 6.283185307 : v;
       }},
      {"16-bit wrap", defect::k16BitWrap,
       [](Data& d) {
         for (double& v : d["pwm:knee"]) v = v < 0 ? v + 65536.0 / 885.0 : v;
       }},
      {"clipped", defect::kClipped,
       [](Data& d) {
         for (double& v : d["q:hip"]) v = std::min(v, 240 * kQuantum);
       }},
      {"command copied from position", defect::kCommandIsCopy,
       [](Data& d) { d["u:hip"] = d["q:hip"]; }},
      {"stuck sensor", defect::kStuck,
       [](Data& d) {
         auto& q = d["q:hip"];
         for (std::size_t k = 600; k < q.size(); ++k) q[k] = q[600];
       }},
      {"infinite value", defect::kNotANumber, [](Data& d) { d["q:knee"][12] = INFINITY; }},
      {"no motion", defect::kNoMotion,
       [](Data& d) {
         for (auto& [name, values] : d.columns)
           std::fill(values.begin(), values.end(), name[0] == 'd' ? 0.0 : 0.25);
       }},
      {"foreign columns", defect::kMissingChannel,
       [](Data& d) {
         for (auto& [name, values] : d.columns) name = "x" + name;
       }},
  };
  return all;
}

TEST(Gate, RefusesEveryCorruptionByName) {
  for (const auto* list : {&of_clock_and_units(), &of_channels()}) {
    for (const Corruption& c : *list) {
      Data d = healthy();
      c.apply(d);
      EXPECT_EQ(first_defect(d).defect, c.expected) << c.name;
    }
  }
}

TEST(Gate, RefusesACopyUnderAnotherNameAndClock) {
  const Data a = healthy(1), b = healthy(2);
  Data copy = healthy(1);
  copy.file = "c.csv";
  for (double& t : copy.t) t += 3.0;
  EXPECT_FALSE(inspect({a.view(), b.view()}, joints()).refused());
  const GateReport report = inspect({a.view(), b.view(), copy.view()}, joints());
  ASSERT_TRUE(report.refused());
  EXPECT_EQ(report.defects.front().defect, defect::kCopyOfFile);
  EXPECT_EQ(report.defects.front().file, "c.csv");
}

TEST(Gate, LegalOddities_EmptyCellsLostPacketsTorqueOff_Pass) {
  Data d = healthy();
  Random random(5);
  auto& q = d["q:hip"];
  for (std::size_t k = 1; k < q.size(); ++k) {
    if (random.uniform() < 0.2) q[k] = q[k - 1];       // lost packet: the last value again
    if (random.uniform() < 0.1) d["q:knee"][k] = NAN;  // not sampled
    if (k > 1000) d["u:knee"][k] = NAN;                // torque off
  }
  EXPECT_EQ(first_defect(d).defect, "");
}

TEST(Gate, FilesThatCannotBeRecordings) {
  const sanso::test::TempFolder temporary;
  const std::string folder = temporary.path().string();
  EXPECT_EQ(inspect_file(folder + "/not_there.csv").front().defect, defect::kUnreadable);
  const std::string empty = folder + "/empty.csv";
  std::ofstream(empty).close();
  EXPECT_EQ(inspect_file(empty).front().defect, defect::kEmpty);
  const std::string huge = folder + "/huge.csv";
  std::ofstream(huge).close();
  std::filesystem::resize_file(huge, std::uintmax_t{10} << 30);  // sparse: takes no space
  EXPECT_EQ(inspect_file(huge).front().defect, defect::kTooLarge);
}

}  // namespace
}  // namespace sanso::diagnose
