// The far end of the servo bus in virtual time: bytes in, the devices' replies out, each byte at
// the moment at which it would be on the wire. Half-duplex: who talks while a reply is under way
// destroys both.
#pragma once

#include <deque>
#include <span>
#include <vector>

#include "shared/servo_bus/encode.h"
#include "shared/servo_bus/parser.h"
#include "tools/emulator/bus_device.h"
#include "tools/emulator/fault_plan.h"
#include "tools/plant/random.h"

namespace sanso::emulator {

/// What a bulk instruction asks of one device.
struct BulkRange {
  std::uint8_t id = 0;
  std::uint16_t address = 0;
  std::uint16_t length = 0;
};

class BusSlave {
 public:
  /// Devices and faults are the caller's and must outlive this.
  BusSlave(std::vector<BusDevice*> devices, const FaultPlan& faults, std::int64_t baud,
           std::uint64_t seed);

  /// The master's speed from now on.
  void set_baud(std::int64_t baud) { byte_time_ = servo_bus::wire_time_ns(1, baud); }
  /// The master puts bytes on the line at `now`.
  void receive(std::span<const std::uint8_t> bytes, Nanoseconds now);
  /// When the next instruction bytes have arrived completely; INT64_MAX when none are under way.
  Nanoseconds next_event() const { return incoming_.empty() ? INT64_MAX : incoming_.front().end; }
  /// Lets the devices act on everything that has arrived by `now`.
  void run(Nanoseconds now);

  /// Reply bytes on the master's side by `now`.
  std::size_t transmit(std::span<std::uint8_t> out, Nanoseconds now);
  Nanoseconds next_byte() const { return outgoing_.empty() ? INT64_MAX : outgoing_.front().time; }

 private:
  struct Incoming {
    Nanoseconds end = 0;
    std::vector<std::uint8_t> bytes;
  };
  struct TimedByte {
    Nanoseconds time = 0;
    std::uint8_t value = 0;
  };
  /// A reply as it is built: bytes of one device (or of its block in a merged reply).
  struct Reply {
    int id = 0;
    std::vector<std::uint8_t> bytes;
  };

  void execute(const servo_bus::Packet& packet, Nanoseconds now);
  void single(BusDevice& device, const servo_bus::Packet& packet, Nanoseconds now);
  void broadcast(const servo_bus::Packet& packet, Nanoseconds now);
  void answer_ping(Nanoseconds now);
  void sync_write(std::span<const std::uint8_t> parameters, Nanoseconds now);
  void bulk_write(std::span<const std::uint8_t> parameters, Nanoseconds now);
  void answer_reads(std::span<const BulkRange> ranges, bool merged, Nanoseconds now);
  void answer_merged(std::span<const BulkRange> ranges, Nanoseconds now);
  void write_each(std::span<const BulkRange> ranges, std::span<const std::uint8_t> data,
                  Nanoseconds now);
  /// Sends one device's status; returns when its last byte has left.
  Nanoseconds reply(const BusDevice& device, servo_bus::StatusError error,
                    std::span<const std::uint8_t> data, Nanoseconds start);
  /// Puts bytes on the line with whatever the fault plan does to them; returns the end.
  Nanoseconds put_on_line(Reply reply, Nanoseconds start);
  BusDevice* find(int id);
  /// The fault, when it is active at this device and strikes this time.
  const Fault* strikes(FaultKind kind, int id, Nanoseconds now);
  void zero_if_struck(int id, std::vector<std::uint8_t>& data, Nanoseconds now);
  void let_foreigner_speak(Nanoseconds now);
  static std::uint8_t error_byte(const BusDevice& device, servo_bus::StatusError error);

  std::vector<BusDevice*> devices_;
  const FaultPlan& faults_;
  Nanoseconds byte_time_;
  plant::Random random_;
  servo_bus::PacketParser parser_;
  servo_bus::Packet packet_;
  std::deque<Incoming> incoming_;
  std::deque<TimedByte> outgoing_;
  Nanoseconds last_arrival_ = 0;
  Nanoseconds foreigner_spoke_ = 0;
};

}  // namespace sanso::emulator
