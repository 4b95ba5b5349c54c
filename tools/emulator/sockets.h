// File descriptors of the emulator process: the pty that is the servo bus, and the packet sockets
// beside it.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "tools/emulator/bus_end.h"

namespace sanso::emulator {

class FileDescriptor {
 public:
  explicit FileDescriptor(int fd = -1) : fd_(fd) {}
  ~FileDescriptor() { reset(); }
  FileDescriptor(FileDescriptor&& other) noexcept : fd_(other.fd_) { other.fd_ = -1; }
  FileDescriptor& operator=(FileDescriptor&& other) noexcept;
  int get() const { return fd_; }
  bool open() const { return fd_ >= 0; }
  void reset();

 private:
  int fd_;
};

/// A pty in raw mode whose far end is reachable under `link`.
class BusPty final : public BusEnd {
 public:
  explicit BusPty(std::string link) : link_(std::move(link)) {}
  ~BusPty() override { take_away(); }
  BusPty(const BusPty&) = delete;
  BusPty& operator=(const BusPty&) = delete;
  void plug() override;
  /// Whoever has the far end open reads end of file and fails to write.
  void unplug() override { take_away(); }
  int fd() const override { return master_.get(); }
  std::string device() const override { return device_; }
  std::size_t read(std::span<std::uint8_t> out) override;
  void write(std::span<const std::uint8_t> bytes) override;
  int baud() const override;
  Nanoseconds serve(Nanoseconds) override { return INT64_MAX; }

 private:
  void take_away();
  std::string link_;
  std::string device_;
  FileDescriptor master_;
  // kept open, so that a client that closes and opens again does not hang the line up
  FileDescriptor far_end_;
};

/// A local packet socket (one message = one report) with any number of clients. Never blocks; a
/// client that does not read loses messages.
class PacketServer {
 public:
  explicit PacketServer(const std::string& path);  // throws plant::WorldError
  ~PacketServer();
  /// Takes new clients in; returns those descriptors that are new.
  std::vector<int> accept_new();
  /// One waiting message of any client; `client` says whose. 0: none.
  std::size_t receive(std::span<std::uint8_t> out, int& client);
  void send(int client, std::span<const std::uint8_t> message);
  void send_all(std::span<const std::uint8_t> message);
  void add_descriptors(std::vector<int>& out) const;

 private:
  std::string path_;
  FileDescriptor listener_;
  std::vector<FileDescriptor> clients_;
};

/// Connects to a PacketServer; throws plant::WorldError when nobody listens there.
FileDescriptor connect_packets(const std::string& path);

}  // namespace sanso::emulator
