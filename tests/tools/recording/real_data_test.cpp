// The real recordings that come with the hand-out must be readable as they are.
#include <gtest/gtest.h>

#include "shared/files/input_error.h"
#include "tests/support/shared_data.h"
#include "tools/recording/csv_reader.h"

namespace sanso::recording {
namespace {

TEST(RealRecordings, AreAllReadable) {
  const auto folder = test::shared_data() / "real";
  if (!std::filesystem::exists(folder))
    GTEST_SKIP() << "no real recordings at " << folder << " (set SANSO_DATA)";
  int count = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    const std::string path = entry.path().string();
    if (!path.ends_with(".csv") && !path.ends_with(".csv.gz")) continue;
    if (path.find("/maps/") != std::string::npos) {  // tables without time, said so in their README
      EXPECT_THROW(read_csv(path), files::InputError) << path;
      continue;
    }
    const Recording r = read_csv(path);
    EXPECT_GT(r.rows(), 50u) << path;
    EXPECT_TRUE(r.ignored.empty()) << path;
    EXPECT_NO_THROW(require_increasing_time(r)) << path;
    ++count;
  }
  EXPECT_GT(count, 0);
}

}  // namespace
}  // namespace sanso::recording
