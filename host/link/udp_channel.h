// Datagrams over UDP and the real clock that waits on the socket.
#pragma once

#include <string>

#include "host/link/channel.h"

namespace sanso::link {

/// A connected, non-blocking UDP socket. Throws std::runtime_error when the address cannot be used.
class UdpChannel : public DatagramChannel {
 public:
  /// `address` is "host:port", for example "192.168.1.7:7000" or "[::1]:7000".
  explicit UdpChannel(const std::string& address);
  ~UdpChannel() override;
  UdpChannel(const UdpChannel&) = delete;
  UdpChannel& operator=(const UdpChannel&) = delete;

  bool send(const std::uint8_t* data, std::size_t size) override;
  std::size_t receive(std::uint8_t* buffer, std::size_t capacity) override;
  int descriptor() const { return socket_; }

 private:
  int socket_ = -1;
};

/// CLOCK_MONOTONIC; wakes early when `channel` becomes readable.
class MonotonicClock : public HostClock {
 public:
  explicit MonotonicClock(const UdpChannel& channel) : descriptor_(channel.descriptor()) {}
  Nanoseconds now() override;
  void wait_until(Nanoseconds time) override;
  void finish_computation(Nanoseconds, Nanoseconds) override {}

 private:
  int descriptor_;
};

}  // namespace sanso::link
