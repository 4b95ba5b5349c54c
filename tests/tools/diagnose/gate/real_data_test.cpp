// The gate must not refuse healthy recordings of real machines: uneven sampling, empty cells,
// glitches, torque off.
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/support/shared_data.h"
#include "tools/diagnose/gate/gate.h"
#include "tools/diagnose/gate/jumps.h"
#include "tools/diagnose/gate/load.h"
#include "tools/recording/csv_reader.h"

namespace sanso::diagnose {
namespace {

TEST(GateRealData, PassesEveryFixedBaseSet) {
  const std::filesystem::path folder = test::shared_data() / "real";
  if (!std::filesystem::exists(folder))
    GTEST_SKIP() << "SKIPPED: no recordings at " << folder << "; set SANSO_DATA";
  int files = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    const std::string path = entry.path().string();
    // no clock, no joints
    if (path.find("/maps/") != std::string::npos || path.find("contactnets") != std::string::npos)
      continue;
    if (!path.ends_with(".csv") && !path.ends_with(".csv.gz")) continue;
    const recording::Recording r = recording::read_csv(path);
    GateRecording view{r.file, r.condition, r.t, {}};
    for (const recording::Channel& c : r.channels) view.channels.push_back({c.name, c.values});
    std::vector<GateJoint> joints;
    for (const std::string& name : r.joints())
      joints.push_back({name, path.find("emps") != std::string::npos});
    const GateReport report = inspect({view}, joints);
    for (const Defect& d : report.defects) {
      ADD_FAILURE() << path << " " << d.channel << " row " << d.row << ": " << d.defect << ", "
                    << d.message;
    }
    EXPECT_TRUE(position_jumps(view, joints, {}).empty()) << path << " would be cut";
    ++files;
  }
  EXPECT_GE(files, 22);
}

/// A robot that swings from bar to bar: five swings a file, the angle of the shoulder is another
/// one where the hand changes.
TEST(GateRealData, ChangesOfTheBarAreCut) {
  const std::filesystem::path file = test::shared_data() / "legged/acromonk/BF_pd_5x.csv.gz";
  if (!std::filesystem::exists(file))
    GTEST_SKIP() << "SKIPPED: no recording at " << file << "; set SANSO_DATA";
  const recording::Recording r = recording::read_csv(file.string());
  const auto rows = position_jumps(gate_view(r), {{"shoulder_passive"}, {"elbow"}}, {});
  ASSERT_EQ(rows.size(), 4U);
  const double seconds[] = {2.29, 4.52, 6.76, 9.02};
  for (std::size_t k = 0; k < rows.size(); ++k) EXPECT_NEAR(r.t[rows[k]], seconds[k], 0.01);
}

}  // namespace
}  // namespace sanso::diagnose
