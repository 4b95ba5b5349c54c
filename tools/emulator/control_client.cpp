// Connects, sends one request and waits for its answer; that nobody listens is an error.
#include "tools/emulator/control_client.h"

#include <poll.h>
#include <sys/socket.h>

#include <vector>

#include "tools/emulator/sockets.h"
#include "tools/plant/world_error.h"

namespace sanso::emulator {

std::string tell_emulator(const std::string& directory, const std::string& json) {
  const FileDescriptor fd = connect_packets(directory + "/control");
  if (send(fd.get(), json.data(), json.size(), MSG_NOSIGNAL) < 0) {
    throw plant::WorldError("the emulator at " + directory + " does not take the command");
  }
  // an emulator of ordinary priority may wait long for a crowded machine
  constexpr int kPatience_ms = 20'000;
  pollfd wait{fd.get(), POLLIN, 0};
  std::vector<char> answer(65536);
  const ssize_t size =
      poll(&wait, 1, kPatience_ms) == 1 ? recv(fd.get(), answer.data(), answer.size(), 0) : -1;
  if (size <= 0) throw plant::WorldError("the emulator at " + directory + " does not answer");
  return {answer.data(), static_cast<std::size_t>(size)};
}

}  // namespace sanso::emulator
