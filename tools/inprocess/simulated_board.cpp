// Every wait advances the emulated robot to the next byte or to the deadline; nothing here
// sleeps.
#include "tools/inprocess/simulated_board.h"

#include <algorithm>

// Of RealtimeSanitizer, in a program that runs under it; null in every other.
extern "C" {
void __rtsan_disable() __attribute__((weak));
void __rtsan_enable() __attribute__((weak));
}

namespace sanso::inprocess {
namespace {

/// What the world does while a tick waits for its servos is not the tick's work: it may allocate.
class World {
 public:
  World() {
    if (__rtsan_disable != nullptr) __rtsan_disable();
  }
  ~World() {
    if (__rtsan_enable != nullptr) __rtsan_enable();
  }
  World(const World&) = delete;
  World& operator=(const World&) = delete;
};

constexpr std::uint8_t kFlipped = 0x10;  // the bit of a byte that damage flips

/// Takes what `read` has until there is something or `deadline` has passed, letting the world run
/// in between.
template <class Read>
Result<std::size_t> read_until(emulator::EmulatedRobot& robot, Nanoseconds deadline, Read read) {
  constexpr Nanoseconds kStep = kMillisecond;  // reports come every few milliseconds
  for (std::size_t n = read();; n = read()) {
    if (n > 0) return n;
    if (robot.now() >= deadline) return std::size_t{0};
    robot.advance(std::min(deadline, robot.now() + kStep));
  }
}

}  // namespace

Status SimulatedSerialPort::write(board::Bytes data) {
  const World world;
  if (pulled_) return Status::io_error;
  ++written_;
  if (struck(Spoil::lose_request)) return Status::ok;
  std::vector<std::uint8_t> bytes(data.begin(), data.end());
  if (struck(Spoil::damage_request)) bytes[bytes.size() / 2] ^= kFlipped;
  robot_.bus_write(bytes);
  return Status::ok;
}

Result<std::size_t> SimulatedSerialPort::read(board::Buffer buffer, Nanoseconds deadline) {
  const World world;
  if (pulled_) return Status::io_error;
  for (;;) {
    std::size_t n = robot_.bus_read(buffer);
    if (n > 0 && struck(Spoil::damage_reply)) buffer[n / 2] ^= kFlipped;
    if (struck(Spoil::lose_reply)) n = 0;
    if (n > 0) return n;
    if (robot_.now() >= deadline) return std::size_t{0};
    robot_.advance(std::min(deadline, robot_.next_bus_byte()));
  }
}

Status SimulatedImu::set_feature(board::Bytes report) {
  return robot_.imu_set_feature(report) ? Status::ok : Status::io_error;
}

Result<std::size_t> SimulatedImu::read(board::Buffer buffer, Nanoseconds deadline) {
  return read_until(robot_, deadline, [&] { return robot_.imu_read(buffer); });
}

Result<std::size_t> SimulatedPose::read(board::Buffer buffer, Nanoseconds deadline) {
  return read_until(robot_, deadline, [&] { return robot_.pose_read(buffer); });
}

Status SimulatedNetwork::send(board::Bytes data, const board::Peer&) {
  to_host.emplace_back(data.begin(), data.end());
  return Status::ok;
}

Result<std::size_t> SimulatedNetwork::receive(board::Buffer buffer, board::Peer& from,
                                              Nanoseconds) {
  if (to_controller.empty()) return std::size_t{0};
  const Bytes datagram = std::move(to_controller.front());
  to_controller.pop_front();
  from.size = 1;  // the only peer there is
  const std::size_t n = std::min(buffer.size(), datagram.size());
  std::copy_n(datagram.begin(), n, buffer.begin());
  return n;
}

}  // namespace sanso::inprocess
