// Every kind of broken file through the whole command: exit code 2, the defect by its name with
// file, channel and row, and nothing written but the refusal.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "tests/support/small_world.h"
#include "tests/support/temp_folder.h"
#include "tools/diagnose/run/diagnose.h"
#include "tools/recording/csv_writer.h"

namespace sanso::diagnose {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTwoJoints = R"(<robot name="two"><link name="base"/>
<joint name="hip" type="revolute"><parent link="base"/><child link="thigh"/><axis xyz="0 1 0"/>
<limit lower="-2" upper="2" effort="4" velocity="4.8"/></joint>
<link name="thigh"><inertial><origin xyz="0 0 -0.08"/><mass value="0.2"/>
<inertia ixx="3e-4" ixy="0" ixz="0" iyy="3e-4" iyz="0" izz="1e-4"/></inertial></link>
<joint name="knee" type="revolute"><parent link="thigh"/><child link="shank"/>
<origin xyz="0 0 -0.15"/><axis xyz="0 1 0"/>
<limit lower="-2" upper="2" effort="4" velocity="4.8"/></joint>
<link name="shank"><inertial><origin xyz="0 0 -0.06"/><mass value="0.15"/>
<inertia ixx="2e-4" ixy="0" ixz="0" iyy="2e-4" iyz="0" izz="1e-4"/></inertial></link></robot>)";

ModelFolder two_joints() {
  return parse_model(
      "format = 1\n[joint_default]\nactuator = \"dc_servo\"\narmature = 0.01\ncoulomb = 0.02\n",
      kTwoJoints, "two/model.toml");
}

/// 10 s at 100 Hz: columns u, q, dq of both joints.
recording::Recording healthy(double speed) {
  const ModelFolder model = two_joints();
  const Drive drive = test::make_test_drive(model, 10.0, 0.01, [&](int j, double t) {
    return j == 0 ? 0.5 * std::sin(1.7 * speed * t)
                  : 0.4 * std::sin(2.9 * speed * t) + 0.2 * std::sin(0.8 * t);
  });
  const std::vector<Window> whole{test::whole(drive, {0.0, 0.0}, {0.0, 0.0})};
  const Prediction p = simulate(make_params(model), drive, whole).front();
  recording::Recording r;
  r.t = drive.t;
  for (int j = 0; j < 2; ++j) {
    const std::string& name = model.tree.joints[static_cast<std::size_t>(j)].name;
    r.set("u:" + name, drive.joints[static_cast<std::size_t>(j)].command);
    const auto q = p.of(p.q, j), dq = p.of(p.dq, j);
    r.set("q:" + name, {q.begin(), q.end()});
    r.set("dq:" + name, {dq.begin(), dq.end()});
  }
  return r;
}

std::vector<double>& column(recording::Recording& r, const std::string& name) {
  for (recording::Channel& c : r.channels) {
    if (c.name == name) return c.values;
  }
  throw std::logic_error("no column " + name);
}

/// Replaces one cell of a written file by other text: what a broken logger writes, and our writer
/// would not.
void replace_cell(const std::string& file, int row, int cell, const std::string& text) {
  std::ifstream in(file);
  std::string out, line;
  for (int k = -1; std::getline(in, line); ++k) {
    if (k == row) {
      std::size_t begin = 0;
      for (int c = 0; c < cell; ++c) begin = line.find(',', begin) + 1;
      line.replace(begin, line.find(',', begin) - begin, text);
    }
    out += line + "\n";
  }
  in.close();
  std::ofstream(file) << out;
}

constexpr long kFirstMaximum = -2;  // the row where the channel first reaches its largest value

struct Broken {
  std::string name;
  std::string defect, channel;
  long row;                                                // -1: the whole column or file
  std::function<void(recording::Recording&)> columns;      // on the columns, or
  std::function<void(const std::string& file)> text = {};  // on the written file
};

void PrintTo(const Broken& b, std::ostream* out) { *out << b.name; }

