// Three commands at the start, asked again after a second of silence; every data packet becomes a
// sample.
#include "firmware/imu/mip_reader.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sanso::firmware {
namespace {

constexpr std::uint8_t kBase = 0x01, k3dm = 0x0C;
constexpr std::uint8_t kIdle = 0x02, kFormat = 0x08, kStream = 0x11;
constexpr double kBaseRate_hz = 1000.0;
constexpr int kMaxReads = 16;
constexpr Nanoseconds kAskAgain = kSecond;  // silent for so long: the sensor was perhaps off

/// Half a turn about x: forward-right-down to forward-left-up, for bodies and for worlds.
const math::Quat& half_turn() {
  static const math::Quat quat(0.0, 1.0, 0.0, 0.0);
  return quat;
}
math::Vec3 up_from_down(const math::Vec3& v) { return {v[0], -v[1], -v[2]}; }

}  // namespace

/// Idle, one message format, stream on. Commands as the maker writes them: length, command, data.
Status MipReader::start() {
  const auto every = static_cast<std::uint8_t>(
      std::clamp(std::lround(settings_.period_s * kBaseRate_hz), 2L, 10L));
  const std::array<std::uint8_t, 2> idle{2, kIdle};
  const std::array<std::uint8_t, 13> format{13,   kFormat, 1,     3,    0x04, 0,    every,
                                            0x05, 0,       every, 0x0A, 0,    every};
  const std::array<std::uint8_t, 5> stream{5, kStream, 1, 1, 1};
  std::array<std::uint8_t, 32> packet;
  const auto send = [&](std::uint8_t set, std::span<const std::uint8_t> payload) {
    const std::size_t n = make_mip_packet(set, payload, packet);
    return port_.write(std::span(packet).first(n));
  };
  for (const Status status : {send(kBase, idle), send(k3dm, format), send(k3dm, stream)})
    if (status != Status::ok) return status;
  heard_ = clock_.now();
  started_ = true;
  return Status::ok;
}

Status MipReader::poll(Nanoseconds deadline) {
  if (started_ && clock_.now() - heard_ > kAskAgain) started_ = false;
  if (!started_)
    if (const Status status = start(); status != Status::ok) return status;
  std::array<std::uint8_t, 256> bytes;
  for (int i = 0; i < kMaxReads; ++i) {
    const Result<std::size_t> n = port_.read(bytes, i == 0 ? deadline : 0);
    if (!n.ok()) {
      started_ = false;
      return n.status();
    }
    if (*n == 0) break;
    parser_.feed(std::span(bytes).first(*n), [&](const MipSample& s) { take(s); });
  }
  return Status::ok;
}

void MipReader::take(const MipSample& sample) {
  if (!sample.accel || !sample.gyro) return;
  heard_ = clock_.now();
  std::optional<math::Quat> quat;
  // The device's quaternion turns components of the navigation frame into those of the body; ours
  // turns body into world. Both frames are turned upside down.
  if (sample.quat && std::abs(sample.quat->norm() - 1.0) < 0.05) {
    const math::Quat ned_body = math::quat_conjugate(math::quat_normalized(*sample.quat));
    quat = math::quat_multiply(math::quat_multiply(half_turn(), ned_body),
                               math::quat_conjugate(half_turn()));
  }
  assembler_.publish(heard_, up_from_down(*sample.gyro), up_from_down(*sample.accel), quat);
}

}  // namespace sanso::firmware
