// The report of a session: what it says about trials that went well or failed, and what it refuses.
#include "tools/session_report/session_report.h"

#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>

#include "host/learn/session/session_state.h"

namespace sanso::report {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

struct SessionReport : testing::Test {
  fs::path folder;
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "sanso_report_XXXXXX").string();
    folder = mkdtemp(name.data());
  }
  void TearDown() override { fs::remove_all(folder); }

  /// A session of `trials` trials with falling cost; the second one failed.
  fs::path session(const std::string& name, std::uint32_t trials) const {
    auto state = std::make_unique<learn::SessionState>();
    state->identity = "motion squat";
    state->next_trial = trials;
    for (std::uint32_t k = 0; k < trials; ++k) {
      learn::TrialSummary t;
      t.trial = k;
      t.cost = 10.0 / (k + 1);
      t.end = k == 1 ? learn::TrialEnd::tilt : learn::TrialEnd::completed;
      t.update_ms = {2.0F, 3.0F, 41.5F};
      t.bus_lost = 7;
      state->history.push_back(t);
    }
    fs::create_directories(folder / name);
    learn::save_state(folder / name / "state.bin", *state);
    return folder / name;
  }
  static std::string text_of(const fs::path& file) {
    std::ifstream in(file);
    std::stringstream text;
    text << in.rdbuf();
    return text.str();
  }
};

TEST_F(SessionReport, TableHasALineForEveryTrial) {
  const std::string table = session_table(session("a", 3));
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 4);
  EXPECT_THAT(table, HasSubstr("leaned too far"));
  EXPECT_THAT(table, HasSubstr("41.50"));
}

TEST_F(SessionReport, ATrialThatAFaultEndedSaysWhich) {
  learn::TrialSummary t;
  t.end = learn::TrialEnd::fault, t.fault = 32;
  EXPECT_EQ(learn::how_it_ended(t), "controller fault F32");
  EXPECT_EQ(learn::how_it_ended({}), "completed");
}

TEST_F(SessionReport, PageNamesFirstLastAndBestTrial) {
  const std::string page = text_of(write_session_report(session("a", 4)));
  EXPECT_THAT(page,
              HasSubstr("4 trials, 1 failed; first cost 10.00, last 2.50, best 2.50 (trial 4)."));
  EXPECT_THAT(page, HasSubstr("Cost over trials"));
  EXPECT_THAT(page, HasSubstr("period 60 ms"));
  EXPECT_THAT(page, testing::Not(HasSubstr("http-equiv")));
  EXPECT_THAT(page, testing::Not(HasSubstr("<script"))) << "one file that needs nothing else";
}

TEST_F(SessionReport, ComparesSessionsByTheNameOfTheirFolder) {
  const std::string figure = compare_costs({session("all", 5), session("no_middle", 5) / ""});
  EXPECT_THAT(figure, HasSubstr(">all<"));
  EXPECT_THAT(figure, HasSubstr(">no_middle<"));
}

TEST_F(SessionReport, FiguresAreWritten) {
  write_session_figures(session("a", 3), folder / "figures");
  for (const char* name : {"cost.svg", "layers.svg", "gains.svg", "model.svg", "updates.svg"})
    EXPECT_THAT(text_of(folder / "figures" / name), HasSubstr("<svg")) << name;
}

TEST_F(SessionReport, AFolderWithoutASessionIsRefusedWithTheNextStep) {
  try {
    (void)session_table(folder);
    FAIL() << "accepted";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("expected the folder that `sanso learn --out`"));
  }
}

}  // namespace
}  // namespace sanso::report
