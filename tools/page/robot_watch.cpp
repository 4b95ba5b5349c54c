// One thread owns the link; whoever asks leaves a request and waits for its answer.
#include "tools/page/robot_watch.h"

#include <fmt/format.h>

#include <chrono>
#include <future>
#include <stdexcept>
#include <utility>

#include "host/link/udp_channel.h"

namespace sanso::page {
namespace {

constexpr Nanoseconds kLook = 20 * kMillisecond, kSilence = 2 * kSecond;
constexpr Nanoseconds kSignOfLife = 500 * kMillisecond;  // a watcher that is silent gets nothing
constexpr auto kPatience = std::chrono::seconds(5);

std::string words(Status status, const link::RobotLink& robot) {
  if (status == Status::ok) return "done";
  if (status == Status::rejected)
    throw std::runtime_error(
        fmt::format("the controller refuses, R{} (docs/faults.md)", robot.refusal()));
  throw std::runtime_error("the controller does not answer");
}

}  // namespace

struct RobotWatch::Request {
  wire::CommandKind kind;
  std::promise<std::string> answer;
};

RobotWatch::RobotWatch(std::string address, const wire::Key& key, Seen seen)
    : address_(std::move(address)), key_(key), seen_(std::move(seen)), thread_([this] { run(); }) {}

RobotWatch::~RobotWatch() {
  stop_ = true;
  thread_.join();
}

std::string RobotWatch::ask(wire::CommandKind kind) {
  if (!connected_) throw std::runtime_error("no connection to the controller");
  const auto request = std::make_shared<Request>(Request{kind, {}});
  std::future<std::string> answer = request->answer.get_future();
  {
    const std::lock_guard lock(mutex_);
    const bool urgent = kind == wire::CommandKind::emergency_stop;
    if (request_ && !urgent) throw std::runtime_error("another request is under way");
    request_ = request;
  }
  if (answer.wait_for(kPatience) != std::future_status::ready)
    throw std::runtime_error("the controller does not answer");
  return answer.get();
}

void RobotWatch::run() {
  while (!stop_) {
    link::UdpChannel channel(address_);
    link::MonotonicClock clock(channel);
    link::RobotLink robot(channel, clock, key_, {.patience = kSecond});
    if (robot.open() != Status::ok) continue;  // it waits by itself
    connected_ = true;
    watch(robot);
    connected_ = false;
  }
}

/// Until the end, until the controller has been silent for long, or until an order has made this
/// session the owner: the next one looks again, and the lease of this one runs out.
void RobotWatch::watch(link::RobotLink& robot) {
  Nanoseconds heard = robot.clock().now(), spoke = heard;
  while (!stop_ && robot.clock().now() - heard < kSilence) {
    const Nanoseconds next = robot.clock().now() + kLook;
    const std::uint64_t before = robot.latest().tick;
    while (robot.clock().now() < next) robot.wait_observation(next);
    (void)robot.take_observations();
    if (carry_out(robot)) return;
    const Nanoseconds now = robot.clock().now();
    if (robot.latest().tick != before) {
      heard = now;
      seen_(robot.latest());
    }
    if (now - spoke < kSignOfLife) continue;
    robot.send_sign_of_life();
    spoke = now;
  }
}

/// True when the controller took an order.
bool RobotWatch::carry_out(link::RobotLink& robot) {
  std::shared_ptr<Request> request;
  {
    const std::lock_guard lock(mutex_);
    request = std::exchange(request_, nullptr);
  }
  if (!request) return false;
  try {
    request->answer.set_value(words(robot.command({.kind = request->kind}), robot));
    return request->kind != wire::CommandKind::emergency_stop;
  } catch (const std::runtime_error&) {
    request->answer.set_exception(std::current_exception());
    return false;
  }
}

}  // namespace sanso::page
