// Ctrl-C, asked politely: the first one lets the trial under way end and be stored, the second one
// ends the program at once.
#pragma once

#include <csignal>

namespace sanso::app {

/// Takes SIGINT and SIGTERM while it lives; what was installed before comes back afterwards. One
/// inside another is part of the outer one: a sweep's covers those of its sessions. One thread
/// makes them.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;
  static bool requested();

 private:
  struct sigaction before_int_ {
  }, before_term_{};
};

}  // namespace sanso::app
