// Twenty servos and the OpenCR board that answer at once from fixed memory, real packets both ways:
// for timing the controller's tick without the physics of the emulator, and for tests that count
// allocations.
#pragma once

#include <array>

#include "firmware/board/board.h"
#include "firmware/bus/servos.h"
#include "shared/servo_bus/encode.h"
#include "shared/servo_bus/parser.h"

namespace sanso::bench {

/// Processor time of the calling thread.
Nanoseconds thread_cpu();

class InstantBus : public board::SerialPort {
 public:
  InstantBus();
  Status write(board::Bytes data) override;
  Result<std::size_t> read(board::Buffer buffer, Nanoseconds deadline) override;
  Status ready() override { return Status::ok; }

  /// Servos behind this slot do not answer any more (kNumServos: all answer).
  void silence_from(int slot) { silent_from_ = slot; }
  std::int32_t goal_raw(int slot) const { return get(slot, 116, 4); }
  bool torque_on(int slot) const { return get(slot, 64, 1) != 0; }
  /// Overwrites a register: another model number, a hardware error, ...
  void poke(int slot, std::uint16_t address, std::uint8_t size, std::int32_t value);
  std::int32_t get(int slot, std::uint16_t address, std::uint8_t size) const;
  /// CPU time spent inside write() and read(), to be taken off the controller's own [ns].
  Nanoseconds cpu_ns() const { return cpu_ns_; }

 private:
  static constexpr std::size_t kTable = 160;
  static constexpr int kOpenCr = firmware::kNumServos;  // last row
  using Table = std::array<std::uint8_t, kTable>;

  void answer(const servo_bus::Packet& packet);
  void reply(int slot, std::span<const std::uint8_t> data);
  void read_many(const servo_bus::Packet& packet, bool merged);
  void write_many(const servo_bus::Packet& packet);
  void wrote(int slot);
  int row_of(std::uint8_t id) const;
  bool silent(int row) const { return row < kOpenCr && row >= silent_from_; }

  std::array<Table, firmware::kNumServos + 1> table_{};
  servo_bus::PacketParser parser_;
  servo_bus::Packet packet_;
  servo_bus::PacketBuffer out_;
  FixedVector<std::uint8_t, 4096> pending_;
  std::size_t taken_ = 0;
  int silent_from_ = firmware::kNumServos;
  Nanoseconds cpu_ns_ = 0;
};

}  // namespace sanso::bench
