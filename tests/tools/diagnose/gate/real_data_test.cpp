// The gate must not refuse healthy recordings of real machines: uneven sampling, empty cells,
// glitches, torque off.
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/support/shared_data.h"
#include "tools/diagnose/gate/gate.h"
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
    ++files;
  }
  EXPECT_GE(files, 22);
}

}  // namespace
}  // namespace sanso::diagnose
