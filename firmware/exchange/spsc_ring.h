// A queue between one producing and one consuming thread: fixed capacity, no lock, neither side
// ever waits.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>

namespace sanso::firmware {

template <class T, std::size_t Capacity>
class SpscRing {
  static_assert((Capacity & (Capacity - 1)) == 0, "a power of two");

 public:
  /// Producer: false (and nothing changed) when full.
  bool push(const T& item) {
    const std::size_t head = head_.load(std::memory_order_relaxed);
    if (head - tail_.load(std::memory_order_acquire) == Capacity) return false;
    items_[head % Capacity] = item;
    head_.store(head + 1, std::memory_order_release);
    return true;
  }
  /// Consumer: false when empty.
  bool pop(T& item) {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    if (tail == head_.load(std::memory_order_acquire)) return false;
    item = items_[tail % Capacity];
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }
  /// Consumer: items there at this moment; more may come.
  std::size_t size() const {
    return head_.load(std::memory_order_acquire) - tail_.load(std::memory_order_relaxed);
  }

 private:
  std::array<T, Capacity> items_{};
  alignas(64) std::atomic<std::size_t> head_{0};
  alignas(64) std::atomic<std::size_t> tail_{0};
};

}  // namespace sanso::firmware
