// From files to judged recordings: every file has its reason, and a reader's error becomes a
// defect.
#include "tools/diagnose/gate/load.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/small_world.h"
#include "tests/support/temp_folder.h"
#include "tests/tools/diagnose/gate/made_recording.h"
#include "tools/recording/reading_error.h"

namespace sanso::diagnose {
namespace {

using namespace test;

class Load : public ::testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& text) {
    const std::string path = (folder_.path() / name).string();
    std::ofstream(path) << text;
    return path;
  }
  std::string write(const std::string& name, const Data& d) {
    std::string text = "t";
    for (const auto& [column, values] : d.columns) text += "," + column;
    for (std::size_t k = 0; k < d.t.size(); ++k) {
      text += "\n" + std::to_string(d.t[k]);
      for (const auto& [column, values] : d.columns) text += "," + std::to_string(values[k]);
    }
    return write(name, text + "\n");
  }
  sanso::test::TempFolder folder_;
};

TEST_F(Load, HealthyFilesComeInTheOrderGiven) {
  const std::string b = write("b.csv", healthy(1)), a = write("a.csv", healthy(2));
  const LoadedRecordings loaded = load_recordings({b, a}, joints());
  ASSERT_FALSE(loaded.gate.refused()) << loaded.gate.defects[0].message;
  ASSERT_EQ(loaded.recordings.size(), 2u);
  EXPECT_EQ(loaded.recordings[0].file, b);
  EXPECT_EQ(loaded.recordings[1].file, a);
  EXPECT_EQ(loaded.recordings[0].rows(), healthy(1).t.size());
}

TEST_F(Load, WhatCannotBeReadIsNamedFirstAndTheRestIsJudgedAllTheSame) {
  Data degrees = healthy(1);
  scale(degrees["q:knee"], kDegrees);
  const std::string wrong = write("degrees.csv", degrees), empty = write("empty.csv", "");
  const LoadedRecordings loaded = load_recordings({wrong, empty, "absent.csv"}, joints());
  ASSERT_EQ(loaded.gate.defects.size(), 3u);
  EXPECT_EQ(loaded.gate.defects[0].defect, defect::kEmpty);
  EXPECT_EQ(loaded.gate.defects[0].file, empty);
  EXPECT_EQ(loaded.gate.defects[1].defect, defect::kUnreadable);
  EXPECT_EQ(loaded.gate.defects[1].file, "absent.csv");
  EXPECT_EQ(loaded.gate.defects[2].defect, defect::kWrongUnit);
  EXPECT_EQ(loaded.gate.defects[2].file, wrong);
}

TEST_F(Load, NoFileAtAllIsRefused) {
  const LoadedRecordings loaded = load_recordings({}, joints());
  ASSERT_TRUE(loaded.gate.refused());
  EXPECT_EQ(loaded.gate.defects.back().defect, defect::kEmpty);
  EXPECT_EQ(loaded.gate.defects.back().message, "no recording was given");
}

TEST_F(Load, AWordAmongTheNumbersIsNamedByRow) {
  std::string text = "t,q:hip\n";
  for (int k = 0; k < 100; ++k) {
    text += std::to_string(0.01 * k);
    text += k == 40 ? ",oops\n" : ",0.5\n";
  }
  const LoadedRecordings loaded = load_recordings({write("word.csv", text)}, joints());
  ASSERT_TRUE(loaded.gate.refused());
  EXPECT_EQ(loaded.gate.defects[0].row, 40);
  EXPECT_EQ(loaded.gate.defects[0].channel, "q:hip");
  EXPECT_NE(loaded.gate.defects[0].message.find("oops"), std::string::npos);
}

TEST(DefectOf, KeepsFilePlaceAndTextOfTheReadersError) {
  const recording::ReadingError error(recording::ReadFault::not_a_number, "r.csv", 12, "q:hip",
                                      "NaN or infinity", "inf", "a number");
  const Defect d = defect_of(error);
  EXPECT_EQ(d.file, "r.csv");
  EXPECT_EQ(d.channel, "q:hip");
  EXPECT_EQ(d.row, 10) << "line 1 is the header, line 2 holds row 0";
  EXPECT_EQ(d.defect, defect::kNotANumber);
  EXPECT_EQ(d.message, error.what());
  EXPECT_EQ(defect_of(files::InputError("r.csv", 0, "", "strange", "", "")).defect, "strange");
  EXPECT_EQ(defect_of(files::InputError("r.csv", 0, "", "strange", "", "")).row, -1);
}

TEST(GateJoints, KnowWhatTheMotorCanDo) {
  const ModelFolder servo = pendulum(
      "actuator = \"dc_servo\"\nvoltage = 12\nback_emf = 2.4\nresistance = 6\n"
      "torque_constant = 1.5\n");
  const GateJoint j = gate_joints(servo).at(0);
  EXPECT_EQ(j.name, "a");
  EXPECT_DOUBLE_EQ(j.speed_limit, 5.0);
  EXPECT_DOUBLE_EQ(j.current_limit, 2.0);
  EXPECT_DOUBLE_EQ(j.torque_limit, 3.0);
  EXPECT_EQ(j.lower, j.upper) << "a continuous joint has no limits";
}

TEST(GateJoints, KnowTheTravelOfASliderAndNothingOfAMotorThatIsNotThere) {
  const std::vector<GateJoint> all = gate_joints(arm("actuator = \"torque\"\ntorque_limit = 7\n"));
  ASSERT_EQ(all.size(), 3u);
  EXPECT_TRUE(all[2].prismatic);
  EXPECT_EQ(all[2].lower, -1.0);
  EXPECT_EQ(all[2].upper, 1.0);
  EXPECT_EQ(all[0].torque_limit, 7.0);
  EXPECT_EQ(all[0].speed_limit, 0.0);
  EXPECT_EQ(all[0].voltage, 0.0);
}

TEST(GateView, ShowsEveryColumnOfTheRecording) {
  recording::Recording r;
  r.file = "r.csv", r.condition = "loaded", r.t = {0, 1};
  r.set("q:hip", {3, 4});
  const GateRecording view = gate_view(r);
  EXPECT_EQ(view.file, "r.csv");
  EXPECT_EQ(view.condition, "loaded");
  ASSERT_NE(view.find("q:hip"), nullptr);
  EXPECT_EQ(view.find("q:hip")->values[1], 4.0);
  EXPECT_EQ(view.find("q:knee"), nullptr);
}

}  // namespace
}  // namespace sanso::diagnose
