// A session of its own with a controller that somebody else may own: watches, and stops in an
// emergency. The protocol lets every session do both (docs/wire.md), so the page takes no time from
// the program that plans.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "host/link/robot_link.h"
#include "shared/wire/messages.h"
#include "shared/wire/secure_channel.h"

namespace sanso::page {

class RobotWatch {
 public:
  using Seen = std::function<void(const wire::Observation&)>;
  /// `seen` gets the newest observation, from a thread of this class, at most every 20 ms.
  RobotWatch(std::string address, const wire::Key& key, Seen seen);
  ~RobotWatch();
  RobotWatch(const RobotWatch&) = delete;
  RobotWatch& operator=(const RobotWatch&) = delete;

  bool connected() const { return connected_; }
  /// Sends a command and says in words what came of it. Any thread; throws std::runtime_error when
  /// the controller refuses or does not answer.
  std::string ask(wire::CommandKind kind);

 private:
  struct Request;
  void run();
  void watch(link::RobotLink& robot);
  bool carry_out(link::RobotLink& robot);
  std::string address_;
  wire::Key key_;
  Seen seen_;
  std::mutex mutex_;
  std::shared_ptr<Request> request_;  // under mutex_; one at a time
  std::atomic<bool> stop_{false}, connected_{false};
  std::thread thread_;
};

}  // namespace sanso::page
