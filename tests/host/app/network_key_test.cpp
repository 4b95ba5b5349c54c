// Whoever gives a wrong key is told by which option it came.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "host/app/network_robot.h"
#include "tests/support/temp_folder.h"

namespace sanso::app {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string refusal(const std::filesystem::path& file) {
  try {
    (void)read_key(file);
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

TEST(ReadKey, NamesTheOptionAndTheFileThatIsMissingOrNoKey) {
  const test::TempFolder folder;
  const std::filesystem::path file = folder.path() / "robot.key";
  EXPECT_THAT(refusal(file), AllOf(HasSubstr("--key "), HasSubstr(file.string())));
  std::ofstream(file) << "0123\n";
  EXPECT_THAT(refusal(file), AllOf(HasSubstr("--key "), HasSubstr("64 hexadecimal digits")));
  std::ofstream(file) << std::string(64, 'a') << "\n";
  EXPECT_EQ(refusal(file), "");
}

}  // namespace
}  // namespace sanso::app
