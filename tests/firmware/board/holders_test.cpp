// The other program that has the bus open is named by number and name.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>

#include "firmware/board/holders.h"
#include "tests/firmware/board/pty.h"
#include "tests/support/temp_folder.h"

namespace sanso::board {
namespace {

TEST(Holders, AnotherProgramOnTheBusIsNamed) {
  const test::TempFolder folder;
  const std::string link = (folder.path() / "bus").string();
  testing::Pty pty(link);
  pty.plug();
  EXPECT_EQ(holders_of(link), "") << "this program does not count";
  const std::string device = std::filesystem::canonical(link).string();
  int open_now[2] = {-1, -1};
  ASSERT_EQ(pipe(open_now), 0);
  const pid_t other = fork();
  if (other == 0) {  // the master's end is shared with the child; what counts is the device
    prctl(PR_SET_NAME, "op3_manager");
    const bool good = ::open(device.c_str(), O_RDWR | O_NOCTTY) >= 0;
    (void)!::write(open_now[1], good ? "y" : "n", 1);
    for (;;) pause();
  }
  char answer = 0;
  ASSERT_EQ(::read(open_now[0], &answer, 1), 1);
  ASSERT_EQ(answer, 'y');
  EXPECT_EQ(holders_of(link), std::to_string(other) + " (op3_manager)");
  kill(other, SIGKILL);
  waitpid(other, nullptr, 0);
  EXPECT_EQ(holders_of(link), "");
  EXPECT_EQ(holders_of((folder.path() / "nothing").string()), "");
  ::close(open_now[0]);
  ::close(open_now[1]);
}

}  // namespace
}  // namespace sanso::board
