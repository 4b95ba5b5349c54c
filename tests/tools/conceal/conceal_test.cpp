// Cases: deterministic, sealed, loud as asked, and readable as recordings.
#include "tools/conceal/conceal.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "tools/conceal/built.h"
#include "tools/conceal/seal.h"
#include "tools/conceal/severity.h"
#include "tools/diagnose/effects/effect.h"
#include "tools/plant/world_error.h"
#include "tools/recording/csv_reader.h"

namespace sanso::conceal {
namespace {

namespace fs = std::filesystem;

struct Folder {
  explicit Folder(const std::string& name)
      : path((fs::temp_directory_path() / (name + std::to_string(getpid()))).string()) {
    fs::remove_all(path);
  }
  ~Folder() { fs::remove_all(path); }
  std::string path;
};

std::string read(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

ConcealOptions options(const std::string& out, std::uint64_t seed, Family family, double ratio) {
  ConcealOptions o;
  o.seed = seed;
  o.out = out;
  o.family = family;
  o.ratio = ratio;
  return o;
}

TEST(Conceal, SameSeedSameBytesAndSameHash) {
  const Folder a("conceal_a"), b("conceal_b");
  const Concealed first = conceal(options(a.path, 5, Family::clean, 1));
  const Concealed second = conceal(options(b.path, 5, Family::clean, 1));
  EXPECT_EQ(first.hash, second.hash);
  ASSERT_EQ(first.recordings.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_EQ(read(first.recordings[i]), read(second.recordings[i]));
  // never overwrites a case
  EXPECT_THROW(conceal(options(a.path, 6, Family::clean, 1)), plant::WorldError);
}

TEST(Conceal, NothingInTheClearTellsTheAnswer) {
  const Folder f("conceal_clear");
  ConcealOptions o = options(f.path, 424242, Family::single, 3);
  o.effect = "backlash";
  conceal(o);
  for (const auto& entry : fs::recursive_directory_iterator(f.path)) {
    if (!entry.is_regular_file()) continue;
    const std::string text = read(entry.path());
    EXPECT_EQ(text.find("backlash"), std::string::npos) << entry.path();
    EXPECT_EQ(text.find("424242"), std::string::npos) << entry.path();
    EXPECT_EQ(text.find("single"), std::string::npos) << entry.path();
  }
}

TEST(Conceal, RecordingsReadBackWithTheirConditions) {
  const Folder f("conceal_read");
  const Concealed made = conceal(options(f.path, 7, Family::clean, 1));
  const auto usual = recording::read_csv(made.recordings[0]);
  EXPECT_EQ(usual.condition, "usual");
  EXPECT_EQ(usual.rows(), 2000u);
  for (const char* column : {"u:pivot", "q:pivot", "dq:pivot", "i:pivot", "pwm:pivot", "volt"}) {
    EXPECT_TRUE(usual.has(column)) << column;
  }
  EXPECT_EQ(recording::read_csv(made.recordings[2]).overrides.size(), 1u);
  EXPECT_EQ(recording::read_csv(made.recordings[4]).payloads.size(), 1u);
}

nlohmann::json answer_of(const std::string& folder) {
  const std::string text = read(fs::path(folder) / "answer.sealed");
  const std::vector<std::uint8_t> sealed(text.begin(), text.end());
  return nlohmann::json::parse(open_seal(sealed));
}

TEST(Conceal, EveryFigureOfACleanCaseIsALittleOff) {
  const Folder f("conceal_clean");
  conceal(options(f.path, 11, Family::clean, 1));
  const nlohmann::json answer = answer_of(f.path);
  EXPECT_EQ(answer.at("format"), 2);
  EXPECT_TRUE(answer.at("effects").empty());
  const std::map<std::string, double> largest{
      {"mass", 0.03},    {"length", 0.02},          {"viscous", 0.05},  {"coulomb", 0.05},
      {"p_gain", 0.02},  {"torque_constant", 0.02}, {"back_emf", 0.02}, {"resistance", 0.02},
      {"armature", 0.1}, {"zero", 0.0015},          {"lag", 0.0005}};
  const nlohmann::json& off = answer.at("tolerances");
  EXPECT_EQ(off.size(), largest.size());
  for (const auto& [name, bound] : largest) {
    const double value = off.at(name).at(0);
    EXPECT_NE(value, 0.0) << name;
    EXPECT_LE(std::abs(value), bound * (1 + 1e-9)) << name;
  }
}

TEST(Built, NineCasesInTenHaveDryFrictionThatTheModelStates) {
  int rough = 0;
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    Random random(seed);
    const double coulomb = nominal_joint(random).coulomb;
    EXPECT_TRUE(coulomb == 0.001 || (coulomb >= 0.04 && coulomb <= 0.16)) << coulomb;
    rough += coulomb > 0.01;
  }
  EXPECT_NEAR(rough, 900, 40);  // four deviations
  const Folder f("conceal_stated");
  conceal(options(f.path, 12, Family::clean, 1));
  const std::string model = read(fs::path(f.path) / "model" / "model.toml");
  EXPECT_EQ(model.find("coulomb = 0.05\n"), std::string::npos) << "drawn, not the default";
}

TEST(Built, EveryFormulaIsDrawnAndSaid) {
  std::map<std::string, std::set<std::string>> seen;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    Random random(seed);
    const nlohmann::json drawn = to_json(draw_formulas(random));
    for (const auto& [what, which] : drawn.items()) seen[what].insert(which.get<std::string>());
  }
  const std::map<std::string, std::set<std::string>> all{
      {"friction", {"lugre", "dahl", "arctangent"}},
      {"fall", {"gaussian", "lorentzian"}},
      {"teeth", {"linear", "hertzian"}},
      {"mailbox", {"at once", "polled"}}};
  EXPECT_EQ(seen, all);
}

TEST(Seal, OpensOnlyWhatWasSealed) {
  auto sealed = make_seal("{\"truth\": 1}");
  EXPECT_EQ(open_seal(sealed), "{\"truth\": 1}");
  const std::string hash = seal_hash(sealed);
  sealed.back() ^= 1;
  EXPECT_THROW(open_seal(sealed), plant::WorldError);
  EXPECT_NE(seal_hash(sealed), hash);
  EXPECT_THROW(open_seal(std::vector<std::uint8_t>(10, 0)), plant::WorldError);
}

TEST(Severity, HitsItsTargetAndGrowsWithTheEffect) {
  Random random(3);
  const RobotSpec robot = make_robot("pendulum");
  WorldTruth world;
  world.robot = as_built(robot, random);
  world.joints.resize(1);
  const auto experiments = make_experiments(robot, random);
  const SeverityMeter meter(world, {experiments[0]}, 1);
  EXPECT_NEAR(meter.ratio(world), 0, 1e-9);
  for (const char* id : {"coulomb_friction", "backlash", "command_delay", "rotor_inertia"}) {
    double reached = 0;
    const double small = size_for_ratio(hideable(id), 0, world, meter, 1, Random(1), reached);
    EXPECT_NEAR(std::log(reached), 0, 0.4) << id;  // a delay comes in steps of the servo's loop
    const double large = size_for_ratio(hideable(id), 0, world, meter, 4, Random(1), reached);
    EXPECT_GT(large, small) << id;
  }
}

TEST(Severity, NuisancesAloneAreQuiet) {
  Random random(4);
  const RobotSpec robot = make_robot("pendulum");
  WorldTruth world;
  world.robot = robot;
  world.joints.resize(1);
  const auto experiments = make_experiments(robot, random);
  const SeverityMeter meter(world, {experiments[0]}, 1);
  WorldTruth heavier = world;
  heavier.robot.links[0].mass *= 1.03;
  for (double& i : heavier.robot.links[0].inertia) i *= 1.03;
  EXPECT_LT(meter.ratio(heavier), 0.3);
  // a zero of the servo's is one of them, one of the record alone is not
  WorldTruth zero = world, record = world;
  zero.joints[0].offset = record.joints[0].record_offset = 0.002;
  EXPECT_LT(meter.ratio(zero), 1.5);
  EXPECT_NEAR(meter.ratio(record), 0.002 / (world.joints[0].quantum / std::sqrt(12.0)), 1e-6);
}

TEST(Hideables, AreCalledAsTheLibraryCallsThem) {
  for (const Hideable& h : hideables()) {
    EXPECT_EQ(diagnose::find_effect(h.id) != nullptr, h.in_library) << h.id;
    for (const std::string& twin : h.twins)
      EXPECT_NE(diagnose::find_effect(twin), nullptr) << h.id << " and " << twin;
  }
}

TEST(Hideables, EveryEffectCompilesAndChangesSomething) {
  const RobotSpec robot = make_robot("arm");
  Random random(9);
  WorldTruth world;
  world.robot = robot;
  world.joints.resize(2);
  auto experiment = make_experiments(robot, random)[0];
  experiment.command.resize(600);
  const Signals before = run_experiment(world, experiment, 1);
  for (const Hideable& h : hideables()) {
    SCOPED_TRACE(h.id);
    double change = 0;
    // joint 0 carries the load; a stop or a push may lie outside the first seconds, so the size is
    // taken large
    WorldTruth changed = world;
    Random same(2);
    const HiddenEffect effect = h.apply(changed, 0, h.id == "sample_hold" ? 3 : h.largest, same);
    EXPECT_EQ(effect.id, h.id);
    const bool late = h.id == "payload" || h.id == "external_push";
    if (late) {
      changed.payload.from_s = std::min(changed.payload.from_s, 2.0);
      changed.push.from_s = std::min(changed.push.from_s, 2.0);
    }
    const Signals after = run_experiment(changed, experiment, 1);
    for (int j = 0; j < 2; ++j) {
      for (std::size_t row = 0; row < 600; ++row) {
        ASSERT_TRUE(std::isfinite(after.q[j][row])) << row;
        change = std::max({change, std::abs(after.q[j][row] - before.q[j][row]),
                           0.05 * std::abs(after.dq[j][row] - before.dq[j][row])});
      }
    }
    EXPECT_GT(change, 5e-4);
  }
}

/// What a hidden effect adds to the dry friction is told: its own, or what it brings along.
TEST(Hideables, NoFrictionIsAddedThatTheAnswerDoesNotTell) {
  WorldTruth world;
  world.robot = make_robot("arm");
  world.joints.resize(2);
  int brought = 0;
  for (const Hideable& h : hideables()) {
    SCOPED_TRACE(h.id);
    WorldTruth changed = world;
    Random random(2);
    const HiddenEffect effect = h.apply(changed, 0, h.largest, random);
    const auto own = effect.parameters.find("coulomb");
    const double told =
        (own != effect.parameters.end() ? own->second : 0.0) + effect.coulomb_beside;
    EXPECT_NEAR(changed.joints[0].coulomb - world.joints[0].coulomb, told, 1e-12);
    brought += effect.coulomb_beside > 0.0;
  }
  EXPECT_EQ(brought, 2);  // a ripple of friction and one that differs by direction
}

TEST(MakeRobot, RefusesUnknownNames) { EXPECT_THROW(make_robot("spider"), plant::WorldError); }

}  // namespace
}  // namespace sanso::conceal
