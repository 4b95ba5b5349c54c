// The lock is held for pushing and popping strings, never while anybody writes to a socket.
#include "tools/page/broadcast.h"

#include <algorithm>
#include <chrono>

namespace sanso::page {

constexpr std::size_t kMostWords = 256;  // what is no frame: trials, faults

std::string Broadcast::Viewer::next(Nanoseconds patience) {
  std::unique_lock lock(of_.mutex_);
  of_.news_.wait_for(lock, std::chrono::nanoseconds(patience),
                     [&] { return of_.closed_ || !queue_.empty(); });
  if (of_.closed_ || queue_.empty()) return {};
  std::string text = std::move(queue_.front().text);
  queue_.pop_front();
  return text;
}

std::shared_ptr<Broadcast::Viewer> Broadcast::join(std::vector<std::string> greeting) {
  const std::shared_ptr<Viewer> viewer(new Viewer(*this));
  const std::lock_guard lock(mutex_);
  for (std::string& text : greeting) viewer->queue_.push_back({std::move(text), false});
  viewers_.push_back(viewer);
  return viewer;
}

void Broadcast::publish(const std::string& text, bool frame) {
  {
    const std::lock_guard lock(mutex_);
    std::erase_if(viewers_, [](const auto& v) { return v.expired(); });
    for (const std::weak_ptr<Viewer>& weak : viewers_) {
      const std::shared_ptr<Viewer> viewer = weak.lock();
      if (!viewer) continue;
      auto& queue = viewer->queue_;
      const auto frames =
          std::count_if(queue.begin(), queue.end(), [](auto& i) { return i.frame; });
      if (frame && frames >= static_cast<std::ptrdiff_t>(kQueue)) {
        // the oldest goes: who looks wants to see now
        queue.erase(std::find_if(queue.begin(), queue.end(), [](auto& i) { return i.frame; }));
        ++dropped_;
      }
      if (!frame && queue.size() >= kMostWords) {
        ++dropped_;
        continue;
      }
      queue.push_back({text, frame});
    }
  }
  news_.notify_all();
}

void Broadcast::close() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }
  news_.notify_all();
}

bool Broadcast::closed() const {
  const std::lock_guard lock(mutex_);
  return closed_;
}

std::size_t Broadcast::viewers() const {
  const std::lock_guard lock(mutex_);
  return static_cast<std::size_t>(
      std::count_if(viewers_.begin(), viewers_.end(), [](const auto& v) { return !v.expired(); }));
}

std::uint64_t Broadcast::dropped() const {
  const std::lock_guard lock(mutex_);
  return dropped_;
}

}  // namespace sanso::page
