// The newest value from one thread to another, however large: three slots whose roles (being
// written, newest, being read) are exchanged by one atomic word. No copy on the reading side, no
// lock, neither side ever waits.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace sanso::firmware {

template <class T>
class Mailbox {
 public:
  // --- producer ---
  /// The slot to fill. Its old contents are those of an earlier value.
  T& back() { return slots_[back_]; }
  /// Makes back() the newest value.
  void publish() {
    const std::uint8_t previous =
        middle_.exchange(static_cast<std::uint8_t>(back_ | kFresh), std::memory_order_acq_rel);
    back_ = previous & kIndex;
  }

  // --- consumer ---
  /// Moves to the newest value; true when it is another one than before. front() stays put until
  /// the next update().
  bool update() {
    if ((middle_.load(std::memory_order_relaxed) & kFresh) == 0) return false;
    const std::uint8_t previous = middle_.exchange(front_, std::memory_order_acq_rel);
    front_ = previous & kIndex;
    return true;
  }
  const T& front() const { return slots_[front_]; }

 private:
  static constexpr std::uint8_t kIndex = 3, kFresh = 4;
  std::array<T, 3> slots_{};
  std::uint8_t back_ = 0;  // producer's
  std::atomic<std::uint8_t> middle_{1};
  std::uint8_t front_ = 2;  // consumer's
};

}  // namespace sanso::firmware
