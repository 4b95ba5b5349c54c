// Answers inside write(), from register images; no heap after construction.
#include "tools/bench/instant_bus.h"

#include <algorithm>
#include <ctime>

#include "shared/servo_bus/opencr.h"
#include "shared/servo_bus/xm430.h"

namespace sanso::bench {
namespace bus = servo_bus;
namespace {

class Stopwatch {
 public:
  explicit Stopwatch(Nanoseconds& total) : total_(total), begin_(thread_cpu()) {}
  ~Stopwatch() { total_ += thread_cpu() - begin_; }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  Nanoseconds& total_;
  Nanoseconds begin_;
};

}  // namespace

Nanoseconds thread_cpu() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<Nanoseconds>(t.tv_sec) * kSecond + t.tv_nsec;
}

InstantBus::InstantBus() {
  for (int slot = 0; slot < firmware::kNumServos; ++slot) {
    for (const bus::Register& r : bus::xm430::kRegisters)
      if (r.address + r.size <= kTable)
        bus::put_le(&table_[static_cast<std::size_t>(slot)][r.address], r.size, r.initial_raw);
    poke(slot, 6, 1, bus::xm430::kFirmwareWithFastRead);
    poke(slot, 9, 1, 1);  // return delay, as the maker sets up an OP3
    poke(slot, 132, 4, 2048);
    poke(slot, 144, 2, 120);
    poke(slot, 146, 1, 35);
  }
}

void InstantBus::poke(int slot, std::uint16_t address, std::uint8_t size, std::int32_t value) {
  bus::put_le(&table_[static_cast<std::size_t>(slot)][address], size, value);
}

std::int32_t InstantBus::get(int slot, std::uint16_t address, std::uint8_t size) const {
  std::uint32_t value = 0;
  for (std::size_t i = size; i-- > 0;)
    value = (value << 8) | table_[static_cast<std::size_t>(slot)][address + i];
  return static_cast<std::int32_t>(value);
}

int InstantBus::row_of(std::uint8_t id) const {
  return id == bus::opencr::kId ? kOpenCr : firmware::slot_of(id);
}

/// A servo without friction or delay: with torque on it is where it is told to be.
void InstantBus::wrote(int slot) {
  if (slot < kOpenCr && torque_on(slot)) poke(slot, 132, 4, goal_raw(slot));
}

Status InstantBus::write(board::Bytes data) {
  const Stopwatch stopwatch(cpu_ns_);
  parser_.feed(data);
  while (parser_.next(packet_) == bus::ParseEvent::packet) answer(packet_);
  return Status::ok;
}

Result<std::size_t> InstantBus::read(board::Buffer buffer, Nanoseconds) {
  const Stopwatch stopwatch(cpu_ns_);
  const std::size_t n = std::min(buffer.size(), pending_.size() - taken_);
  std::copy_n(pending_.begin() + taken_, n, buffer.begin());
  taken_ += n;
  if (taken_ == pending_.size()) {
    pending_.clear();
    taken_ = 0;
  }
  return n;
}

void InstantBus::reply(int row, std::span<const std::uint8_t> data) {
  const std::uint8_t id =
      row == kOpenCr ? bus::opencr::kId : firmware::kServoIds[static_cast<std::size_t>(row)];
  const bool alert = row < kOpenCr && table_[static_cast<std::size_t>(row)][70] != 0;
  (void)bus::encode_status(out_, id, alert ? bus::kAlertBit : 0, data);
  (void)pending_.try_append(out_.view());
}

void InstantBus::answer(const bus::Packet& packet) {
  const auto p = packet.parameters.view();
  switch (packet.instruction) {
    case bus::Instruction::sync_read:
      return read_many(packet, false);
    case bus::Instruction::fast_sync_read:
      return read_many(packet, true);
    case bus::Instruction::sync_write:
      return write_many(packet);
    default:
      break;
  }
  const int row = row_of(packet.id);
  if (row < 0 || silent(row)) return;
  Table& table = table_[static_cast<std::size_t>(row)];
  switch (packet.instruction) {
    case bus::Instruction::ping: {
      const std::array<std::uint8_t, 3> identity{table[0], table[1], table[6]};
      return reply(row, identity);
    }
    case bus::Instruction::read:
      if (p.size() == 4 && bus::get_u16(p) + bus::get_u16(p.subspan(2)) <= static_cast<int>(kTable))
        reply(row, std::span(table).subspan(bus::get_u16(p), bus::get_u16(p.subspan(2))));
      return;
    case bus::Instruction::write:
      if (p.size() > 2 && bus::get_u16(p) + p.size() - 2 <= kTable) {
        std::copy(p.begin() + 2, p.end(), table.begin() + bus::get_u16(p));
        wrote(row);
        reply(row, {});
      }
      return;
    default:
      return;
  }
}

void InstantBus::read_many(const bus::Packet& packet, bool merged) {
  const auto p = packet.parameters.view();
  const std::size_t address = bus::get_u16(p), length = bus::get_u16(p.subspan(2));
  const auto ids = p.subspan(4);
  bus::FastStatusWriter writer;
  if (merged) (void)writer.begin(out_, 1 + ids.size() * (length + 4));
  for (const std::uint8_t id : ids) {
    const int row = row_of(id);
    if (row < 0 || silent(row)) break;  // those behind wait for it in vain
    const auto data = std::span<const std::uint8_t>(table_[static_cast<std::size_t>(row)])
                          .subspan(address, length);
    if (merged)
      (void)writer.append(
          out_, id, table_[static_cast<std::size_t>(row)][70] != 0 ? bus::kAlertBit : 0, data);
    else
      reply(row, data);
  }
  if (merged) (void)pending_.try_append(out_.view());
}

void InstantBus::write_many(const bus::Packet& packet) {
  const auto p = packet.parameters.view();
  const std::size_t address = bus::get_u16(p), length = bus::get_u16(p.subspan(2));
  for (auto rest = p.subspan(4); rest.size() > length; rest = rest.subspan(length + 1)) {
    const int row = row_of(rest[0]);
    if (row < 0 || silent(row)) continue;
    std::copy_n(
        rest.begin() + 1, length,
        table_[static_cast<std::size_t>(row)].begin() + static_cast<std::ptrdiff_t>(address));
    wrote(row);
  }
}

}  // namespace sanso::bench
