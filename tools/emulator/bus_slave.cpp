// Packets are executed when their last byte has arrived; replies are put on a schedule of bytes
// that run() hands out as time passes.
#include "tools/emulator/bus_slave.h"

#include <algorithm>

namespace sanso::emulator {

using servo_bus::Instruction;
using servo_bus::Packet;
using servo_bus::PacketBuffer;
using servo_bus::StatusError;

namespace {

// a longer pause inside a packet discards it
constexpr Nanoseconds kMaxByteGap = 1500 * kMicrosecond;

using Ranges = FixedVector<BulkRange, 253>;

/// The (id, address, length) triples of a sync or bulk read; empty when malformed.
Ranges read_ranges(const Packet& packet, bool sync) {
  Ranges ranges;
  const auto p = packet.parameters.view();
  if (sync) {
    if (p.size() < 5) return ranges;
    for (const std::uint8_t id : p.subspan(4)) {
      ranges.try_push({id, servo_bus::get_u16(p), servo_bus::get_u16(p.subspan(2))});
    }
  } else if (p.size() % 5 == 0) {
    for (std::size_t i = 0; i < p.size(); i += 5) {
      ranges.try_push(
          {p[i], servo_bus::get_u16(p.subspan(i + 1)), servo_bus::get_u16(p.subspan(i + 3))});
    }
  }
  return ranges;
}

}  // namespace

BusSlave::BusSlave(std::vector<BusDevice*> devices, const FaultPlan& faults, std::int64_t baud,
                   std::uint64_t seed)
    : devices_(std::move(devices)),
      faults_(faults),
      byte_time_(servo_bus::wire_time_ns(1, baud)),
      random_(seed) {}

BusDevice* BusSlave::find(int id) {
  for (BusDevice* device : devices_) {
    if (device->id() == id) return device;
  }
  return nullptr;
}

void BusSlave::receive(std::span<const std::uint8_t> bytes, Nanoseconds now) {
  if (bytes.empty()) return;
  const Nanoseconds start = incoming_.empty() ? now : std::max(now, incoming_.back().end);
  if (strikes(FaultKind::request_drop, 0, now)) return;
  std::vector<std::uint8_t> copy(bytes.begin(), bytes.end());
  if (strikes(FaultKind::request_corrupt, 0, now))
    copy[random_.bits() % copy.size()] ^= static_cast<std::uint8_t>(1u << (random_.bits() % 8));
  if (!outgoing_.empty() && outgoing_.back().time > start) {
    for (auto& byte : outgoing_) {
      if (byte.time > start) byte.value ^= static_cast<std::uint8_t>(random_.bits() | 1);
    }
    for (auto& byte : copy) byte ^= static_cast<std::uint8_t>(random_.bits());
  }
  incoming_.push_back(
      {start + static_cast<Nanoseconds>(copy.size()) * byte_time_, std::move(copy)});
}

void BusSlave::run(Nanoseconds now) {
  if (outgoing_.empty() && incoming_.empty()) let_foreigner_speak(now);
  while (!incoming_.empty() && incoming_.front().end <= now) {
    const Incoming chunk = std::move(incoming_.front());
    incoming_.pop_front();
    const Nanoseconds begin = chunk.end - static_cast<Nanoseconds>(chunk.bytes.size()) * byte_time_;
    if (begin - last_arrival_ > kMaxByteGap) parser_.reset();
    last_arrival_ = chunk.end;
    std::span<const std::uint8_t> rest = chunk.bytes;
    while (!rest.empty()) {
      const std::size_t taken = parser_.feed(rest);
      rest = rest.subspan(taken);
      for (auto event = parser_.next(packet_); event != servo_bus::ParseEvent::none;
           event = parser_.next(packet_)) {
        if (event == servo_bus::ParseEvent::packet) {
          execute(packet_, chunk.end);
        } else if (BusDevice* device = find(packet_.id); device && device->listening()) {
          reply(*device, StatusError::crc_mismatch, {}, chunk.end);
        }
      }
      if (taken == 0) parser_.reset();
    }
  }
}

void BusSlave::execute(const Packet& packet, Nanoseconds now) {
  if (packet.is_status()) return;
  if (packet.id == servo_bus::kBroadcastId) {
    broadcast(packet, now);
    return;
  }
  BusDevice* device = find(packet.id);
  if (!device || !device->listening()) return;
  device->heard(now);
  single(*device, packet, now);
}

void BusSlave::single(BusDevice& device, const Packet& packet, Nanoseconds now) {
  const auto p = packet.parameters.view();
  const int level = device.status_return_level();
  switch (packet.instruction) {
    case Instruction::ping: {
      std::uint8_t data[3] = {0, 0, device.firmware()};
      servo_bus::put_le(data, 2, device.model());
      reply(device, StatusError::none, data, now);
      return;
    }
    case Instruction::read: {
      if (level < 1) return;
      if (p.size() != 4) {
        reply(device, StatusError::data_length, {}, now);
        return;
      }
      std::vector<std::uint8_t> data(servo_bus::get_u16(p.subspan(2)));
      const StatusError error = data.size() > servo_bus::kMaxParameters / 2
                                    ? StatusError::data_range
                                    : device.read(servo_bus::get_u16(p), data);
      reply(device, error, error == StatusError::none ? data : std::span<const std::uint8_t>{},
            now);
      return;
    }
    case Instruction::write:
    case Instruction::reg_write: {
      StatusError error = StatusError::data_length;
      if (p.size() > 2 && packet.instruction == Instruction::write) {
        error = device.write(servo_bus::get_u16(p), p.subspan(2), now);
      } else if (p.size() > 2) {
        const auto data = p.subspan(2);
        device.hold_write({servo_bus::get_u16(p), {data.begin(), data.end()}});
        error = StatusError::none;
      }
      if (level == 2) reply(device, error, {}, now);
      return;
    }
    case Instruction::action: {
      const StatusError error = device.run_held_write(now);
      if (level == 2) reply(device, error, {}, now);
      return;
    }
    case Instruction::reboot:
      if (level == 2) reply(device, StatusError::none, {}, now);
      device.reboot(now);
      return;
    default:
      if (level == 2) reply(device, StatusError::unknown_instruction, {}, now);
  }
}

void BusSlave::answer_ping(Nanoseconds now) {
  std::vector<BusDevice*> by_id = devices_;
  std::sort(by_id.begin(), by_id.end(), [](auto* a, auto* b) { return a->id() < b->id(); });
  Nanoseconds time = now;
  for (BusDevice* device : by_id) {
    if (!device->listening()) continue;
    std::uint8_t data[3] = {0, 0, device->firmware()};
    servo_bus::put_le(data, 2, device->model());
    time = reply(*device, StatusError::none, data, time);
  }
}

void BusSlave::sync_write(std::span<const std::uint8_t> p, Nanoseconds now) {
  if (p.size() < 4) return;
  const std::uint16_t address = servo_bus::get_u16(p), length = servo_bus::get_u16(p.subspan(2));
  if (length == 0 || (p.size() - 4) % (length + 1u) != 0) return;
  for (std::size_t i = 4; i < p.size(); i += length + 1u) {
    const BulkRange range{p[i], address, length};
    write_each({&range, 1}, p.subspan(i + 1, length), now);
  }
}

void BusSlave::bulk_write(std::span<const std::uint8_t> p, Nanoseconds now) {
  for (std::size_t i = 0; i + 5 <= p.size();) {
    const BulkRange range{p[i], servo_bus::get_u16(p.subspan(i + 1)),
                          servo_bus::get_u16(p.subspan(i + 3))};
    if (i + 5 + range.length > p.size()) return;
    write_each({&range, 1}, p.subspan(i + 5, range.length), now);
    i += 5u + range.length;
  }
}

void BusSlave::broadcast(const Packet& packet, Nanoseconds now) {
  const auto p = packet.parameters.view();
  switch (packet.instruction) {
    case Instruction::ping:
      return answer_ping(now);
    case Instruction::sync_read:
      return answer_reads(read_ranges(packet, true).view(), false, now);
    case Instruction::bulk_read:
      return answer_reads(read_ranges(packet, false).view(), false, now);
    case Instruction::fast_sync_read:
      return answer_reads(read_ranges(packet, true).view(), true, now);
    case Instruction::fast_bulk_read:
      return answer_reads(read_ranges(packet, false).view(), true, now);
    case Instruction::sync_write:
      return sync_write(p, now);
    case Instruction::bulk_write:
      return bulk_write(p, now);
    case Instruction::write:
      if (p.size() < 3) return;
      for (BusDevice* device : devices_) {
        if (device->listening()) device->write(servo_bus::get_u16(p), p.subspan(2), now);
      }
      return;
    case Instruction::action:
      for (BusDevice* device : devices_) {
        if (device->listening()) device->run_held_write(now);
      }
      return;
    case Instruction::reboot:
      for (BusDevice* device : devices_) {
        if (device->listening()) device->reboot(now);
      }
      return;
    default:
      return;
  }
}

void BusSlave::write_each(std::span<const BulkRange> ranges, std::span<const std::uint8_t> data,
                          Nanoseconds now) {
  for (const BulkRange& range : ranges) {
    BusDevice* device = find(range.id);
    if (!device || !device->listening()) continue;
    device->heard(now);
    device->write(range.address, data.first(range.length), now);
  }
}

/// Each device speaks when its predecessor has finished: a silent one ends the chain.
void BusSlave::answer_reads(std::span<const BulkRange> ranges, bool merged, Nanoseconds now) {
  for (const BulkRange& range : ranges) {
    if (BusDevice* device = find(range.id); device && device->listening()) device->heard(now);
  }
  if (merged) return answer_merged(ranges, now);
  Nanoseconds time = now;
  for (const BulkRange& range : ranges) {
    BusDevice* device = find(range.id);
    if (!device || !device->listening() || device->status_return_level() < 1) return;
    std::vector<std::uint8_t> data(
        std::min<std::size_t>(range.length, servo_bus::kMaxParameters / 2));
    const StatusError error = device->read(range.address, data);
    zero_if_struck(device->id(), data, time);
    time = reply(*device, error,
                 error == StatusError::none ? data : std::span<const std::uint8_t>{}, time);
  }
}

void BusSlave::answer_merged(std::span<const BulkRange> ranges, Nanoseconds now) {
  std::size_t length = 1;
  for (const BulkRange& range : ranges) length += range.length + 4u;
  PacketBuffer frame;
  servo_bus::FastStatusWriter writer;
  if (ranges.empty() || length > servo_bus::kMaxPacketBytes ||
      writer.begin(frame, length) != Status::ok)
    return;
  Nanoseconds time = now;
  std::size_t sent = 0;
  for (const BulkRange& range : ranges) {
    BusDevice* device = find(range.id);
    if (!device || !device->listening() || !device->knows_fast_read()) break;
    std::vector<std::uint8_t> data(range.length);
    const StatusError error = device->read(range.address, data);
    zero_if_struck(device->id(), data, time);
    writer.append(frame, device->id(), error_byte(*device, error), data);
    if (sent == 0) time += device->return_delay();
    const auto block = frame.view().subspan(sent);
    time = put_on_line({device->id(), {block.begin(), block.end()}}, time);
    sent = frame.size();
  }
}

std::uint8_t BusSlave::error_byte(const BusDevice& device, StatusError error) {
  return static_cast<std::uint8_t>(static_cast<std::uint8_t>(error) |
                                   (device.alert() ? servo_bus::kAlertBit : 0));
}

Nanoseconds BusSlave::reply(const BusDevice& device, StatusError error,
                            std::span<const std::uint8_t> data, Nanoseconds start) {
  PacketBuffer frame;
  if (servo_bus::encode_status(frame, device.id(), error_byte(device, error), data) != Status::ok)
    return start;
  return put_on_line({device.id(), {frame.begin(), frame.end()}}, start + device.return_delay());
}

const Fault* BusSlave::strikes(FaultKind kind, int id, Nanoseconds now) {
  const Fault* fault = faults_.active(kind, id, now);
  return fault && (fault->probability >= 1.0 || random_.chance(fault->probability)) ? fault
                                                                                    : nullptr;
}

void BusSlave::zero_if_struck(int id, std::vector<std::uint8_t>& data, Nanoseconds now) {
  if (strikes(FaultKind::reply_zeros, id, now))
    std::fill(data.begin(), data.end(), std::uint8_t{0});
}

/// A ping of somebody who does not listen first, ten times a second.
void BusSlave::let_foreigner_speak(Nanoseconds now) {
  constexpr Nanoseconds kPause = 100 * kMillisecond;
  if (!faults_.active(FaultKind::foreign_master, 0, now) || now - foreigner_spoke_ < kPause) return;
  foreigner_spoke_ = now;
  PacketBuffer ping;
  (void)servo_bus::encode_ping(ping, 251);
  for (const std::uint8_t value : ping) outgoing_.push_back({now += byte_time_, value});
}

Nanoseconds BusSlave::put_on_line(Reply reply, Nanoseconds start) {
  const auto struck = [&](FaultKind kind) { return strikes(kind, reply.id, start); };
  auto& bytes = reply.bytes;
  const Nanoseconds undisturbed_end = start + static_cast<Nanoseconds>(bytes.size()) * byte_time_;
  if (struck(FaultKind::bus_drop)) return undisturbed_end;  // the others on the bus have heard it
  if (const Fault* fault = struck(FaultKind::bus_delay)) {
    start += from_seconds(fault->amount > 0 ? fault->amount : 0.001);
  }
  if (struck(FaultKind::bus_corrupt)) {
    bytes[random_.bits() % bytes.size()] ^= static_cast<std::uint8_t>(1u << (random_.bits() % 8));
  }
  if (struck(FaultKind::bus_truncate)) bytes.resize(bytes.size() / 2);
  if (struck(FaultKind::bus_duplicate)) {
    const auto copy = bytes;
    bytes.insert(bytes.end(), copy.begin(), copy.end());
  }
  if (const Fault* fault = struck(FaultKind::bus_garbage)) {
    const auto count = static_cast<std::size_t>(fault->amount > 0 ? fault->amount : 8);
    for (std::size_t i = 0; i < count; ++i)
      bytes.insert(bytes.begin(), static_cast<std::uint8_t>(random_.bits()));
  }
  for (const std::uint8_t value : bytes) {
    start += byte_time_;
    outgoing_.push_back({start, value});
  }
  return start;
}

std::size_t BusSlave::transmit(std::span<std::uint8_t> out, Nanoseconds now) {
  std::size_t count = 0;
  while (count < out.size() && !outgoing_.empty() && outgoing_.front().time <= now) {
    out[count++] = outgoing_.front().value;
    outgoing_.pop_front();
  }
  return count;
}

}  // namespace sanso::emulator