std::vector<Broken> kinds() {
  const auto none = [](recording::Recording&) {};
  return {
      {"empty", "empty file", "", -1, none,
       [](const std::string& f) { std::ofstream(f, std::ios::trunc).close(); }},
      {"header_only", "header only", "", -1, none,
       [](const std::string& f) { std::ofstream(f) << "t,u:hip,q:hip,u:knee,q:knee\n"; }},
      {"ten_gigabytes", "file too large", "", -1, none,
       [](const std::string& f) {
         fs::resize_file(f, std::uintmax_t{10} << 30);
       }},  // sparse: takes no space
      {"nan", "not a number", "q:hip", 123, none,
       [](const std::string& f) { replace_cell(f, 123, 2, "nan"); }},
      {"infinite", "not a number", "dq:knee", 77, none,
       [](const std::string& f) { replace_cell(f, 77, 6, "inf"); }},
      {"degrees", "wrong unit", "q:knee", -1,
       [](recording::Recording& r) {
         for (double& x : column(r, "q:knee")) x *= 57.29578;
       }},
      {"swapped_joints", "swapped joints", "q:hip", -1,
       [](recording::Recording& r) {
         std::swap(column(r, "q:hip"), column(r, "q:knee"));
         std::swap(column(r, "dq:hip"), column(r, "dq:knee"));
       }},
      {"time_backwards", "time runs backwards", "t", 400,
       [](recording::Recording& r) {
         for (std::size_t k = 400; k < r.rows(); ++k) r.t[k] -= 2.0;
       }},
      {"time_repeats", "duplicate time stamp", "t", 300,
       [](recording::Recording& r) { r.t[300] = r.t[299]; }},
      {"gap", "gap", "t", 600,
       [](recording::Recording& r) {
         for (std::size_t k = 600; k < r.rows(); ++k) r.t[k] += 0.7;
       }},
      {"clipped", "clipped channel", "q:hip", kFirstMaximum,
       [](recording::Recording& r) {
         for (double& x : column(r, "q:hip")) x = std::min(x, 0.25);
       }},
      {"command_copy", "command is a copy of the position", "u:hip", -1,
       [](recording::Recording& r) { column(r, "u:hip") = column(r, "q:hip"); }},
      {"missing_channel", "missing channel", "q:knee", -1,
       [](recording::Recording& r) {
         std::erase_if(r.channels, [](const recording::Channel& c) { return c.name == "q:knee"; });
       }},
  };
}

class RefusedSet : public testing::Test {
 protected:
  void SetUp() override {
    write_model_folder(two_joints(), (folder_ / "model").string());
    options_.model = (folder_ / "model").string();
    options_.out = (folder_ / "out").string();
    options_.quiet = true;
  }
  std::string add(const recording::Recording& r) {
    options_.recordings.push_back(
        (folder_ / ("rec_" + std::to_string(options_.recordings.size()) + ".csv")).string());
    recording::write_csv(r, options_.recordings.back());
    return options_.recordings.back();
  }
  nlohmann::json refusal() {
    EXPECT_EQ(run_diagnose(options_), 2);
    std::set<std::string> written;
    for (const auto& entry : fs::directory_iterator(folder_ / "out"))
      written.insert(entry.path().filename().string());
    EXPECT_EQ(written, (std::set<std::string>{"report.html", "verdict.json", "verdict.txt"}))
        << "more than the refusal";
    std::ifstream file(folder_ / "out" / "verdict.json");
    const nlohmann::json verdict = nlohmann::json::parse(file);
    EXPECT_EQ(verdict.at("status"), "REFUSED");
    EXPECT_TRUE(verdict.at("findings").empty());
    return verdict.at("refused").empty() ? nlohmann::json{} : verdict.at("refused").at(0);
  }
  sanso::test::TempFolder temporary_;
  fs::path folder_ = temporary_.path();
  DiagnoseOptions options_;
};

class Refusal : public RefusedSet, public testing::WithParamInterface<Broken> {};

TEST_P(Refusal, NamesDefectFileChannelAndRow) {
  const Broken& kind = GetParam();
  add(healthy(1.0));  // the healthy file beside it is not blamed
  recording::Recording r = healthy(1.3);
  kind.columns(r);
  const std::string file = add(r);
  if (kind.text) kind.text(file);
  const nlohmann::json defect = refusal();
  EXPECT_EQ(defect.at("defect"), kind.defect) << defect.dump();
  EXPECT_EQ(defect.at("file"), file);
  EXPECT_EQ(defect.value("channel", ""), kind.channel) << defect.dump();
  long row = kind.row;
  if (row == kFirstMaximum) {
    const std::vector<double>& x = column(r, kind.channel);
    row = std::max_element(x.begin(), x.end()) - x.begin();
  }
  if (row >= 0) {
    EXPECT_EQ(defect.at("row"), row) << defect.dump();
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, Refusal, testing::ValuesIn(kinds()),
                         [](const auto& p) { return p.param.name; });

TEST_F(RefusedSet, ACopyIsBlamedOnTheCopy) {
  const recording::Recording original = healthy(1.0);
  add(original);
  recording::Recording copy = original;
  for (double& t : copy.t) t += 5.0;
  const std::string file = add(copy);
  const nlohmann::json defect = refusal();
  EXPECT_EQ(defect.at("defect"), "copy of another file");
  EXPECT_EQ(defect.at("file"), file);
}

TEST_F(RefusedSet, ABaseThatFloatsIsNotBoltedDown) {
  add(healthy(1.0));
  const fs::path toml = fs::path(options_.model) / "model.toml";
  std::stringstream text;
  text << std::ifstream(toml).rdbuf();
  std::string floating = text.str();
  const std::size_t at = floating.find("\"fixed\"");
  ASSERT_NE(at, std::string::npos);
  std::ofstream(toml) << floating.replace(at, 7, "\"floating\"");
  const nlohmann::json defect = refusal();
  EXPECT_EQ(defect.at("defect"), "missing channel");
  EXPECT_EQ(defect.at("channel"), "base_q:w");
  const std::string message = defect.at("message");
  EXPECT_NE(message.find("base = \"fixed\""), std::string::npos) << message;
}

}  // namespace
}  // namespace sanso::diagnose
