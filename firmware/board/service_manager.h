// What systemd wants to hear from a service (sd_notify): a datagram to the socket that the
// environment names. Without such a socket every call does nothing.
#pragma once

#include <string>
#include <string_view>

#include "shared/base/time.h"

namespace sanso::board {

class ServiceManager {
 public:
  /// Reads NOTIFY_SOCKET and WATCHDOG_USEC.
  ServiceManager();
  ~ServiceManager();
  ServiceManager(const ServiceManager&) = delete;
  ServiceManager& operator=(const ServiceManager&) = delete;

  bool present() const { return socket_ >= 0; }
  /// How often watchdog() is expected; 0: never.
  Nanoseconds watchdog_period() const { return watchdog_period_; }

  void ready() const { say("READY=1"); }
  void stopping() const { say("STOPPING=1"); }
  void watchdog() const { say("WATCHDOG=1"); }
  void status(const std::string& line) const { say("STATUS=" + line); }

 private:
  void say(std::string_view text) const;
  int socket_ = -1;  // connected
  Nanoseconds watchdog_period_ = 0;
};

/// Feeds the watchdog for as long as ticks go by: a program whose tick hangs is ended and started
/// anew by systemd, and adopts the robot.
class TickWatch {
 public:
  explicit TickWatch(const ServiceManager& manager) : manager_(manager) {}
  /// `ticks`: how many there have been. The first says "ready"; each call that sees new ones feeds
  /// the watchdog.
  void look(std::uint64_t ticks);

 private:
  const ServiceManager& manager_;
  std::uint64_t seen_ = 0;
};

}  // namespace sanso::board
