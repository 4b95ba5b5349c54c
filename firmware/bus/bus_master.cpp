// Requests and replies against a deadline. The only place where raw register values become
// radians, rad/s and amperes.
#include "firmware/bus/bus_master.h"

#include <algorithm>
#include <cmath>

#include "shared/servo_bus/opencr.h"
#include "shared/servo_bus/units.h"

namespace sanso::firmware {
namespace bus = servo_bus;
namespace {

// ping or register: under 50 bytes, plus USB latency
constexpr Nanoseconds kSingleTimeout = 4 * kMillisecond;
// a joint at its no-load speed turns 0.05 rad in a tick
constexpr double kMaxJump_rad = 0.5;
// one turn of the encoder, and a count for rounding
constexpr double kMaxAngle_rad = model::kPi + 0.01;
// silent for longer, a joint may be anywhere: its next reading is believed again. A servo that goes
// on saying what cannot be is not silent
constexpr std::uint16_t kForgottenTicks = 10;
// fewer than the silent ticks of F11, so that a robot that is put elsewhere raises nothing
constexpr std::uint8_t kSettledReads = 5;
// id, error and CRC around the data of one servo in a merged reply
constexpr std::size_t kBlockOverhead = 4;
// the line counts as free after this much silence; who still talks then is waited for no longer
constexpr Nanoseconds kQuiet = 300 * kMicrosecond, kPatience = 1500 * kMicrosecond;

/// Longest reply of `servos` servos with `bytes` each, stuffed in the worst case.
std::size_t reply_bytes(int servos, std::size_t bytes, bool merged) {
  const std::size_t plain = bus::kMinPacketBytes + bytes + 1;
  const std::size_t stuffed = plain + plain / 3;
  return merged ? bus::kMinPacketBytes + static_cast<std::size_t>(servos) * (bytes + kBlockOverhead)
                : stuffed;
}

}  // namespace

BusMaster::BusMaster(const BusSettings& settings, board::SerialPort& port, board::Clock& clock)
    : settings_(settings), port_(port), clock_(clock) {
  for (std::size_t s = 0; s < order_.size(); ++s) {
    order_[s] = static_cast<std::uint8_t>(s);
    offset_raw_[s] = static_cast<std::int32_t>(
        std::lround(settings.offset_rad[kServoIds[s] - 1u] / bus::kRadPerCount));
  }
}

// --- requests and replies ------------------------------------------------------------------------

/// Late replies and noise belong to no request: they must not be taken for an answer to the next
/// one.
void BusMaster::drain() {
  (void)take_what_came();
  parser_.reset();
}

BusMaster::Heard BusMaster::take_what_came() {
  std::array<std::uint8_t, 256> waste;
  Heard heard;
  for (int i = 0; i < 16; ++i) {
    const Result<std::size_t> n = port_.read(waste, 0);
    if (!n.ok() || *n == 0) break;
    counters_.noise_bytes += static_cast<std::uint32_t>(*n);
    heard.bytes += static_cast<int>(*n);
    heard.packets += look_for_foreigners(std::span(waste).first(*n));
  }
  return heard;
}

/// Only masters give instructions: one that is whole and not the echo of our own is another's.
/// How many whole packets of any kind there were.
int BusMaster::look_for_foreigners(std::span<const std::uint8_t> bytes) {
  int packets = 0;
  while (!bytes.empty()) {
    const std::size_t taken = parser_.feed(bytes);
    bytes = bytes.subspan(taken);
    for (bus::ParseEvent event = parser_.next(packet_); event != bus::ParseEvent::none;
         event = parser_.next(packet_)) {
      count_foreigner(event);
      if (event == bus::ParseEvent::packet) ++packets;
    }
    if (taken == 0) parser_.reset();
  }
  return packets;
}

void BusMaster::count_foreigner(bus::ParseEvent event) {
  if (event != bus::ParseEvent::packet || packet_.is_status()) return;
  if (!std::ranges::equal(parser_.frame(), request_.view())) ++counters_.foreign;
}

/// Nothing is thrown away: a packet may come in two pieces.
BusMaster::Heard BusMaster::listen() { return take_what_came(); }

/// A request into a late reply destroys both: waits for the line to fall silent, not for long.
void BusMaster::let_line_fall_silent() {
  if (!overdue_) return;
  overdue_ = false;
  std::array<std::uint8_t, 256> waste;
  const Nanoseconds give_up = clock_.now() + kPatience;
  while (clock_.now() < give_up) {
    const Result<std::size_t> n = port_.read(waste, std::min(give_up, clock_.now() + kQuiet));
    if (!n.ok() || *n == 0) return;
    counters_.noise_bytes += static_cast<std::uint32_t>(*n);
  }
}

Status BusMaster::send(Nanoseconds timeout, std::size_t longest_reply) {
  drain();
  raw_.clear();
  // an adapter may echo the request
  parser_.set_max_frame(std::max(longest_reply, request_.size()));
  const Status status = write_request();
  deadline_ =
      clock_.now() +
      bus::wire_time_ns(request_.size(), static_cast<std::int64_t>(settings_.byte_rate_baud)) +
      timeout;
  return status;
}

Status BusMaster::write_request() {
  const Status status = port_.write(request_.view());
  if (status != Status::ok) ++counters_.unsent;
  return status;
}

/// Feeds arriving bytes to the parser until `on_packet` says done or the deadline passes.
template <class OnPacket>
Status BusMaster::collect(OnPacket&& on_packet) {
  std::array<std::uint8_t, 512> chunk;
  for (;;) {
    const Result<std::size_t> n = port_.read(chunk, deadline_);
    if (!n.ok()) return n.status();
    if (*n == 0) return Status::timeout;
    // bytes that never end must not hold the tick
    const bool last = clock_.now() > deadline_;
    std::span<const std::uint8_t> bytes(chunk.data(), *n);
    (void)raw_.try_append(bytes);
    while (!bytes.empty()) {
      const std::size_t taken = parser_.feed(bytes);
      bytes = bytes.subspan(taken);
      for (;;) {
        const bus::ParseEvent event = parser_.next(packet_);
        if (event == bus::ParseEvent::none) break;
        if (event == bus::ParseEvent::crc_error) ++counters_.corrupt;
        count_foreigner(event);
        if (on_packet(event) == Wait::done) return Status::ok;
      }
      if (taken == 0) parser_.reset();  // a full buffer without a packet is noise
    }
    if (last) return Status::timeout;
  }
}

Status BusMaster::transact(std::uint8_t id) {
  constexpr int kLongest = 32;  // bytes of data of any single reply
  if (const Status sent = send(kSingleTimeout, reply_bytes(1, kLongest, false)); sent != Status::ok)
    return sent;
  const Status status = collect([&](bus::ParseEvent event) {
    const bool answer = event == bus::ParseEvent::packet && packet_.is_status() && packet_.id == id;
    return answer ? Wait::done : Wait::more;  // anything else is an echo, a late reply or noise
  });
  overdue_ = status == Status::timeout;
  return status;
}

// --- reads of many servos ------------------------------------------------------------------------

/// The merged reply, from the raw bytes: every block has its own CRC, so a reply that is damaged or
/// cut short still gives the servos before the damage.
template <class OnBlock>
void BusMaster::take_fast_reply(int slots, std::size_t bytes, OnBlock&& on_block) {
  constexpr std::array<std::uint8_t, 5> kHeader = {0xFF, 0xFF, 0xFD, 0x00, bus::kBroadcastId};
  const auto begin = std::search(raw_.begin(), raw_.end(), kHeader.begin(), kHeader.end());
  bus::FastReplyReader reader({begin, raw_.end()});
  for (int block = 0; block < slots; ++block) {
    const Result<bus::FastBlock> reply = reader.next(bytes);
    if (!reply.ok()) return;
    const int slot = slot_of(reply->id);
    if (slot >= 0 && slot < slots) on_block(slot, reply->error, reply->data);
  }
}

/// Asks the first `slots` servos for `bytes` from `address` on; on_block(slot, error, data) for
/// each that answers.
template <class OnBlock>
Status BusMaster::read_many(int slots, std::uint16_t address, std::uint16_t bytes,
                            OnBlock&& on_block) {
  std::array<std::uint8_t, kNumServos> ids;
  int count = 0;
  for (const std::uint8_t slot : order_)
    if (slot < slots) ids[static_cast<std::size_t>(count++)] = kServoIds[slot];
  const std::span<const std::uint8_t> asked(ids.data(), static_cast<std::size_t>(count));
  if (fast_)
    (void)bus::encode_fast_sync_read(request_, address, bytes, asked);
  else
    (void)bus::encode_sync_read(request_, address, bytes, asked);
  Status status = send(from_seconds(settings_.reply_timeout_s), reply_bytes(slots, bytes, fast_));
  if (status != Status::ok) return status;
  int answered = 0;
  status = collect([&](bus::ParseEvent event) {
    if (fast_ && packet_.id == bus::kBroadcastId && packet_.is_status()) return Wait::done;
    const int slot = slot_of(packet_.id);
    const bool reply = event == bus::ParseEvent::packet && packet_.is_status();
    if (reply && slot >= 0 && slot < slots) {
      on_block(slot, packet_.error, packet_.parameters.view());
      ++answered;
    }
    return answered == slots ? Wait::done : Wait::more;
  });
  overdue_ = status == Status::timeout;
  if (fast_) take_fast_reply(slots, bytes, on_block);
  return status;
}

int BusMaster::read_block(std::uint16_t address, std::uint16_t bytes, ServoBlocks& blocks) {
  blocks.got.fill(false);
  int answered = 0;
  (void)read_many(kNumServos, address, bytes,
                  [&](int slot, std::uint8_t error, std::span<const std::uint8_t> data) {
                    const auto s = static_cast<std::size_t>(slot);
                    const bool good = (error & ~bus::kAlertBit) == 0 && data.size() == bytes &&
                                      bytes <= ServoBlocks::kMaxBytes;
                    if (!good || blocks.got[s]) return;
                    std::copy(data.begin(), data.end(), blocks.data[s].begin());
                    blocks.got[s] = true;
                    ++answered;
                  });
  return answered;
}

// --- cyclic read ---------------------------------------------------------------------------------

/// Whether this reading is too far from the last good one to be believed.
bool BusMaster::jumped(std::size_t s, double position_rad, const ServoReading& last) {
  if (!last.known || silent_ticks_[s] >= kForgottenTicks ||
      std::abs(position_rad - last.position_rad) <= kMaxJump_rad)
    return false;
  silent_ticks_[s] = 0;
  const bool agrees = settled_[s] > 0 && std::abs(position_rad - refused_rad_[s]) <= kMaxJump_rad;
  if (!agrees) settled_[s] = 0;
  if (settled_[s] < kSettledReads) ++settled_[s];
  refused_rad_[s] = position_rad;
  return torque_expected_ || settled_[s] < kSettledReads;
}

void BusMaster::store(int slot, std::uint8_t error, std::span<const std::uint8_t> data,
                      ServoReadings& readings) {
  const auto s = static_cast<std::size_t>(slot);
  ServoReading& reading = readings.servo[s];
  reading.alert = (error & bus::kAlertBit) != 0;
  // a status without data happens; its error byte still counts
  if (data.size() < bus::xm430::kFeedbackBytes || got_[s]) return;
  const bus::xm430::Feedback raw = bus::xm430::decode_feedback(data);
  const std::int32_t position_raw = joint_raw(slot, raw.position_raw);
  const double position_rad = bus::position_rad(position_raw);
  const bool refused = (error & ~bus::kAlertBit) != 0;
  if (refused || std::abs(position_rad) > kMaxAngle_rad || jumped(s, position_rad, reading)) {
    ++counters_.implausible;
    return;
  }
  reading.position_raw = position_raw;
  reading.current_raw = raw.current_raw;
  reading.position_rad = position_rad;
  reading.velocity_rad_s = bus::velocity_rad_s(raw.velocity_raw);
  reading.known = true;
  settled_[s] = 0;
  reading.age_ticks = silent_ticks_[s] = 0;
  ++readings.answered;
  got_[s] = true;
}

void BusMaster::read_feedback(int slots, ServoReadings& readings) {
  readings.asked = slots;
  readings.answered = 0;
  got_.fill(false);
  const Status status =
      read_many(slots, bus::xm430::kFeedbackAddress, bus::xm430::kFeedbackBytes,
                [&](int slot, std::uint8_t error, std::span<const std::uint8_t> data) {
                  store(slot, error, data, readings);
                });
  readings.port_gone = status == Status::io_error;
  age_the_silent(slots, readings);
  if (readings.answered < slots && !readings.port_gone) order_silent_last(slots);
}

void BusMaster::age_the_silent(int slots, ServoReadings& readings) {
  for (int s = 0; s < kNumServos; ++s) {
    if (got_[static_cast<std::size_t>(s)]) continue;
    ServoReading& reading = readings.servo[static_cast<std::size_t>(s)];
    std::uint16_t& silent = silent_ticks_[static_cast<std::size_t>(s)];
    if (silent < 0xffff) ++silent;
    if (reading.age_ticks < 0xffff) ++reading.age_ticks;
    if (s >= slots) continue;  // not asked
    ++counters_.lost;
    ++counters_.lost_by_servo[static_cast<std::size_t>(s)];
  }
}

/// A servo that stays silent blocks those asked after it: ask it last from now on.
void BusMaster::order_silent_last(int slots) {
  // The first silent one in the order is the suspect; the others may only have been behind it. When
  // nobody answers, that is the very first: either it is the only dead one, or it does not matter.
  const auto suspect = std::find_if(order_.begin(), order_.end(),
                                    [&](std::uint8_t s) { return s < slots && !got_[s]; });
  if (suspect != order_.end()) std::rotate(suspect, suspect + 1, order_.end());
}

// --- goals, torque -------------------------------------------------------------------------------

Status BusMaster::write_each(std::uint16_t address, std::uint8_t size,
                             std::span<const std::int32_t> values_raw) {
  std::array<std::uint8_t, 4 * kNumServos> data;
  for (std::size_t s = 0; s < values_raw.size(); ++s)
    bus::put_le(data.data() + size * s, size, values_raw[s]);
  (void)bus::encode_sync_write(request_, address, size,
                               std::span(kServoIds).first(values_raw.size()),
                               std::span(data).first(size * values_raw.size()));
  let_line_fall_silent();
  return write_request();
}

Status BusMaster::write_goals(std::span<const std::int32_t> goals_raw) {
  std::array<std::int32_t, kNumServos> servos_raw{};
  for (std::size_t s = 0; s < goals_raw.size(); ++s)
    servos_raw[s] = servo_raw(static_cast<int>(s), goals_raw[s]);
  return write_each(bus::xm430::kGoalPosition.address, 4,
                    std::span(servos_raw).first(goals_raw.size()));
}

Status BusMaster::write_torque(bool on, ServoReadings& readings) {
  std::array<std::int32_t, kNumServos> values;
  values.fill(on ? 1 : 0);
  for (ServoHealth& health : readings.health) health.torque_known = false;
  return write_each(bus::xm430::kTorqueEnable.address, 1, values);
}

}  // namespace sanso::firmware
