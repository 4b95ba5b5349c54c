// The robot of the report does what was recorded and what was simulated, joint by joint.
#include "tools/diagnose/run/shown_motion.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "tests/support/noisy_world.h"
#include "tests/support/small_comparison.h"

namespace sanso::diagnose {
namespace {

using namespace test;

constexpr const char* kServo = "actuator = \"dc_servo\"\np_gain = 4.0\narmature = 0.01\n";
constexpr double kLate_s = 0.03;

/// Two links that follow their goals late, which the nominal model does not know.
struct Late {
  ModelFolder nominal = two_links(kServo);
  std::vector<recording::Recording> recordings;
  std::vector<Source> sources;
  Library library;
  HeldoutProof proof;

  Late() {
    const ModelFolder world =
        hiding(nominal, {{"command_delay", {"a", "b"}, {{"delay", kLate_s}}, 0}});
    for (int i = 0; i < 2; ++i) {
      const Drive drive = make_test_drive(world, 6.0, 0.005, [&](int joint, double t) {
        return (0.5 + 0.2 * joint) * std::sin((1.5 + 0.5 * i) * t);
      });
      recordings.push_back(record(world, drive, {.file = "take_" + std::to_string(i) + ".csv"}));
    }
    const SmallComparison c(nominal, recordings, noise_of(nominal), {"command_delay"});
    library = c.library;
    sources = c.problem->sources;
    proof.part = make_split(sources).heldout;
    for (std::size_t j = 0; j < 2; ++j)
      proof.model.effects.push_back({c.of("command_delay", {j}), {kLate_s}});
  }
  Simulated simulated() const {
    return simulate_heldout(sources, noise_of(nominal), library, proof, Settings{});
  }
};

TEST(ShownMotion, TheRecordedFigureIsTheRecording_AndThePatchedOneFollowsIt) {
  const Late late;
  const std::vector<ShownMotion> motions = shown_motions(late.simulated());
  ASSERT_EQ(motions.size(), 1u) << "the held-out recording alone";
  const ShownMotion& m = motions.front();
  const recording::Recording& r =
      m.recording == "take_0.csv" ? late.recordings[0] : late.recordings[1];
  EXPECT_NEAR(m.dt, 0.02, 1e-9);
  constexpr std::size_t kColumns = 1 + 3 * 2;
  ASSERT_EQ(m.numbers.size() % kColumns, 0u);
  ASSERT_GT(m.numbers.size() / kColumns, 200u);
  double nominal = 0.0, patched = 0.0;
  for (std::size_t at = 0; at < m.numbers.size(); at += kColumns) {
    const double* row = &m.numbers[at];
    const auto k = static_cast<std::size_t>(std::lround(row[0] / 0.005));
    for (std::size_t j = 0; j < 2; ++j) {
      const double q = r.find(j == 0 ? "q:a" : "q:b")[k];
      ASSERT_EQ(row[1 + j], q) << "row " << at / kColumns;
      nominal += std::pow(row[3 + j] - q, 2), patched += std::pow(row[5 + j] - q, 2);
    }
  }
  EXPECT_LT(patched, 0.01 * nominal);
  EXPECT_GT(nominal, 0.0);
}

TEST(ShownMotion, RowsGoOnInTime) {
  const std::vector<ShownMotion> motions = shown_motions(Late().simulated());
  for (std::size_t at = 7; at < motions.front().numbers.size(); at += 7)
    ASSERT_GT(motions.front().numbers[at], motions.front().numbers[at - 7]);
}

TEST(ShownMotion, OfAFloatingBaseItIsTheRecordingAndWhatIsMissingRests) {
  WholeRecording r;
  r.file = "jump.csv";
  r.attitude = r.position = true;
  r.q = Eigen::MatrixXd::Zero(1, 5);
  for (int k = 0; k < 5; ++k) {
    r.t.push_back(0.01 * k);
    r.p.emplace_back(0.1 * k, 0.0, k == 2 ? NAN : 1.0);
    r.R.emplace_back(Eigen::AngleAxisd(0.1 * k, V3::UnitZ()).toRotationMatrix());
    r.q(0, k) = k == 4 ? NAN : k;
  }
  r.interval = 0.01;
  const WholeBody shapeless;  // nothing of it could touch: nothing is simulated
  const ShownMotions shown = shown_motions({r}, shapeless, shapeless);
  EXPECT_FALSE(shown.simulated);
  const ShownMotion& m = shown.motions.front();
  constexpr std::size_t kColumns = 9;
  ASSERT_EQ(m.numbers.size(), 3 * kColumns) << "every second row";
  const double* last = &m.numbers[2 * kColumns];
  EXPECT_DOUBLE_EQ(last[0], 0.04);
  EXPECT_DOUBLE_EQ(last[1], 0.4);
  EXPECT_DOUBLE_EQ(last[3], 1.0);
  EXPECT_NEAR(last[4], std::cos(0.2), 1e-12);
  EXPECT_NEAR(last[7], std::sin(0.2), 1e-12);
  EXPECT_DOUBLE_EQ(last[8], 2.0) << "not sampled: where it was";
  EXPECT_DOUBLE_EQ(m.numbers[kColumns + 3], 1.0);
}

}  // namespace
}  // namespace sanso::diagnose
