// Episodes read back bit for bit; every truncation and flipped byte is refused; a full disk
// leaves nothing half.
#include <gmock/gmock.h>

#include <cstdlib>
#include <fstream>

#include "host/learn/episodes/episode.h"
#include "host/learn/seeds.h"
#include "shared/files/atomic_file.h"
#include "shared/files/framed.h"

namespace sanso::learn {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

struct EpisodeStore : testing::Test {
  fs::path folder;
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "sanso_store_XXXXXX").string();
    folder = mkdtemp(name.data());
  }
  void TearDown() override { fs::remove_all(folder); }
};

Episode example() {
  Episode e{.trial = 7,
            .seed = 42,
            .end = TrialEnd::tilt,
            .fault = 3,
            .cost = 0.1 + 0.2,
            .cost_terms = {0.1, 0.2},
            .ticks = {},
            .reference = {},
            .plans = {},
            .before = {},
            .quiet_at_start = false,
            .truth = {{.foot_load_N = {1.5f, 2.5f}, .foot_clearance_m = {0.01f, -0.0002f}}}};
  wire::Observation o;
  o.trial_tick = 12;
  o.x[3] = 1.0 / 3.0;
  o.u_out[11] = -0.7;
  o.current_raw[4] = -123;
  o.late_ticks = 9;
  e.ticks = {o, o};
  PlanRecord plan;
  plan.update_ms = 2.25;
  plan.policy.first_tick = 18;
  plan.policy.knots.try_push(
      {model::Input::Constant(0.1), model::neutral_state(), model::Gain::Random()});
  e.plans = {plan};
  e.before = {o, o, o};
  e.before[2].trial_tick = -1;
  e.quiet_at_start = true;
  return e;
}

TEST_F(EpisodeStore, GivesBackTheSameBits) {
  const Episode e = example();
  save_episode(folder / "t.episode", e);
  const Episode r = load_episode(folder / "t.episode");
  EXPECT_EQ(r.cost, e.cost);
  EXPECT_EQ(r.end, e.end);
  EXPECT_EQ(r.quiet_at_start, e.quiet_at_start);
  ASSERT_EQ(r.before.size(), 3u);
  EXPECT_EQ(r.before[2].trial_tick, -1);
  EXPECT_TRUE(r.before[0].u_out == e.before[0].u_out);
  EXPECT_EQ(r.cost_terms, e.cost_terms);
  ASSERT_EQ(r.ticks.size(), 2u);
  EXPECT_EQ(r.ticks[1].x, e.ticks[1].x);
  EXPECT_EQ(r.ticks[1].u_out, e.ticks[1].u_out);
  EXPECT_EQ(r.ticks[1].current_raw, e.ticks[1].current_raw);
  EXPECT_EQ(r.ticks[1].late_ticks, 9u);
  ASSERT_EQ(r.plans.size(), 1u);
  EXPECT_EQ(r.plans[0].policy.knots[0].K, e.plans[0].policy.knots[0].K);
  EXPECT_EQ(r.plans[0].policy.first_tick, 18);
  ASSERT_EQ(r.truth.size(), 1u);
  EXPECT_EQ(r.truth[0].foot_load_N, e.truth[0].foot_load_N);
  EXPECT_EQ(r.truth[0].foot_clearance_m, e.truth[0].foot_clearance_m);
}

TEST_F(EpisodeStore, EveryTruncationAndEveryFlippedByteIsRefused) {
  save_episode(folder / "t.episode", example());
  const std::vector<std::uint8_t> good = files::read_file(folder / "t.episode");
  for (std::size_t n = 0; n < good.size(); n += 37) {
    files::write_atomically(folder / "cut", std::span(good).first(n));
    EXPECT_THROW(load_episode(folder / "cut"), std::runtime_error) << n;
  }
  for (std::size_t i = 0; i < good.size(); i += 101) {
    std::vector<std::uint8_t> bad = good;
    bad[i] ^= 0x40;
    files::write_atomically(folder / "bad", bad);
    EXPECT_THROW(load_episode(folder / "bad"), std::runtime_error) << i;
  }
}

TEST_F(EpisodeStore, AFullDiskSaysSoAndLeavesNothingHalf) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  fs::create_symlink("/dev/full",
                     // the temporary file's name: every write to it finds no space
                     folder / "t.episode.new");
  try {
    save_episode(folder / "t.episode", example());
    FAIL() << "expected an error";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("No space left"));
    EXPECT_THAT(error.what(), HasSubstr("--resume"));
  }
  EXPECT_FALSE(fs::exists(folder / "t.episode"));
  EXPECT_FALSE(fs::exists(fs::symlink_status(folder / "t.episode.new")));
}

TEST_F(EpisodeStore, AMissingFolderIsNamed) {
  try {
    files::write_atomically(folder / "none" / "x", "text");
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("none/x"));
  }
}

TEST(Seeds, DependOnTrialAndStreamOnly) {
  EXPECT_EQ(derived_seed(1, 2, Stream::robot), derived_seed(1, 2, Stream::robot));
  EXPECT_NE(derived_seed(1, 2, Stream::robot), derived_seed(1, 3, Stream::robot));
  EXPECT_NE(derived_seed(1, 2, Stream::robot), derived_seed(1, 2, Stream::residual));
  EXPECT_NE(derived_seed(1, 2, Stream::robot), derived_seed(2, 1, Stream::robot));
}

}  // namespace
}  // namespace sanso::learn
