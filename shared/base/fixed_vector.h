// A vector whose capacity is part of its type: it never grows, never allocates, and says when it is
// full.
#pragma once

#include <array>
#include <cassert>
#include <cstddef>
#include <span>

namespace sanso {

template <class T, std::size_t Capacity>
class FixedVector {
 public:
  using value_type = T;
  static constexpr std::size_t capacity() { return Capacity; }
  constexpr std::size_t size() const { return size_; }
  constexpr bool empty() const { return size_ == 0; }
  constexpr bool full() const { return size_ == Capacity; }
  constexpr void clear() { size_ = 0; }

  /// Appends and returns true, or returns false and changes nothing when full.
  constexpr bool try_push(const T& item) {
    if (full()) return false;
    items_[size_++] = item;
    return true;
  }
  /// Appends all of `items`, or none of them.
  constexpr bool try_append(std::span<const T> items) {
    if (items.size() > Capacity - size_) return false;
    for (const T& item : items) items_[size_++] = item;
    return true;
  }
  /// Sets the size; new elements are value-initialised. False (unchanged) when `n` exceeds the
  /// capacity.
  constexpr bool try_resize(std::size_t n) {
    if (n > Capacity) return false;
    for (std::size_t i = size_; i < n; ++i) items_[i] = T{};
    size_ = n;
    return true;
  }
  constexpr void pop_back() {
    assert(size_ > 0);
    --size_;
  }

  constexpr T& operator[](std::size_t i) {
    assert(i < size_);
    return items_[i];
  }
  constexpr const T& operator[](std::size_t i) const {
    assert(i < size_);
    return items_[i];
  }
  constexpr T& back() { return (*this)[size_ - 1]; }
  constexpr const T& back() const { return (*this)[size_ - 1]; }
  constexpr T* data() { return items_.data(); }
  constexpr const T* data() const { return items_.data(); }
  constexpr T* begin() { return data(); }
  constexpr T* end() { return data() + size_; }
  constexpr const T* begin() const { return data(); }
  constexpr const T* end() const { return data() + size_; }
  constexpr std::span<const T> view() const { return {data(), size_}; }

 private:
  std::array<T, Capacity> items_{};
  std::size_t size_ = 0;
};

}  // namespace sanso
