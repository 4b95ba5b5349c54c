// One flag says whose the device is; the pauses belong to the helper thread alone and start small
// again only after the device has delivered something.
#include "firmware/board/reconnect.h"

#include <algorithm>

namespace sanso::board {
namespace {

constexpr Nanoseconds kShortestPause = 10 * kMillisecond;
constexpr Nanoseconds kLongestPause = 1 * kSecond;

/// Passes a reader's result on; an error gives the device away.
template <class Device, class Call>
Result<std::size_t> guarded(Device& device, Call&& call) {
  if (!device.up()) return Status::io_error;
  const Result<std::size_t> n = call();
  if (!n.ok())
    device.let_go();
  else if (*n > 0)
    device.delivered();
  return n;
}

}  // namespace

Nanoseconds Reconnecting::mend(Nanoseconds now) {
  if (up()) return now + kShortestPause;
  if (was_up_) {
    was_up_ = false;
    const std::string why = explanation_ ? explanation_() : std::string();
    news_ = name_ + ": " + (why.empty() ? "gone; waiting for it" : why);
    // what was opened and gave nothing is not tried faster and faster
    const bool worked = delivered_.exchange(false, std::memory_order_relaxed);
    pause_ = worked || pause_ == 0 ? kShortestPause : std::min(2 * pause_, kLongestPause);
    next_ = now + pause_;
  }
  if (now < next_) return next_;
  std::string message;
  if (device_.open(message) == Status::ok) {
    was_up_ = true;
    openings_.fetch_add(1, std::memory_order_relaxed);
    news_ = name_ + ": open" + (message.empty() ? "" : "; warning: " + message);
    up_.store(true, std::memory_order_release);
    return now + kShortestPause;
  }
  news_ = message.empty() ? name_ + ": cannot be opened" : message;
  pause_ = pause_ == 0 ? kShortestPause : std::min(2 * pause_, kLongestPause);
  next_ = now + pause_;
  return next_;
}

std::string Reconnecting::news() {
  if (news_ == told_) return {};
  told_ = news_;
  return told_;
}

Status ReconnectingSerial::write(Bytes data) {
  if (!up()) return Status::io_error;
  const Status status = port_->write(data);
  if (status == Status::io_error) let_go();
  return status;
}

Result<std::size_t> ReconnectingSerial::read(Buffer buffer, Nanoseconds deadline) {
  return guarded(*this, [&] { return port_->read(buffer, deadline); });
}

Status ReconnectingHid::set_feature(Bytes report) {
  return up() ? hid_->set_feature(report) : Status::io_error;
}

Result<std::size_t> ReconnectingHid::get_feature(Buffer report) {
  return up() ? hid_->get_feature(report) : Result<std::size_t>(Status::io_error);
}

Result<std::size_t> ReconnectingHid::read(Buffer buffer, Nanoseconds deadline) {
  return guarded(*this, [&] { return hid_->read(buffer, deadline); });
}

Result<std::size_t> ReconnectingPose::read(Buffer buffer, Nanoseconds deadline) {
  return guarded(*this, [&] { return pose_->read(buffer, deadline); });
}

}  // namespace sanso::board
