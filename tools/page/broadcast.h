// One writer, any number of viewers: every viewer has a short queue of its own, and the writer
// never waits for any of them. A viewer that does not keep up misses frames, and nothing else.
#pragma once

#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "shared/base/time.h"

namespace sanso::page {

class Broadcast {
 public:
  static constexpr std::size_t kQueue = 8;  // a quarter of a second of frames

  class Viewer {
   public:
    /// The next text, or empty when none came within `patience` or the broadcast has closed.
    std::string next(Nanoseconds patience);

   private:
    friend class Broadcast;
    explicit Viewer(Broadcast& of) : of_(of) {}
    struct Item {
      std::string text;
      bool frame;
    };
    Broadcast& of_;
    std::deque<Item> queue_;  // under of_.mutex_
  };

  /// Begins with `greeting`. Ends when the viewer is destroyed. The broadcast outlives its viewers.
  std::shared_ptr<Viewer> join(std::vector<std::string> greeting);
  /// A frame may be lost; anything else only when a viewer has not read for long.
  void publish(const std::string& text, bool frame);
  /// Wakes all viewers; next() returns empty from now on.
  void close();
  bool closed() const;
  std::size_t viewers() const;
  std::uint64_t dropped() const;

 private:
  mutable std::mutex mutex_;
  std::condition_variable news_;
  std::vector<std::weak_ptr<Viewer>> viewers_;
  std::uint64_t dropped_ = 0;
  bool closed_ = false;
};

}  // namespace sanso::page
