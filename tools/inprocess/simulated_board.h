// The controller's board in virtual time: every seam of firmware/board/board.h served by an
// emulated robot, bytes for bytes. Waiting for bytes is what makes time pass, as waiting does on a
// machine.
#pragma once

#include <deque>
#include <vector>

#include "firmware/board/board.h"
#include "tools/emulator/emulated_robot.h"

namespace sanso::inprocess {

class SimulatedClock : public board::Clock {
 public:
  explicit SimulatedClock(const emulator::EmulatedRobot& robot) : robot_(robot) {}
  Nanoseconds now() override { return robot_.now(); }

 private:
  const emulator::EmulatedRobot& robot_;
};

class SimulatedSerialPort : public board::SerialPort {
 public:
  explicit SimulatedSerialPort(emulator::EmulatedRobot& robot) : robot_(robot) {}
  Status write(board::Bytes data) override;
  Result<std::size_t> read(board::Buffer buffer, Nanoseconds deadline) override;
  Status ready() override { return pulled_ ? Status::io_error : Status::ok; }
  /// The cable is pulled out (true) or put back.
  void pull(bool pulled) { pulled_ = pulled; }
  /// What happens to one request or to its reply.
  enum class Spoil : std::uint8_t { lose_request, damage_request, lose_reply, damage_reply };
  /// Strikes the request that comes `requests` from now on (1: the next).
  void spoil(Spoil how, int requests) {
    spoil_ = how;
    spoil_at_ = written_ + requests;
  }

 private:
  bool struck(Spoil how) const { return written_ == spoil_at_ && spoil_ == how; }

  emulator::EmulatedRobot& robot_;
  bool pulled_ = false;
  Spoil spoil_ = Spoil::lose_request;
  int written_ = 0, spoil_at_ = -1;  // requests so far; the one that is struck
};

class SimulatedImu : public board::HidSource {
 public:
  explicit SimulatedImu(emulator::EmulatedRobot& robot) : robot_(robot) {}
  board::Bytes descriptor() override { return emulator::EmulatedRobot::imu_descriptor(); }
  Status set_feature(board::Bytes report) override;
  Result<std::size_t> read(board::Buffer buffer, Nanoseconds deadline) override;

 private:
  emulator::EmulatedRobot& robot_;
};

class SimulatedPose : public board::PoseSource {
 public:
  explicit SimulatedPose(emulator::EmulatedRobot& robot) : robot_(robot) {}
  Result<std::size_t> read(board::Buffer buffer, Nanoseconds deadline) override;

 private:
  emulator::EmulatedRobot& robot_;
};

/// Two queues of datagrams: the controller's end of the network.
class SimulatedNetwork : public board::Datagram {
 public:
  using Bytes = std::vector<std::uint8_t>;
  Status send(board::Bytes data, const board::Peer& to) override;
  Result<std::size_t> receive(board::Buffer buffer, board::Peer& from,
                              Nanoseconds deadline) override;
  std::deque<Bytes> to_host, to_controller;
};

}  // namespace sanso::inprocess
