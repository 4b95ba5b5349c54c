// Two messages each way, 48 bytes of header in network order: submit a transfer, take it back.
#include "tools/emulator/usb/usbip_plug.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <sstream>

#include "tools/plant/world_error.h"

namespace sanso::emulator {
namespace {

constexpr std::size_t kHeader = 48;
constexpr std::uint32_t kSubmit = 1, kUnlink = 2, kSubmitReply = 3, kUnlinkReply = 4;
constexpr std::uint32_t kToHost = 1;
constexpr std::uint32_t kMostData = 1 << 20;
constexpr std::int32_t kStall = -EPIPE, kTakenBack = -ECONNRESET;
constexpr const char* kController = "/sys/devices/platform/vhci_hcd.0/";
constexpr int kHighSpeed = 3, kPortFree = 4;

std::uint32_t word(std::span<const std::uint8_t> bytes, std::size_t at) {
  return static_cast<std::uint32_t>(bytes[at]) << 24 |
         static_cast<std::uint32_t>(bytes[at + 1]) << 16 |
         static_cast<std::uint32_t>(bytes[at + 2]) << 8 | bytes[at + 3];
}
void put_word(UsbBytes& bytes, std::size_t at, std::uint32_t value) {
  for (std::size_t i = 0; i < 4; ++i)
    bytes[at + i] = static_cast<std::uint8_t>(value >> (24 - 8 * i));
}
std::uint16_t little(std::span<const std::uint8_t> bytes, std::size_t at) {
  return static_cast<std::uint16_t>(bytes[at] | bytes[at + 1] << 8);
}

/// The first port of high speed that has nothing plugged in; -1: none.
int free_port() {
  std::ifstream status(std::string(kController) + "status");
  for (std::string line; std::getline(status, line);) {
    std::istringstream in(line);
    std::string hub;
    int port = 0, state = 0;
    if (in >> hub >> port >> state && hub == "hs" && state == kPortFree) return port;
  }
  return -1;
}

}  // namespace

struct UsbipPlug::Request {
  std::uint32_t command, sequence, direction, endpoint, length, victim;
  UsbSetup setup;
};

void UsbipPlug::plug() {
  int pair[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, pair) != 0)
    throw plant::WorldError("USB: no socket pair");
  FileDescriptor kernel(pair[1]);
  FileDescriptor ours(pair[0]);
  ::fcntl(ours.get(), F_SETFL, O_NONBLOCK);
  const int port = free_port();
  std::ofstream attach(std::string(kController) + "attach");
  // number of the device: anything, but no two alike
  attach << fmt::format("{} {} {} {}", port, kernel.get(), 0x10000 + port, kHighSpeed)
         << std::flush;
  if (port < 0 || !attach)
    throw plant::WorldError(
        "USB: this kernel's virtual host controller takes no device; expected the module vhci-hcd "
        "(modprobe vhci-hcd), root, and a free port in " +
        std::string(kController) + "status");
  received_.clear();
  waiting_.clear();
  line_ = std::move(ours);
}

void UsbipPlug::unplug() { line_.reset(); }

void UsbipPlug::serve(Nanoseconds now) {
  while (line_.open() && read_request()) {
  }
  answer_waiting(now);
}

Nanoseconds UsbipPlug::next() const {
  return line_.open() && !waiting_.empty() ? function_.next_transfer() : INT64_MAX;
}

/// True when a whole request was there and was answered.
bool UsbipPlug::read_request() {
  std::uint8_t buffer[4096];
  for (ssize_t n; (n = ::read(line_.get(), buffer, sizeof buffer)) != -1 || errno == EINTR;) {
    if (n == 0) return unplug(), false;  // the kernel has let go
    if (n > 0) received_.insert(received_.end(), buffer, buffer + n);
  }
  if (received_.size() < kHeader) return false;
  const std::span<const std::uint8_t> h(received_);
  Request r{word(h, 0), word(h, 4), word(h, 12), word(h, 16), word(h, 24), word(h, 20), {}};
  r.setup = {h[40], h[41], little(h, 42), little(h, 44), little(h, 46)};
  const bool brings_data = r.command == kSubmit && r.direction != kToHost;
  if (r.length > kMostData && r.command == kSubmit) return unplug(), false;
  const std::size_t size = kHeader + (brings_data ? r.length : 0);
  if (received_.size() < size) return false;
  const bool good = handle(r, h.subspan(kHeader, size - kHeader));
  received_.erase(received_.begin(), received_.begin() + static_cast<std::ptrdiff_t>(size));
  if (!good) unplug();
  return good;
}

bool UsbipPlug::handle(const Request& request, std::span<const std::uint8_t> data) {
  if (request.command == kSubmit) return submit(request, data);
  return request.command == kUnlink && unlink(request);
}

bool UsbipPlug::submit(const Request& request, std::span<const std::uint8_t> data) {
  if (request.endpoint == 0) {
    const std::optional<UsbBytes> answer = function_.control(request.setup, data);
    if (!answer) return reply(request.sequence, kStall, {}, 0);
    const bool to_host = request.direction == kToHost;
    return reply(request.sequence, 0, to_host ? *answer : UsbBytes{},
                 to_host ? answer->size() : data.size());
  }
  if (request.direction != kToHost) {
    function_.receive(data);
    return reply(request.sequence, 0, {}, data.size());
  }
  waiting_.push_back({request.sequence, request.length});
  return true;
}

/// The host takes a request back: it had ended before, or it ends now.
bool UsbipPlug::unlink(const Request& request) {
  const auto it = std::find_if(waiting_.begin(), waiting_.end(),
                               [&](const Waiting& w) { return w.sequence == request.victim; });
  const bool waits = it != waiting_.end();
  if (waits) waiting_.erase(it);
  UsbBytes message(kHeader);
  put_word(message, 0, kUnlinkReply);
  put_word(message, 4, request.sequence);
  put_word(message, 20, waits ? static_cast<std::uint32_t>(kTakenBack) : 0);
  return send(message);
}

void UsbipPlug::answer_waiting(Nanoseconds now) {
  while (line_.open() && !waiting_.empty()) {
    const std::optional<UsbBytes> data = function_.transfer(now, waiting_.front().capacity);
    if (!data) return;
    const std::uint32_t sequence = waiting_.front().sequence;
    waiting_.pop_front();
    if (!reply(sequence, 0, *data, data->size())) unplug();
  }
}

bool UsbipPlug::reply(std::uint32_t sequence, std::int32_t status,
                      std::span<const std::uint8_t> data, std::size_t actual) {
  UsbBytes message(kHeader);
  put_word(message, 0, kSubmitReply);
  put_word(message, 4, sequence);
  put_word(message, 20, static_cast<std::uint32_t>(status));
  put_word(message, 24, static_cast<std::uint32_t>(actual));
  message.insert(message.end(), data.begin(), data.end());
  return send(message);
}

/// Answers are small and the kernel reads at once: a line that takes none is dead.
bool UsbipPlug::send(const UsbBytes& message) {
  return ::send(line_.get(), message.data(), message.size(), MSG_NOSIGNAL) ==
         static_cast<ssize_t>(message.size());
}

}  // namespace sanso::emulator
