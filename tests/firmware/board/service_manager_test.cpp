// What systemd would hear, on a socket of the test.
#include "firmware/board/service_manager.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <vector>

#include "tests/support/temp_folder.h"

namespace sanso::board {
namespace {

class Systemd : public testing::Test {
 protected:
  void TearDown() override {
    ::unsetenv("NOTIFY_SOCKET");
    ::unsetenv("WATCHDOG_USEC");
    if (socket_ >= 0) ::close(socket_);
  }
  /// Listens on `name`, as systemd writes it into the environment.
  void listen(const std::string& name) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::copy(name.begin(), name.end(), address.sun_path);
    if (name[0] == '@') address.sun_path[0] = '\0';
    socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    ASSERT_EQ(::bind(socket_, reinterpret_cast<sockaddr*>(&address),
                     static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + name.size())),
              0);
    ::setenv("NOTIFY_SOCKET", name.c_str(), 1);
  }
  std::vector<std::string> heard() const {
    std::vector<std::string> lines;
    std::array<char, 256> line;
    for (ssize_t n; (n = ::recv(socket_, line.data(), line.size(), 0)) > 0;)
      lines.emplace_back(line.data(), static_cast<std::size_t>(n));
    return lines;
  }
  int socket_ = -1;
};

using Lines = std::vector<std::string>;

TEST_F(Systemd, HearsReadyOnceAndTheWatchdogOnlyWhileTicksGoBy) {
  const test::TempFolder folder;
  listen((folder.path() / "notify").string());
  ::setenv("WATCHDOG_USEC", "2000000", 1);
  const ServiceManager manager;
  EXPECT_EQ(manager.watchdog_period(), 2 * kSecond);
  TickWatch watch(manager);
  watch.look(0);
  EXPECT_EQ(heard(), Lines{}) << "no tick yet";
  watch.look(3);
  EXPECT_EQ(heard(), (Lines{"READY=1", "WATCHDOG=1"}));
  watch.look(3);
  EXPECT_EQ(heard(), Lines{}) << "the tick hangs";
  watch.look(4);
  EXPECT_EQ(heard(), Lines{"WATCHDOG=1"});
  manager.status("hold");
  manager.stopping();
  EXPECT_EQ(heard(), (Lines{"STATUS=hold", "STOPPING=1"}));
}

TEST_F(Systemd, MayListenOnAnAbstractSocket) {
  listen("@sanso-test-" + std::to_string(::getpid()));
  const ServiceManager manager;
  EXPECT_TRUE(manager.present());
  EXPECT_EQ(manager.watchdog_period(), 0);
  manager.ready();
  EXPECT_EQ(heard(), Lines{"READY=1"});
}

TEST_F(Systemd, MayBeAbsentOrGone) {
  EXPECT_FALSE(ServiceManager().present());
  ::setenv("NOTIFY_SOCKET", "/nonexistent/notify", 1);
  const ServiceManager manager;
  EXPECT_FALSE(manager.present());
  TickWatch(manager).look(1);
}

}  // namespace
}  // namespace sanso::board
