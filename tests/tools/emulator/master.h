// A small bus master for tests: sends one instruction and lets virtual time pass until the replies
// are in.
#pragma once

#include <optional>
#include <vector>

#include "shared/servo_bus/encode.h"
#include "shared/servo_bus/opencr.h"
#include "shared/servo_bus/parser.h"
#include "shared/servo_bus/units.h"
#include "shared/servo_bus/xm430.h"
#include "tools/emulator/emulated_robot.h"

namespace sanso::emulator {

namespace xm = servo_bus::xm430;

class Master {
 public:
  explicit Master(EmulatedRobot& robot) : robot_(robot) {}

  /// Sends `wire` and collects whatever packets come within `wait`.
  std::vector<servo_bus::Packet> exchange(const servo_bus::PacketBuffer& wire,
                                          Nanoseconds wait = 5 * kMillisecond) {
    const Nanoseconds deadline = robot_.now() + wait;
    robot_.bus_write(wire.view());
    std::vector<servo_bus::Packet> packets;
    while (robot_.now() < deadline) {
      robot_.advance(std::min(deadline, robot_.next_bus_byte()));
      std::uint8_t buffer[256];
      const std::size_t count = robot_.bus_read(buffer);
      parser_.feed({buffer, count});
      servo_bus::Packet packet;
      while (true) {
        const auto event = parser_.next(packet);
        if (event == servo_bus::ParseEvent::none) break;
        if (event == servo_bus::ParseEvent::packet) packets.push_back(packet);
        if (event == servo_bus::ParseEvent::packet)
          frame_.assign(parser_.frame().begin(), parser_.frame().end());
        if (event == servo_bus::ParseEvent::crc_error) ++crc_errors;
        last_packet_time = robot_.now();
      }
    }
    pending_.assign(parser_.pending().begin(), parser_.pending().end());
    parser_.reset();
    return packets;
  }

  std::optional<servo_bus::Packet> one(const servo_bus::PacketBuffer& wire) {
    const auto packets = exchange(wire, 2 * kMillisecond);
    return packets.empty() ? std::nullopt : std::optional(packets.front());
  }

  std::optional<std::int64_t> read(int id, const servo_bus::Register& r) {
    servo_bus::encode_read(wire_, static_cast<std::uint8_t>(id), r.address, r.size);
    const auto packet = one(wire_);
    if (!packet || packet->parameters.size() != r.size) return std::nullopt;
    std::uint8_t wide[4] = {};
    std::copy(packet->parameters.begin(), packet->parameters.end(), wide);
    const std::int64_t u = servo_bus::get_u32(wide);
    return r.is_signed && (u >> (8 * r.size - 1)) & 1 ? u - (std::int64_t{1} << (8 * r.size)) : u;
  }

  /// The reply's status; result_fail stands for silence too, with `answered` telling them apart.
  servo_bus::StatusError write(int id, const servo_bus::Register& r, std::int64_t value) {
    return write_bytes(id, r.address, r.size, value);
  }
  servo_bus::StatusError write_bytes(int id, std::uint16_t address, std::size_t size,
                                     std::int64_t value) {
    std::uint8_t data[4];
    servo_bus::put_le(data, size, value);
    servo_bus::encode_write(wire_, static_cast<std::uint8_t>(id), address, {data, size});
    const auto packet = one(wire_);
    answered = packet.has_value();
    return packet ? packet->status_error() : servo_bus::StatusError::result_fail;
  }

  /// The same value to every servo.
  void write_all(const servo_bus::Register& r, const std::vector<std::int64_t>& values) {
    std::vector<std::uint8_t> ids, data;
    for (int i = 0; i < kNumServos; ++i) {
      ids.push_back(static_cast<std::uint8_t>(i + 1));
      std::uint8_t bytes[4];
      servo_bus::put_le(bytes, r.size, values[values.size() == 1 ? 0 : i]);
      data.insert(data.end(), bytes, bytes + r.size);
    }
    servo_bus::encode_sync_write(wire_, r.address, r.size, ids, data);
    robot_.bus_write(wire_.view());
    robot_.advance(robot_.now() + kMillisecond);
  }

  /// Power on, boot, gains, goals = present positions, torque on.
  void stand_by(int p_gain = 560) {
    write_bytes(servo_bus::opencr::kId, servo_bus::opencr::kServoPower, 1, 1);
    robot_.advance(robot_.now() + 1100 * kMillisecond);
    write_all(xm::kPositionPGain, {p_gain});
    std::vector<std::int64_t> goals;
    for (const double q : robot_.truth().q) goals.push_back(servo_bus::position_raw(q));
    write_all(xm::kGoalPosition, goals);
    write_all(xm::kTorqueEnable, {1});
  }

  const std::vector<std::uint8_t>& frame() const { return frame_; }  // of the last packet
  // cut short at the deadline
  const std::vector<std::uint8_t>& pending() const { return pending_; }

  bool answered = false;
  int crc_errors = 0;
  Nanoseconds last_packet_time = 0;

 private:
  EmulatedRobot& robot_;
  servo_bus::PacketParser parser_;
  servo_bus::PacketBuffer wire_;
  std::vector<std::uint8_t> frame_, pending_;
};

}  // namespace sanso::emulator
