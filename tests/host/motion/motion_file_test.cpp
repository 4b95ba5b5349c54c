// Motion files: exact round trip, strict reading, and what a shipped motion has to fulfil.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "host/motion/catalogue.h"
#include "host/motion/make/balance.h"
#include "host/motion/make/body_kinematics.h"
#include "host/motion/make/import.h"
#include "host/motion/make/skate.h"
#include "host/motion/motion.h"
#include "shared/model/joints.h"
#include "tests/support/temp_folder.h"

namespace sanso::motion {
namespace {

using ::testing::HasSubstr;

std::string file_text(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string message_of(const std::string& text) {
  try {
    parse_motion(text, "m.toml");
  } catch (const MotionError& error) {
    return error.what();
  }
  return "no error";
}

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  const auto at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return at == std::string::npos ? text : text.replace(at, what.size(), with);
}

double lowest_corner(const BodyPoints& points, int side) {
  double lowest = 1.0;
  for (const auto& corner : points.sole_corners(side)) lowest = std::min(lowest, corner.z());
  return lowest;
}

/// Motions of the library that were made from clips: all that do not roll.
std::vector<std::string> of_clips() {
  std::vector<std::string> out = MotionLibrary().names();
  const std::vector<std::string> rolling = skate_names();
  std::erase_if(out, [&](const std::string& name) {
    return std::find(rolling.begin(), rolling.end(), name) != rolling.end();
  });
  return out;
}

/// What an unknown name is told there is, in order.
template <class Load>
std::vector<std::string> told_to_be_there(const Load& load) {
  std::string text;
  try {
    load("cartwheel");
  } catch (const MotionError& error) {
    text = error.what();
  }
  EXPECT_THAT(text, HasSubstr("no motion named 'cartwheel'"));
  std::vector<std::string> out;
  std::istringstream words(text.substr(text.rfind(": ") + 2));
  for (std::string word; std::getline(words >> std::ws, word, ',');) out.push_back(word);
  return out;
}

class ShippedMotion : public ::testing::TestWithParam<std::string> {
 protected:
  Motion motion_ = MotionLibrary().load(GetParam());
};

TEST_P(ShippedMotion, FileIsSmallAndWritesBackToItself) {
  const auto path = MotionLibrary().folder() / (GetParam() + ".toml");
  EXPECT_LT(std::filesystem::file_size(path), 400'000u);
  EXPECT_EQ(to_toml(motion_), file_text(path));
  EXPECT_EQ(motion_.name, GetParam());
  EXPECT_NE(motion_.source.licence, "not stated");
}

TEST_P(ShippedMotion, StaysWithinTheServosAndTheJoints) {
  for (const auto& x : motion_.reference().x) {
    for (int j = 0; j < model::kNumJoints; ++j) {
      ASSERT_LT(std::abs(x[model::kXJointRate + j]), kMaxReferenceSpeed) << model::kJoints[j].name;
      ASSERT_GT(x[model::kXJoint + j], model::kJoints[j].lower_rad) << model::kJoints[j].name;
      ASSERT_LT(x[model::kXJoint + j], model::kJoints[j].upper_rad) << model::kJoints[j].name;
    }
  }
}

TEST_P(ShippedMotion, StartsAndEndsAtRestOnBothFeetSideBySide) {
  const Trajectory reference = motion_.reference();
  for (const auto* x : {&reference.x.front(), &reference.x.back()}) {
    EXPECT_LT(x->tail<model::kNv>().norm(), 0.05);
    const BodyPoints points = body_points(*x);
    for (int side : {kRight, kLeft}) EXPECT_NEAR(lowest_corner(points, side), 0.0, 0.001);
    EXPECT_NEAR(points.p_world_foot[kLeft].x(), points.p_world_foot[kRight].x(), 0.002);
    EXPECT_NEAR(points.p_world_foot[kLeft].y() - points.p_world_foot[kRight].y(), 0.070, 0.002);
  }
}

TEST_P(ShippedMotion, KeepsTheZmpInsideTheSolesThatAreDown) {
  const Trajectory reference = motion_.reference();
  const std::vector<ZmpSample> zmp = zmp_of(reference);
  double worst = 1.0;
  for (std::size_t k = 0; k < zmp.size(); ++k) {
    const BodyPoints points = body_points(reference.x[k]);
    std::vector<Eigen::Vector2d> corners;
    for (int side : {kRight, kLeft}) {
      if (lowest_corner(points, side) > 0.001) continue;
      for (const auto& corner : points.sole_corners(side)) corners.push_back(corner.head<2>());
    }
    if (!corners.empty())
      worst = std::min(worst, distance_inside_hull({zmp[k].x, zmp[k].y}, corners));
  }
  // the jog changes feet through a flight, where the ZMP has to cross from sole to sole
  EXPECT_GT(worst, GetParam() == "jog" ? 0.0 : 0.010);
}

TEST_P(ShippedMotion, AnEpisodeThatIsTheReferenceSucceedsInWhatPosesShow) {
  // loads and pressure are forces, a reference has none: only the clauses about poses can be judged
  MotionEpisode episode;
  episode.completed = true;
  for (const auto& x : motion_.reference().x) {
    EpisodeSample sample;
    sample.x = x;
    const BodyPoints points = body_points(x);
    for (int side : {kRight, kLeft}) {
      sample.foot_clearance_m[side] = lowest_corner(points, side);
      sample.foot_m[side] = points.p_world_foot[side].head<2>();
    }
    episode.samples.push_back(sample);
  }
  int judged = 0;
  for (const auto& result : evaluate(motion_, episode).clauses) {
    if (std::isnan(result.value)) continue;
    ++judged;
    EXPECT_TRUE(result.holds) << result.text();
  }
  EXPECT_GE(judged, 5);
}

INSTANTIATE_TEST_SUITE_P(Library, ShippedMotion, ::testing::ValuesIn(of_clips()),
                         [](const auto& suite) { return suite.param; });

TEST(MotionLibrary, HoldsTheCatalogueAndNamesItWhenAskedForSomethingElse) {
  const std::vector<std::string> names = MotionLibrary().names();
  EXPECT_THAT(told_to_be_there(catalogue_entry), ::testing::UnorderedElementsAreArray(of_clips()));
  EXPECT_EQ(of_clips().size() + skate_names().size(), names.size());
  EXPECT_THAT(told_to_be_there([](const std::string& name) { MotionLibrary().load(name); }),
              ::testing::UnorderedElementsAreArray(names));
}

TEST(MotionLibrary, OfAnInstalledProgramStandsBesideIt) {
  const test::TempFolder prefix;
  const auto motions = prefix.path() / "share" / "sanso" / "motions";
  EXPECT_EQ(installed_motions(prefix.path() / "bin" / "sanso"), "") << "nothing installed there";
  std::filesystem::create_directories(motions);
  EXPECT_EQ(installed_motions(prefix.path() / "bin" / "sanso"), motions);
  EXPECT_EQ(installed_motions(prefix.path() / "sanso"), "") << "a build tree";
  EXPECT_EQ(motions_of(prefix.path() / "bin" / "sanso"), motions);
  EXPECT_EQ(motions_of(prefix.path() / "sanso"), "") << "taken elsewhere";
  const auto here = std::filesystem::read_symlink("/proc/self/exe");
  EXPECT_EQ(motions_of(here), MotionLibrary().folder()) << "in its build tree";
}

TEST(MotionFile, MessagesNameLineKeyAndExpectation) {
  const std::string good = file_text(MotionLibrary().folder() / "squat.toml");
  EXPECT_EQ(message_of(good), "no error");
  EXPECT_THAT(message_of(replaced(good, "base_x = 300.0", "base_xx = 300.0")),
              HasSubstr("missing key in 'cost.base_x'; expected a number from"));
  EXPECT_THAT(message_of(replaced(good, "[cost]", "[cost]\nbase_w = 1.0")),
              HasSubstr("unknown key in 'cost.base_w'"));
  EXPECT_THAT(message_of(replaced(good, "[cost]", "[cost]\nbase_w = 1.0")), HasSubstr("m.toml:"));
  EXPECT_THAT(message_of(replaced(good, "depth_share", "depth")),
              HasSubstr("found 'depth'; expected one of cost, completed"));
  EXPECT_THAT(message_of(replaced(good, "format = 1", "format = 2")), HasSubstr("reads format 1"));
  EXPECT_THAT(message_of(replaced(good, "cost_limit = 350.0", "cost_limit = -1.0")),
              HasSubstr("expected a number from"));
  EXPECT_THAT(message_of(replaced(good, "kind = \"in_place\"", "kind = \"dance\"")),
              HasSubstr("'dance' is none of"));
  EXPECT_THAT(message_of(replaced(good, "num_basis = ", "num_basis = 9")), HasSubstr("num_basis"));
  EXPECT_THAT(message_of(good.substr(0, good.size() / 2)), HasSubstr("m.toml:"));
  EXPECT_THAT(
      message_of(replaced(good, "[primitives.l_knee]\nstart = ", "[primitives.l_knee]\nstart = 9")),
      HasSubstr("outside what the robot can follow"));
}

TEST(MotionFile, KeepsAWeightOfTheRiseThatIsNotThatOfTheWay) {
  Motion motion = MotionLibrary().load("jog");
  EXPECT_EQ(to_toml(motion).find("base_rise"), std::string::npos) << "one number where one does";
  for (const double rise : {0.0, 1.0, 7.5}) {
    motion.weights.state[model::kDVel + 2] = rise;
    const Motion back = parse_motion(to_toml(motion), "again");
    EXPECT_EQ(back.weights.state, motion.weights.state) << rise;
  }
}

/// The mocap clips are external data: $SANSO_DATA/mocap, else ../shared/data/mocap beside the
/// repository.
std::filesystem::path mocap_folder() {
  const char* data = std::getenv("SANSO_DATA");
  return (data && *data ? std::filesystem::path(data) : std::filesystem::path("../shared/data")) /
         "mocap";
}

TEST(Import, MakesTheShippedFilesAgain) {
  if (!std::filesystem::exists(mocap_folder())) {
    GTEST_SKIP() << "SKIPPED: no clips in " << mocap_folder()
                 << "; set SANSO_DATA to the folder that holds mocap/";
  }
  for (const auto& name : of_clips()) {
    const ImportedMotion made =
        import_motion({mocap_folder() / catalogue_entry(name).recipe.clip, name, ""});
    const Motion shipped = MotionLibrary().load(name);
    const Trajectory a = made.motion.reference(), b = shipped.reference();
    ASSERT_EQ(a.x.size(), b.x.size()) << name;
    // sine and exponential differ in the last bit between processors and libraries: equal poses,
    // not equal bytes
    for (std::size_t k = 0; k < a.x.size(); ++k) {
      ASSERT_LT(model::minus(a.x[k], b.x[k]).head<model::kNv>().norm(), 1e-5)
          << name << " tick " << k;
    }
    Motion without_primitives = made.motion;
    without_primitives.primitives = shipped.primitives;
    EXPECT_EQ(to_toml(without_primitives), to_toml(shipped))
        << "catalogue and file differ: import it again";
  }
}

TEST(Import, RefusesWhatTheRobotCannotDoAndSaysWhatToChange) {
  if (!std::filesystem::exists(mocap_folder())) GTEST_SKIP() << "SKIPPED: no clips; set SANSO_DATA";
  try {
    // kz 1: the whole depth
    import_motion({mocap_folder() / "accad/Male1_A7_Crouch.bvh", "deep", "stand"});
    FAIL() << "a squat to the heels became a robot motion";
  } catch (const ClipError& error) {
    EXPECT_THAT(error.what(), HasSubstr("the robot cannot do it"));
    EXPECT_THAT(error.what(), HasSubstr("beyond its limit"));
  }
  EXPECT_THROW(import_motion({mocap_folder() / "accad/Male1_A7_Crouch.bvh", "deep", "nothing"}),
               MotionError);
}

TEST(Import, TakesFiguresOfTheRecipeByName) {
  if (!std::filesystem::exists(mocap_folder())) GTEST_SKIP() << "SKIPPED: no clips; set SANSO_DATA";
  const auto clip = mocap_folder() / "accad/Male1_A7_Crouch.bvh";
  const ImportedMotion shallow = import_motion({clip, "squat", "", {"kz=0.25", "kappa=0.93"}});
  const ImportedMotion shipped = import_motion({clip, "squat", ""});
  EXPECT_EQ(shallow.motion.recipe.kz, 0.25);
  const auto depth = [](const ImportedMotion& m) {
    double low = 1.0;
    for (const auto& x : m.motion.reference().x) low = std::min(low, x[2]);
    return m.motion.reference().x.front()[2] - low;
  };
  EXPECT_NEAR(depth(shallow), 0.5 * depth(shipped), 0.002);
  EXPECT_THROW(import_motion({clip, "squat", "", {"depth=0.5"}}), MotionError);  // no such figure
  EXPECT_THROW(import_motion({clip, "squat", "", {"kz=half"}}), MotionError);
  EXPECT_THROW(import_motion({clip, "squat", "", {"mirror"}}), MotionError);  // no value
}

TEST(Import, AnEvenRhythmGivesBothFeetTheSameSwings) {
  if (!std::filesystem::exists(mocap_folder())) GTEST_SKIP() << "SKIPPED: no clips; set SANSO_DATA";
  const ImportedMotion jog =
      import_motion({mocap_folder() / catalogue_entry("jog").recipe.clip, "jog", ""});
  int down[2] = {0, 0}, swings[2] = {0, 0};
  const auto& carries = jog.retargeted.target.carries;
  for (std::size_t k = 1; k < carries.size(); ++k) {
    for (const std::size_t side : {0U, 1U}) {
      down[side] += carries[k][side] ? 1 : 0;
      swings[side] += carries[k - 1][side] && !carries[k][side] ? 1 : 0;
    }
  }
  EXPECT_EQ(swings[0], swings[1]);
  // ticks; the closing step is a median swing, the others a mean one
  EXPECT_NEAR(down[0], down[1], 6);
}

}  // namespace
}  // namespace sanso::motion
