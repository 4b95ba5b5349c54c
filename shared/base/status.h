// Status codes and a Result that carries a value or a status. No exceptions, no heap: usable inside
// the tick.
#pragma once

#include <cstdint>

namespace sanso {

enum class Status : std::uint8_t {
  ok = 0,
  full,          // fixed capacity reached
  empty,         // nothing there (no packet, no sample yet)
  malformed,     // bytes that cannot be what they claim
  unsupported,   // well-formed, but a version or type this program does not know
  out_of_range,  // a value outside its documented range
  timeout,
  io_error,  // the operating system said no; errno holds the reason
  rejected,  // authentication or replay check failed
  stale,     // valid once, too old now
  not_ready,
};

constexpr const char* to_string(Status s) {
  switch (s) {
    case Status::ok:
      return "ok";
    case Status::full:
      return "full";
    case Status::empty:
      return "empty";
    case Status::malformed:
      return "malformed";
    case Status::unsupported:
      return "unsupported";
    case Status::out_of_range:
      return "out of range";
    case Status::timeout:
      return "timeout";
    case Status::io_error:
      return "i/o error";
    case Status::rejected:
      return "rejected";
    case Status::stale:
      return "stale";
    case Status::not_ready:
      return "not ready";
  }
  return "unknown";
}

/// A value or the reason why there is none. T must be default constructible.
template <class T>
class Result {
 public:
  constexpr Result(const T& value) : value_(value) {}   // NOLINT: implicit on purpose
  constexpr Result(Status status) : status_(status) {}  // NOLINT: implicit on purpose
  constexpr bool ok() const { return status_ == Status::ok; }
  constexpr explicit operator bool() const { return ok(); }
  constexpr Status status() const { return status_; }
  constexpr const T& value() const { return value_; }
  constexpr const T& operator*() const { return value_; }
  constexpr const T* operator->() const { return &value_; }

 private:
  T value_{};
  Status status_ = Status::ok;
};

}  // namespace sanso
