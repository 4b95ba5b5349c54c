// A model scores well on what it made itself and badly on another robot; every example folder is
// read and scored.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "shared/files/input_error.h"
#include "tests/support/shared_data.h"
#include "tests/support/small_world.h"
#include "tools/diagnose/run/score.h"
#include "tools/recording/csv_reader.h"

namespace sanso::diagnose {
namespace {

/// A recording of what the model does when it follows a sum of two sines.
recording::Recording recorded(const ModelFolder& model, double duration) {
  const Drive drive = test::make_test_drive(model, duration, 0.005, [](int, double t) {
    return 0.5 * std::sin(4 * t) + 0.3 * std::sin(7 * t);
  });
  return test::record(model, drive, {.velocity = true, .duty = true});
}

constexpr const char* kServo = "actuator = \"dc_servo\"\narmature = 0.01\n";

TEST(Score, IsSmallForTheTruthAndLargeForAnother) {
  const ModelFolder truth = test::pendulum(std::string(kServo) + "coulomb = 0.2\n");
  const recording::Recording r = recorded(truth, 6.0);
  const RecordingScore good = score(truth, r), bad = score(test::pendulum(kServo), r);
  for (std::size_t h = 0; h < 4; ++h) {
    EXPECT_LT(good.horizons[h].rmse, 3e-4) << h;  // what smoothing the start costs
    EXPECT_GT(bad.horizons[h].rmse, 10 * good.horizons[h].rmse) << h;
    EXPECT_EQ(good.horizons[h].channels.size(), 3u);
    EXPECT_EQ(good.horizons[h].rmse, good.horizons[h].channels.at("q:a"));
  }
}

TEST(Score, JsonHasTheAgreedForm) {
  const ModelFolder model = test::pendulum(kServo);
  const auto json = nlohmann::json::parse(score_json({score(model, recorded(model, 3.0))}));
  const auto& r = json.at("recordings").at(0);
  EXPECT_EQ(r.at("file"), "made.csv");
  for (const char* h : {"0.1", "0.5", "2", "whole"}) {
    EXPECT_TRUE(r.at("horizons").at(h).at("rmse").is_number());
    EXPECT_TRUE(r.at("horizons").at(h).at("channels").at("q:a").is_number());
  }
}

TEST(Score, RefusesWhatCannotBeSimulated) {
  const ModelFolder model = test::pendulum(kServo);
  recording::Recording r = recorded(model, 1.0);
  recording::Recording no_command = r;
  std::erase_if(no_command.channels, [](const auto& c) { return c.name == "u:a"; });
  EXPECT_THROW(score(model, no_command), files::InputError);
  recording::Recording backwards = r;
  std::swap(backwards.t[10], backwards.t[11]);
  EXPECT_THROW(score(model, backwards), files::InputError);
  recording::Recording other = r;
  other.channels[0].name = "q:b";
  EXPECT_THROW(score(model, other), files::InputError);
}

struct Example {
  const char* model;
  std::vector<const char*> recordings;
};

TEST(Examples, OfEveryActuatorAreReadAndScoreTheirRealRecordings) {
  const Example examples[] = {
      {"bam_xl330", {"bam_xl330/kp400_sin_sin.csv", "bam_xl330/kp100_lift_and_drop.csv"}},
      {"bam_sts3250", {"bam_sts3250/sin_sin.csv", "bam_sts3250/lift_and_drop.csv"}},
      {"dfki_double_pendulum", {"dfki_double_pendulum/C1_143339.csv"}},
      {"dfki_double_pendulum_C0", {"dfki_double_pendulum/C0_00.csv"}},
      {"emps", {"emps/DATA_EMPS.csv"}},
      {"staubli_tx40", {"staubli_tx40/first60.csv.gz"}},
      {"cogging_odrive", {"cogging_odrive/slow2_nocomp_0.csv"}},
      {"uart_servo_backlash_single", {"uart_servo_backlash/single.csv"}},
      {"uart_servo_backlash_nocomp2", {"uart_servo_backlash/nocomp2.csv"}},
      {"passive_pendulum", {}},
  };
  const auto real = sanso::test::shared_data() / "real";
  int scored = 0;
  for (const Example& example : examples) {
    const ModelFolder model =
        read_model_folder(std::string("tools/diagnose/examples/") + example.model);
    for (const char* file : example.recordings) {
      if (!std::filesystem::exists(real / file)) continue;
      const RecordingScore s = score(model, recording::read_csv((real / file).string()));
      for (const HorizonScore& h : s.horizons)
        EXPECT_TRUE(std::isfinite(h.rmse) && h.rmse > 0.0) << file;
      // the arm of 27 kg without its rotors is no usable model of its wrist, and says so: its file
      // leaves them out on purpose
      const double bound = example.model == std::string("staubli_tx40") ? 1e3 : 0.2;
      EXPECT_LE(s.horizons[0].rmse, bound) << file << ": 0.1 s from the measured state";
      ++scored;
    }
  }
  if (scored == 0)
    GTEST_SKIP() << "examples read; no real recordings at " << real << " (set SANSO_DATA)";
}

}  // namespace
}  // namespace sanso::diagnose
