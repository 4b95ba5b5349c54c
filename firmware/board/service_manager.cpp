// The protocol is one line of text a datagram; a path that starts with @ is an abstract socket.
#include "firmware/board/service_manager.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>

namespace sanso::board {

ServiceManager::ServiceManager() {
  const char* path = std::getenv("NOTIFY_SOCKET");
  const std::string_view name = path == nullptr ? "" : path;
  sockaddr_un address{};
  if (name.empty() || name.size() >= sizeof address.sun_path) return;
  address.sun_family = AF_UNIX;
  std::copy(name.begin(), name.end(), address.sun_path);
  if (name[0] == '@') address.sun_path[0] = '\0';
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + name.size());
  socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (socket_ >= 0 && ::connect(socket_, reinterpret_cast<const sockaddr*>(&address), size) != 0) {
    ::close(socket_);
    socket_ = -1;
  }
  const char* watchdog = std::getenv("WATCHDOG_USEC");
  if (socket_ >= 0 && watchdog != nullptr)
    watchdog_period_ = std::max(0LL, std::atoll(watchdog)) * (kMillisecond / 1000);
}

ServiceManager::~ServiceManager() {
  if (socket_ >= 0) ::close(socket_);
}

/// A manager that does not listen costs nothing: the datagram is dropped.
void ServiceManager::say(std::string_view text) const {
  if (socket_ >= 0) (void)::send(socket_, text.data(), text.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
}

void TickWatch::look(std::uint64_t ticks) {
  if (ticks == seen_) return;
  if (seen_ == 0) manager_.ready();
  seen_ = ticks;
  manager_.watchdog();
}

}  // namespace sanso::board
