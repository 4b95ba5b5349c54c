// What several ranks find together equals what one finds alone. Run by mpirun (two_ranks.sh); every
// rank runs every test.
#include <gtest/gtest.h>
#include <signal.h>

#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>
#include <sstream>

#include "tests/support/temp_folder.h"
#include "tools/inprocess/inprocess_access.h"
#include "tools/sweep/identification.h"
#include "tools/sweep/pushes.h"
#include "tools/sweep/ranks.h"
#include "tools/sweep/sessions.h"

namespace sanso::sweep {
namespace {

namespace fs = std::filesystem;

std::unique_ptr<learn::RobotAccess> in_process(const app::LearnOptions& options) {
  return std::make_unique<inprocess::InProcessAccess>(options.world);
}

/// Ranks together, this rank alone, and a folder that all of them see and one of its own.
struct TwoRanks : testing::Test {
  Ranks all;
  Ranks alone{MPI_COMM_SELF};
  std::unique_ptr<test::TempFolder> made =
      all.rank() == 0 ? std::make_unique<test::TempFolder>() : nullptr;
  fs::path folder = path_of_first();
  fs::path own = folder / ("rank" + std::to_string(all.rank()));

  TwoRanks() { fs::create_directories(own); }
  // nobody removes the folder before all are done with it
  ~TwoRanks() override { (void)all.any(false); }

  fs::path path_of_first() const {
    std::string text = made ? made->path().string() : std::string();
    text.resize(4096);
    MPI_Bcast(text.data(), static_cast<int>(text.size()), MPI_CHAR, 0, MPI_COMM_WORLD);
    return text.c_str();
  }
};

/// Standing, one trial a session.
SessionsOptions standing(const fs::path& out, std::vector<std::uint64_t> seeds) {
  SessionsOptions o;
  o.motions = {"stand"};
  o.seeds = std::move(seeds);
  o.iterations = 1;
  o.out = out;
  fs::create_directories(out);
  return o;
}

nlohmann::json rows_of(const fs::path& file, const char* key) {
  std::ifstream in(file);
  return nlohmann::json::parse(in).at(key);
}

TEST_F(TwoRanks, AreTwo) { EXPECT_EQ(all.size(), 2); }

TEST_F(TwoRanks, TakeEveryJobOnceAndNoneAfterAStop) {
  constexpr int kJobs = 50;
  std::string mine;
  for (int job = all.take_job(); job < kJobs; job = all.take_job())
    mine += std::to_string(job) + " ";
  std::multiset<int> taken;
  for (const std::string& part : all.gather(mine)) {
    std::istringstream in(part);
    for (int job; in >> job;) taken.insert(job);
  }
  if (all.rank() == 0) {
    ASSERT_EQ(taken.size(), static_cast<std::size_t>(kJobs));
    for (int job = 0; job < kJobs; ++job) EXPECT_EQ(taken.count(job), 1u) << job;
  }
  if (all.rank() == 1) all.take_no_more();
  (void)all.any(false);
  EXPECT_GT(all.take_job(), 1'000'000);
  EXPECT_TRUE(all.any(all.rank() == 1));
  EXPECT_FALSE(all.any(false));
}

TEST_F(TwoRanks, LearnAndIdentifyWhatOneDoes) {
  const SessionsOptions together = standing(folder / "together", {1, 2}),
                        single = standing(own / "alone", {1, 2});
  EXPECT_EQ(run_sessions(all, together, in_process), 0);
  EXPECT_EQ(run_sessions(alone, single, in_process), 0);
  (void)all.any(false);  // sweep.json is written
  EXPECT_EQ(rows_of(together.out / "sweep.json", "sessions"),
            rows_of(single.out / "sweep.json", "sessions"));

  app::IdentifyOptions options;
  options.episodes = {together.out / "stand_lab_seed1"};
  options.population = 8;
  options.generations = 2;
  options.quiet = true;
  const app::IdentificationData data = app::load_identification_data(options);
  const learn::Identification shared = identify_over(all, options, data),
                              own_search = identify_over(alone, options, data);
  EXPECT_EQ(shared.generations, 2);
  EXPECT_EQ(shared.loss, own_search.loss);
  EXPECT_EQ(shared.z, own_search.z) << "bit for bit";
  EXPECT_LT(shared.loss, shared.loss_initial);

  PushOptions pushes;
  pushes.session = options.episodes.front();
  pushes.motion = "stand";
  pushes.without = {"none", "upper"};
  pushes.count = 1;
  pushes.out = folder;
  EXPECT_EQ(run_pushes(all, pushes), 0);
  pushes.out = own;
  EXPECT_EQ(run_pushes(alone, pushes), 0);
  (void)all.any(false);
  EXPECT_EQ(rows_of(folder / "pushes.json", "pushes"), rows_of(own / "pushes.json", "pushes"));
}

TEST_F(TwoRanks, AStopAtOneRankEndsAllAfterTheTrialsUnderWayAndTheSameCallGoesOn) {
  // more than one rank could begin before the other has told it to stop
  constexpr std::size_t kSessions = 40;
  std::vector<std::uint64_t> seeds(kSessions);
  std::iota(seeds.begin(), seeds.end(), 1);
  std::size_t begun = 0;
  const auto stopped_at_rank_1 = [&](const app::LearnOptions& o) {
    if (++begun == 1) {
      (void)all.any(false);  // both ranks have begun a session
      if (all.rank() == 1) raise(SIGTERM);
    }
    return in_process(o);
  };
  const int code = run_sessions(all, standing(folder / "stopped", seeds), stopped_at_rank_1);
  if (all.rank() == 1) {
    EXPECT_EQ(begun, 1u);
  } else {
    EXPECT_EQ(code, 2);
    EXPECT_LT(begun, kSessions - 1);
    EXPECT_EQ(rows_of(folder / "stopped" / "sweep.json", "sessions").size(), begun + 1);
  }

  Ranks later;  // another run: jobs are counted from the beginning
  const SessionsOptions again = standing(folder / "stopped", {1, 2});
  EXPECT_EQ(run_sessions(later, again, in_process), 0);
  (void)all.any(false);
  const nlohmann::json rows = rows_of(again.out / "sweep.json", "sessions");
  ASSERT_EQ(rows.size(), 2u);
  for (const nlohmann::json& row : rows) EXPECT_EQ(row.at("trials"), 1) << row;
}

}  // namespace
}  // namespace sanso::sweep

int main(int argc, char** argv) {
  const sanso::sweep::Mpi mpi(&argc, &argv);
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
