// The table of every setting halved and doubled: what changes is shown with its case, what does
// not is listed, and neither the order in which answers came nor a missing half counts.
#include "tools/bench/diagnose/sensitivity.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "shared/files/json.h"
#include "tests/support/temp_folder.h"

namespace sanso::bench {
namespace {

std::vector<ScaledAnswer> some_answers() {
  return {
      {"", 1.0, "one", "CONFIRMED mass", true, 0},
      {"", 1.0, "two", "ABSENT ", true, 0},
      {"group.rivals", 0.5, "one", "CONFIRMED mass", true, 0},
      {"group.rivals", 0.5, "two", "ABSENT ", true, 0},
      {"group.rivals", 2.0, "one", "CONFIRMED mass", true, 0},
      {"group.rivals", 2.0, "two", "ABSENT ", true, 0},
      {"group.level", 0.5, "one", "CONFIRMED mass", true, 0},
      {"group.level", 0.5, "two", "CONFIRMED delay", false, 1},
      {"group.level", 2.0, "one", "no answer: nothing left", false, 0},
      {"group.level", 2.0, "two", "ABSENT ", true, 0},
      {"group.attempts", 2.0, "one", "CONFIRMED mass", true, 0},
      {"group.attempts", 2.0, "two", "ABSENT ", true, 0},
  };
}

TEST(Sensitivity, ShowsWhatChangesAndListsWhatDoesNot) {
  const std::string table = sensitivity_table(some_answers());
  EXPECT_NE(table.find("As they are: 2 of 2 right, 0 `CONFIRMED` wrongly.\n"), std::string::npos)
      << table;
  EXPECT_NE(table.find("with half and double of 2 of 3: `group.attempts`, `group.rivals`."),
            std::string::npos)
      << table;
  EXPECT_NE(table.find("| `group.level` | 1 of 2 right, 1 `CONFIRMED` wrongly; two: CONFIRMED "
                       "delay | 1 of 2 right, 0 `CONFIRMED` wrongly; one: no answer: nothing left "
                       "|\n"),
            std::string::npos)
      << table;
}

TEST(Sensitivity, IsTheSameInWhateverOrderAnswersCame) {
  std::vector<ScaledAnswer> answers = some_answers();
  const std::string table = sensitivity_table(answers);
  std::reverse(answers.begin(), answers.end());
  EXPECT_EQ(sensitivity_table(answers), table);
}

TEST(Sensitivity, RefusesAGroupThatThereIsNot) {
  SensitivityOptions options;
  options.only = {"decisions", "group"};
  EXPECT_THROW(bench_sensitivity(options), std::invalid_argument);
}

/// A case of which nothing can be said: two rows.
void write_case(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  std::filesystem::copy("tools/diagnose/examples/passive_pendulum", folder / "model");
  std::ofstream(folder / "rec_0.csv") << "t,q:joint\n0,0\n0.01,0\n";
  std::ofstream(folder / "answer.json")
      << R"({"family":"null","robot":"pendulum","effects":[],"severity":null})";
}

TEST(Sensitivity, AsksOnceForEveryScalingAndGoesOnWhereItWasStopped) {
  const test::TempFolder folder;
  write_case(folder.path() / "cases" / "one");
  SensitivityOptions options;
  options.folder = (folder.path() / "cases").string();
  options.out = (folder.path() / "out").string();
  options.only = {"decisions.rivals", "fitting.converged"};
  EXPECT_EQ(bench_sensitivity(options), 0);
  const std::filesystem::path kept = folder.path() / "out" / "sensitivity.json";
  nlohmann::json answers = files::read_json(kept);
  ASSERT_EQ(answers.size(), 5u) << "as it is, and two settings halved and doubled";
  for (nlohmann::json& a : answers) {
    EXPECT_FALSE(a.at("said").get<std::string>().empty());
    a["said"] = "kept";
  }
  answers.erase(4);
  std::ofstream(kept) << answers.dump();
  options.resume = true;
  EXPECT_EQ(bench_sensitivity(options), 0);
  answers = files::read_json(kept);
  ASSERT_EQ(answers.size(), 5u);
  EXPECT_EQ(std::count_if(answers.begin(), answers.end(),
                          [](const nlohmann::json& a) { return a.at("said") == "kept"; }),
            4);
}

}  // namespace
}  // namespace sanso::bench
