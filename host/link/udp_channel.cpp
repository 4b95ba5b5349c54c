// A connected, non-blocking socket: send drops when the kernel's queue is full, as UDP may;
// waiting is ppoll.
#include "host/link/udp_channel.h"

#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <ctime>
#include <stdexcept>

namespace sanso::link {
namespace {

struct HostPort {
  std::string host, port;
};

/// Splits at the last colon, so that "[::1]:7000" works too.
HostPort split_address(const std::string& address) {
  const std::size_t colon = address.rfind(':');
  if (colon == std::string::npos || colon == 0 || colon + 1 == address.size())
    throw std::runtime_error("robot address \"" + address +
                             "\": expected HOST:PORT, for example 192.168.1.7:7000");
  std::string host = address.substr(0, colon);
  if (host.size() > 2 && host.front() == '[' && host.back() == ']')
    host = host.substr(1, host.size() - 2);
  return {host, address.substr(colon + 1)};
}

}  // namespace

UdpChannel::UdpChannel(const std::string& address) {
  const HostPort target = split_address(address);
  addrinfo hints{};
  hints.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  const int error = getaddrinfo(target.host.c_str(), target.port.c_str(), &hints, &found);
  if (error != 0)
    throw std::runtime_error("robot address \"" + address + "\": " + gai_strerror(error));
  for (const addrinfo* a = found; a && socket_ < 0; a = a->ai_next) {
    socket_ = ::socket(a->ai_family, a->ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC, a->ai_protocol);
    if (socket_ >= 0 && ::connect(socket_, a->ai_addr, a->ai_addrlen) != 0) {
      ::close(socket_);
      socket_ = -1;
    }
  }
  freeaddrinfo(found);
  if (socket_ < 0)
    throw std::runtime_error("robot address \"" + address + "\": " + std::strerror(errno));
}

UdpChannel::~UdpChannel() { ::close(socket_); }

bool UdpChannel::send(const std::uint8_t* data, std::size_t size) {
  return ::send(socket_, data, size, 0) == static_cast<ssize_t>(size);
}

std::size_t UdpChannel::receive(std::uint8_t* buffer, std::size_t capacity) {
  // A refused connection (the controller is not up yet) is reported here once per send: the same as
  // "nothing arrived".
  const ssize_t n = ::recv(socket_, buffer, capacity, 0);
  return n > 0 ? static_cast<std::size_t>(n) : 0;
}

Nanoseconds MonotonicClock::now() {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return static_cast<Nanoseconds>(t.tv_sec) * kSecond + t.tv_nsec;
}

void MonotonicClock::wait_until(Nanoseconds time) {
  const Nanoseconds left = time - now();
  if (left <= 0) return;
  timespec timeout{static_cast<time_t>(left / kSecond), static_cast<long>(left % kSecond)};
  pollfd descriptor{descriptor_, POLLIN, 0};
  ppoll(&descriptor, 1, &timeout, nullptr);
}

}  // namespace sanso::link
