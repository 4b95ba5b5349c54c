// The command on a base that floats: exit codes, the files of each ending, and a written model that
// has what was found.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "tests/support/temp_folder.h"
#include "tests/tools/diagnose/wholebody/made_body.h"
#include "tools/diagnose/run/diagnose.h"
#include "tools/recording/csv_writer.h"

namespace sanso::diagnose {
namespace {

namespace fs = std::filesystem;
using namespace test;
using nlohmann::json;

constexpr double kG = 9.81, kMass = 5.0;

/// A robot of 5 kg that stands still on two feet, whose sensors weigh `share` of it, in `unit`.
recording::Recording standing(double share, double unit, unsigned long seed) {
  recording::Recording r;
  Random random(seed);
  std::vector<double> force;
  for (double t = 0.0; t < 8.0; t += 0.01) {
    r.t.push_back(t);
    force.push_back(unit * (0.5 * share * kMass * kG + 0.2 * random.normal()));
  }
  put(r, "q", "lr", [&](auto, auto) { return 1e-5 * random.normal(); });
  put(r, "base_p", "xyz", [&](auto, auto i) { return i == 2 ? 0.31 : 0.0; });
  put(r, "base_q", "wxyz", [](auto, auto i) { return i == 0 ? 1.0 : 0.0; });
  r.set("fz:l_foot", force), r.set("fz:r_foot", force);
  return r;
}

struct WholeCommand : testing::Test {
  sanso::test::TempFolder temporary;
  fs::path out = temporary.path() / "out";

  DiagnoseOptions options(double share, double unit = 1.0) const {
    DiagnoseOptions o;
    o.model = (temporary.path() / "model").string(), o.out = out.string(), o.quiet = true;
    write_whole_body(body_of("", kTwoLegs), o.model);
    for (const unsigned long seed : {1u, 2u}) {
      o.recordings.push_back(
          (temporary.path() / ("stand_" + std::to_string(seed) + ".csv")).string());
      recording::write_csv(standing(share, unit, seed), o.recordings.back());
    }
    return o;
  }
  std::string text(const char* file) const {
    std::ostringstream all;
    all << std::ifstream(out / file).rdbuf();
    return all.str();
  }
  json verdict() const { return json::parse(text("verdict.json")); }
};

TEST_F(WholeCommand, NothingMissingIsZeroAndWritesAll) {
  EXPECT_EQ(run_diagnose(options(1.0)), 0);
  EXPECT_EQ(verdict().at("status"), "ABSENT");
  EXPECT_NE(text("verdict.txt").find("answer     ABSENT"), std::string::npos);
  EXPECT_NE(text("report.html").find("<html"), std::string::npos);
  EXPECT_TRUE(fs::exists(out / "model" / "robot.urdf"));
}

TEST_F(WholeCommand, AMismatchIsOneAndItsModelHasIt) {
  DiagnoseOptions o = options(1.2);
  EXPECT_EQ(run_diagnose(o), 1);
  const json found = verdict().at("findings");
  ASSERT_EQ(found.size(), 1u);
  const std::string name = found.at(0).at("effect");
  EXPECT_NE(text("verdict.txt").find(name), std::string::npos);
  EXPECT_NE(text("report.html").find(name), std::string::npos);
  // what was found is known now
  o.model = (out / "model").string(), o.out = (temporary.path() / "again").string();
  EXPECT_EQ(run_diagnose(o), 0);
}

TEST_F(WholeCommand, RefusedIsTwoAndLeavesNoModel) {
  EXPECT_EQ(run_diagnose(options(1.0, 1.0 / kG)), 2);
  EXPECT_EQ(verdict().at("status"), "REFUSED");
  EXPECT_EQ(verdict().at("refused").at(0).at("channel"), "fz:l_foot");
  EXPECT_NE(text("verdict.txt").find("refused"), std::string::npos);
  EXPECT_FALSE(fs::exists(out / "model"));
}

TEST_F(WholeCommand, AFileThatIsNotThereIsNamed) {
  DiagnoseOptions o = options(1.0);
  o.recordings = {(temporary.path() / "none.csv").string()};
  EXPECT_EQ(run_diagnose(o), 2);
  EXPECT_NE(verdict().at("refused").at(0).at("file").get<std::string>().find("none.csv"),
            std::string::npos);
}

}  // namespace
}  // namespace sanso::diagnose
