// The sentence that a person reads when a file is wrong: only what is known appears in it.
#include "shared/files/input_error.h"

#include <gtest/gtest.h>

namespace sanso::files {
namespace {

TEST(InputError, NamesFileLineChannelValueAndWhatWasExpected) {
  const InputError error("run.csv", 7, "q:knee", "not a number", "12,5", "a point, 12.5");
  EXPECT_STREQ(error.what(),
               "run.csv:7: not a number in 'q:knee': found '12,5'; expected a point, 12.5");
  EXPECT_EQ(error.line, 7);
  EXPECT_EQ(error.defect, "not a number");
}

TEST(InputError, LeavesOutWhatIsNotKnown) {
  EXPECT_STREQ(InputError("run.csv", 0, "", "empty file", "", "").what(), "run.csv: empty file");
}

}  // namespace
}  // namespace sanso::files
