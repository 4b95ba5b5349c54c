// The controller's UDP socket between two ends of this machine.
#include "firmware/board/linux_socket.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <string>

namespace sanso::board {
namespace {

class Sender {
 public:
  explicit Sender(int port) {
    to_.sin_family = AF_INET;
    to_.sin_port = htons(static_cast<std::uint16_t>(port));
    to_.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  }
  ~Sender() { ::close(socket_); }
  Sender(const Sender&) = delete;
  Sender& operator=(const Sender&) = delete;
  void send(const std::string& bytes) {
    ASSERT_GE(::sendto(socket_, bytes.data(), bytes.size(), 0,
                       reinterpret_cast<const sockaddr*>(&to_), sizeof to_),
              0);
  }

 private:
  int socket_ = ::socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in to_{};
};

/// Somebody who sends nothing without end keeps the link from its other work no longer than one
/// handful, and costs no datagram of anybody else.
TEST(UdpSocket, EmptyDatagramsAreNothingAndHoldNobodyUp) {
  UdpSocket socket;
  std::string message;
  ASSERT_EQ(socket.open("127.0.0.1", 0, message), Status::ok) << message;
  Sender sender(socket.port());
  constexpr int kEmpty = 200;
  for (int i = 0; i < kEmpty; ++i) sender.send("");
  sender.send("real");
  std::array<std::uint8_t, 64> buffer{};
  Peer from;
  int returned_without = 0;
  std::size_t got = 0;
  for (; returned_without < kEmpty && got == 0; returned_without += got == 0 ? 1 : 0) {
    const Result<std::size_t> n = socket.receive(buffer, from, 0);
    ASSERT_TRUE(n.ok());
    got = *n;
  }
  EXPECT_EQ(got, 4u);
  EXPECT_GT(returned_without, 0) << "it comes back in between";
  EXPECT_LT(returned_without, kEmpty / 10) << "but not for each of them";
  EXPECT_EQ(socket.empty_ones(), kEmpty) << "each is counted";
}

}  // namespace
}  // namespace sanso::board
