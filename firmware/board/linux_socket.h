// Sockets: UDP for the hosts, and Unix SOCK_SEQPACKET connections that stand in for devices.
//
// An emulated HID sensor listens on a path. After the connection its first packet is the report
// descriptor; every later packet is one input report; packets towards it are feature reports. A
// pose source sends one pose report a packet (shared/base/pose_report.h). The same bytes as from
// the devices.
#pragma once

#include <array>
#include <string>

#include "firmware/board/reconnect.h"

namespace sanso::board {

/// A bound UDP socket.
class UdpSocket : public Datagram {
 public:
  UdpSocket() = default;
  ~UdpSocket() override;
  UdpSocket(const UdpSocket&) = delete;
  UdpSocket& operator=(const UdpSocket&) = delete;

  /// Binds to `address` ("0.0.0.0", "127.0.0.1", "::") and port; port 0: any (then port() tells).
  Status open(const std::string& address, int port, std::string& message);
  int port() const;
  Status send(Bytes data, const Peer& to) override;
  Result<std::size_t> receive(Buffer buffer, Peer& from, Nanoseconds deadline) override;
  std::uint32_t empty_ones() const override { return empty_ones_; }

 private:
  int socket_ = -1;
  std::uint32_t empty_ones_ = 0;
};

/// A packet connection to a path.
class PacketConnection {
 public:
  explicit PacketConnection(std::string path) : path_(std::move(path)) {}
  ~PacketConnection();
  PacketConnection(const PacketConnection&) = delete;
  PacketConnection& operator=(const PacketConnection&) = delete;

  Status connect(std::string& message);
  bool connected() const { return socket_ >= 0; }
  Status send(Bytes data);
  Result<std::size_t> receive(Buffer buffer, Nanoseconds deadline);
  const std::string& path() const { return path_; }

 private:
  void close();
  std::string path_;
  int socket_ = -1;
};

/// A HID sensor behind a packet connection.
class SocketHid : public OpenableHid {
 public:
  explicit SocketHid(std::string path) : connection_(std::move(path)) {}
  /// Connects and reads the report descriptor (waits up to a second for it).
  Status open(std::string& message) override;
  Bytes descriptor() override { return {descriptor_bytes_.data(), descriptor_size_}; }
  Status set_feature(Bytes report) override { return connection_.send(report); }
  Result<std::size_t> read(Buffer buffer, Nanoseconds deadline) override {
    return connection_.receive(buffer, deadline);
  }

 private:
  PacketConnection connection_;
  std::array<std::uint8_t, 4096> descriptor_bytes_{};
  std::size_t descriptor_size_ = 0;
};

/// A pose source behind a packet connection.
class SocketPose : public OpenablePose {
 public:
  explicit SocketPose(std::string path) : connection_(std::move(path)) {}
  Status open(std::string& message) override { return connection_.connect(message); }
  Result<std::size_t> read(Buffer buffer, Nanoseconds deadline) override {
    return connection_.receive(buffer, deadline);
  }

 private:
  PacketConnection connection_;
};

}  // namespace sanso::board
