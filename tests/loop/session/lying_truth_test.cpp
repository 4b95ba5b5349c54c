// What only an emulated world knows is for reports: a session whose robot lies about it plans and
// learns the same bits.
#include <gtest/gtest.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "shared/files/atomic_file.h"
#include "tests/support/temp_folder.h"
#include "tools/inprocess/inprocess_access.h"

namespace sanso::loop {
namespace {

/// Says that it never moved, that its feet were high above the floor and that both carried.
class Liar : public inprocess::InProcessAccess {
 public:
  using InProcessAccess::InProcessAccess;
  void add_measurements(learn::Episode& episode) override {
    InProcessAccess::add_measurements(episode);
    for (learn::TrueSample& truth : episode.truth) {
      truth.x = model::neutral_state();
      truth.foot_load_N = {20.0F, 20.0F};
      truth.foot_clearance_m = {1.0F, 1.0F};
    }
  }
};

/// summary.json of three trials of soft servos, with a round of model learning after the second.
template <class Robot>
nlohmann::json sidestepped(const std::filesystem::path& out) {
  app::LearnOptions options;
  options.motion = "sidestep";
  options.world = "worst";
  options.iterations = 3;
  options.out = out;
  options.threads = 1;
  options.quiet = true;
  options.set = {"session.learn_first_after=2", "identify.generations=2"};
  app::learn(options, [](const app::LearnOptions& prepared) {
    return std::make_unique<Robot>(prepared.world);
  });
  return nlohmann::json::parse(files::read_text(out / "summary.json"));
}

TEST(LyingTruth, NothingThatPlansOrLearnsReadsIt) {
  const test::TempFolder folder;
  const nlohmann::json honest = sidestepped<inprocess::InProcessAccess>(folder.path() / "honest"),
                       lied = sidestepped<Liar>(folder.path() / "lied");
  EXPECT_EQ(honest["learned_digest"], lied["learned_digest"]);
  ASSERT_EQ(honest["iterations"].size(), 3U);
  ASSERT_EQ(lied["iterations"].size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    const nlohmann::json &h = honest["iterations"][i], &l = lied["iterations"][i];
    for (const char* what :
         {"digest", "cost", "sigma", "input_share", "lifted_share", "model_loss", "residual_share"})
      EXPECT_EQ(h[what], l[what]) << what << ", trial " << i + 1;
    EXPECT_NE(h["cost_true"], l["cost_true"]) << "the premise: it lied";
    EXPECT_NE(h["broken_clauses"], l["broken_clauses"]) << "the premise: reports believe it";
  }
  EXPECT_LT(honest["iterations"][2]["input_share"].get<double>(), 1.0)
      << "the premise: inputs became cheaper";
}

}  // namespace
}  // namespace sanso::loop
