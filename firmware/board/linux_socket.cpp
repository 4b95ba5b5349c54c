// System calls of UDP and packet sockets, behind the interfaces of board.h. Every receive has a
// deadline; none allocates.
#include "firmware/board/linux_socket.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netdb.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "firmware/board/linux_clock.h"

namespace sanso::board {
namespace {

constexpr int kMostEmptyDatagrams = 64;  // at once
static_assert(sizeof(sockaddr_in6) <= sizeof(Peer::bytes), "a peer holds an IPv6 address");
}  // namespace

// --- UDP -----------------------------------------------------------------------------------------

UdpSocket::~UdpSocket() {
  if (socket_ >= 0) ::close(socket_);
}

Status UdpSocket::open(const std::string& address, int port, std::string& message) {
  addrinfo hints{}, *found = nullptr;
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_DGRAM;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICHOST;
  const std::string service = std::to_string(port);
  if (getaddrinfo(address.c_str(), service.c_str(), &hints, &found) != 0) {
    message = "'" + address + "' is no numeric IP address";
    return Status::io_error;
  }
  socket_ = ::socket(found->ai_family, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  const bool bound = socket_ >= 0 && ::bind(socket_, found->ai_addr, found->ai_addrlen) == 0;
  if (!bound) message = address + " port " + service + ": " + std::strerror(errno);
  freeaddrinfo(found);
  return bound ? Status::ok : Status::io_error;
}

int UdpSocket::port() const {
  sockaddr_in6 own{};
  socklen_t size = sizeof own;
  if (getsockname(socket_, reinterpret_cast<sockaddr*>(&own), &size) != 0) return 0;
  return ntohs(own.sin6_port);  // the port lies at the same place for IPv4
}

Status UdpSocket::send(Bytes data, const Peer& to) {
  const ssize_t n = ::sendto(socket_, data.data(), data.size(), MSG_DONTWAIT,
                             reinterpret_cast<const sockaddr*>(to.bytes), to.size);
  return n == static_cast<ssize_t>(data.size()) ? Status::ok : Status::io_error;
}

Result<std::size_t> UdpSocket::receive(Buffer buffer, Peer& from, Nanoseconds deadline) {
  // whoever sends nothing, and that without end, must not keep the caller here
  for (int empty = 0; empty < kMostEmptyDatagrams;) {
    socklen_t size = sizeof from.bytes;
    const ssize_t n = ::recvfrom(socket_, buffer.data(), buffer.size(), MSG_DONTWAIT,
                                 reinterpret_cast<sockaddr*>(from.bytes), &size);
    if (n >= 0) {
      from.size = static_cast<std::uint8_t>(size);
      if (n > 0) return static_cast<std::size_t>(n);
      ++empty;
      ++empty_ones_;
      continue;
    }
    if (errno != EAGAIN && errno != EINTR && errno != ECONNREFUSED) return Status::io_error;
    const int ready = wait_readable(socket_, deadline);
    if (ready == 0) return std::size_t{0};
  }
  return std::size_t{0};
}

// --- packets on a path ---------------------------------------------------------------------------

PacketConnection::~PacketConnection() { close(); }

void PacketConnection::close() {
  if (socket_ >= 0) ::close(socket_);
  socket_ = -1;
}

Status PacketConnection::connect(std::string& message) {
  close();
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path_.size() >= sizeof address.sun_path) {
    message = path_ + ": path too long for a socket";
    return Status::io_error;
  }
  std::copy(path_.begin(), path_.end(), address.sun_path);
  socket_ = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
  if (socket_ < 0 ||
      ::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    message = path_ + ": " + std::strerror(errno) + "; is the emulator running?";
    close();
    return Status::io_error;
  }
  return Status::ok;
}

Status PacketConnection::send(Bytes data) {
  if (socket_ < 0) return Status::io_error;
  return ::send(socket_, data.data(), data.size(), MSG_NOSIGNAL) ==
                 static_cast<ssize_t>(data.size())
             ? Status::ok
             : Status::io_error;
}

Result<std::size_t> PacketConnection::receive(Buffer buffer, Nanoseconds deadline) {
  if (socket_ < 0) return Status::io_error;
  for (;;) {
    const ssize_t n = ::recv(socket_, buffer.data(), buffer.size(), MSG_DONTWAIT);
    if (n > 0) return static_cast<std::size_t>(n);
    if (n == 0) return Status::io_error;  // the other side has closed
    if (errno == EINTR) continue;
    if (errno != EAGAIN) return Status::io_error;
    const int ready = wait_readable(socket_, deadline);
    if (ready < 0) return Status::io_error;
    if (ready == 0) return std::size_t{0};
  }
}

Status SocketHid::open(std::string& message) {
  if (const Status status = connection_.connect(message); status != Status::ok) return status;
  LinuxClock clock;
  const Result<std::size_t> n = connection_.receive(descriptor_bytes_, clock.now() + kSecond);
  if (!n.ok() || *n == 0) {
    message = connection_.path() + ": no report descriptor within a second";
    return Status::io_error;
  }
  descriptor_size_ = *n;
  return Status::ok;
}

}  // namespace sanso::board
