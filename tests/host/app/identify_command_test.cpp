// Identification outside a session: what it finds, and that a stopped search loses nothing.
#include "host/app/identify_command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "shared/files/atomic_file.h"
#include "tests/host/learn/model/learner_world.h"
#include "tests/support/temp_folder.h"

namespace sanso::app {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const auto never = [] { return false; };

struct IdentifyEpisodes : testing::Test {
  test::TempFolder folder;
  IdentifyOptions options;

  /// Five trials of a robot whose servos have 0.7 of the stiffness believed.
  IdentifyEpisodes() {
    for (const learn::Episode& e : learn::episodes(5))
      learn::save_episode(folder.path() / ("trial_000" + std::to_string(e.trial) + ".episode"), e);
    options.episodes = {folder.path()};
    options.motion = "stand";
    options.population = 16;
    options.generations = 4;
    options.out = folder.path() / "found";
    options.quiet = true;
    fs::create_directories(options.out);
  }

  std::string refusal() const {
    try {
      (void)search_parameters(options, load_identification_data(options), never);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "nothing refused";
  }
};

TEST_F(IdentifyEpisodes, NewestTrialsAreHeldOut) {
  const IdentificationData data = load_identification_data(options);
  ASSERT_FALSE(data.heldout.empty());
  for (const learn::PredictionWindow& w : data.heldout) EXPECT_EQ(w.trial, 4u);
  for (const learn::PredictionWindow& w : data.train) EXPECT_LT(w.trial, 4u);
}

TEST_F(IdentifyEpisodes, FindsSofterServosAndSaysSo) {
  options.out = folder.path() / "command";
  options.population = 32;
  options.generations = 8;
  EXPECT_EQ(identify(options), 0) << "held-out trials are predicted better";
  const std::vector<std::uint8_t> bytes = files::read_file(options.out / "identification.json");
  EXPECT_THAT(std::string(bytes.begin(), bytes.end()), HasSubstr("stiffness_Nm_per_rad"));
  options.out.clear();
  const auto found = search_parameters(options, load_identification_data(options), never);
  EXPECT_LT(found.loss, 0.3 * found.loss_initial);
  EXPECT_LT(found.parameters.servo[3].stiffness,
            0.9 * model::nominal_parameters().servo[3].stiffness);
}

TEST_F(IdentifyEpisodes, StoppedAndResumedIsTheSameSearch) {
  const IdentificationData data = load_identification_data(options);
  IdentifyOptions apart = options;
  apart.out.clear();
  const auto whole = search_parameters(apart, data, never);

  int asked = 0;
  EXPECT_EQ(search_parameters(options, data, [&asked] { return ++asked == 2; }).generations, 2);
  options.resume = true;
  const auto resumed = search_parameters(options, data, never);
  EXPECT_EQ(resumed.generations, 4);
  EXPECT_EQ(resumed.z, whole.z) << "bit for bit";
}

TEST_F(IdentifyEpisodes, AnotherSearchIsNotContinued) {
  (void)search_parameters(options, load_identification_data(options), never);
  EXPECT_THAT(refusal(), HasSubstr("--resume")) << "a search is there: it is not written over";
  options.resume = true;
  options.seed = 99;
  EXPECT_THAT(refusal(), HasSubstr("another seed"));
  files::write_atomically(options.out / "search.state", std::string_view("no search"));
  EXPECT_THAT(refusal(), HasSubstr("not a file of kind"));
}

TEST_F(IdentifyEpisodes, MissingThingsAreNamed) {
  options.motion.clear();
  EXPECT_THAT(refusal(), HasSubstr("name it with --motion"));
  options.episodes = {options.out};
  options.motion = "stand";
  EXPECT_THAT(refusal(), HasSubstr("no trial_NNNN.episode"));
  options.episodes = {folder.path() / "nowhere"};
  EXPECT_THAT(refusal(), HasSubstr("no such folder"));
}

}  // namespace
}  // namespace sanso::app
