// Owners of file descriptors, each closed exactly once.
#include "tools/emulator/sockets.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "tools/emulator/line_speed.h"
#include "tools/plant/world_error.h"

namespace sanso::emulator {
namespace {

[[noreturn]] void fail(const std::string& what) {
  throw plant::WorldError(fmt::format("{}: {}", what, std::strerror(errno)));
}

sockaddr_un address_of(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) {
    throw plant::WorldError(fmt::format("{}: a socket path has at most {} characters", path,
                                        sizeof address.sun_path - 1));
  }
  std::copy(path.begin(), path.end(), address.sun_path);
  return address;
}

}  // namespace

FileDescriptor& FileDescriptor::operator=(FileDescriptor&& other) noexcept {
  if (this != &other) {
    reset();
    fd_ = other.fd_;
    other.fd_ = -1;
  }
  return *this;
}

void FileDescriptor::reset() {
  if (fd_ >= 0) close(fd_);
  fd_ = -1;
}

void BusPty::plug() {
  master_ = FileDescriptor(posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (!master_.open() || grantpt(master_.get()) != 0 || unlockpt(master_.get()) != 0)
    fail("cannot make a pty");
  char name[128];
  if (ptsname_r(master_.get(), name, sizeof name) != 0) fail("cannot name the pty");
  device_ = name;
  far_end_ = FileDescriptor(open(name, O_RDWR | O_NOCTTY | O_CLOEXEC));
  termios settings{};
  if (!far_end_.open() || tcgetattr(far_end_.get(), &settings) != 0) fail("cannot open " + device_);
  cfmakeraw(&settings);
  tcsetattr(far_end_.get(), TCSANOW, &settings);
  unlink(link_.c_str());
  if (symlink(name, link_.c_str()) != 0) fail("cannot make the link " + link_);
}

void BusPty::take_away() {
  if (master_.open()) unlink(link_.c_str());
  far_end_.reset();
  master_.reset();
}

int BusPty::baud() const { return line_speed(master_.get()); }

std::size_t BusPty::read(std::span<std::uint8_t> out) {
  if (!master_.open()) return 0;
  const ssize_t count = ::read(master_.get(), out.data(), out.size());
  return count > 0 ? static_cast<std::size_t>(count) : 0;
}

void BusPty::write(std::span<const std::uint8_t> bytes) {
  if (!master_.open()) return;
  // a full pty means that nobody reads: the bytes are lost, as on a wire
  if (::write(master_.get(), bytes.data(), bytes.size()) < 0 && errno != EAGAIN) master_.reset();
}

PacketServer::PacketServer(const std::string& path)
    : path_(path), listener_(socket(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {
  const sockaddr_un address = address_of(path);
  unlink(path.c_str());
  if (!listener_.open() ||
      bind(listener_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      listen(listener_.get(), 4) != 0) {
    fail("cannot listen at " + path);
  }
}

PacketServer::~PacketServer() { unlink(path_.c_str()); }

std::vector<int> PacketServer::accept_new() {
  std::vector<int> added;
  while (true) {
    FileDescriptor client(accept4(listener_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (!client.open()) return added;
    added.push_back(client.get());
    clients_.push_back(std::move(client));
  }
}

std::size_t PacketServer::receive(std::span<std::uint8_t> out, int& client) {
  for (std::size_t i = 0; i < clients_.size();) {
    client = clients_[i].get();
    const ssize_t count = recv(client, out.data(), out.size(), 0);
    if (count > 0) return static_cast<std::size_t>(count);
    const bool gone = count == 0 || (errno != EAGAIN && errno != EINTR);
    if (gone) {
      clients_.erase(clients_.begin() + static_cast<std::ptrdiff_t>(i));
    } else {
      ++i;
    }
  }
  return 0;
}

void PacketServer::send(int client, std::span<const std::uint8_t> message) {
  // a slow reader loses messages
  (void)!::send(client, message.data(), message.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
}

void PacketServer::send_all(std::span<const std::uint8_t> message) {
  for (const auto& client : clients_) send(client.get(), message);
}

void PacketServer::add_descriptors(std::vector<int>& out) const {
  out.push_back(listener_.get());
  for (const auto& client : clients_) out.push_back(client.get());
}

FileDescriptor connect_packets(const std::string& path) {
  FileDescriptor fd(socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0));
  const sockaddr_un address = address_of(path);
  if (!fd.open() ||
      connect(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    fail(fmt::format("no emulator at {} (start one: sanso-emulator --dir ...)", path));
  }
  return fd;
}

}  // namespace sanso::emulator
