// Looks for the two sync bytes, trusts a packet only with its checksum, and after damage looks
// again from the next byte on.
#include "firmware/imu/mip_parser.h"

#include <algorithm>
#include <bit>

#include "firmware/exchange/samples.h"

namespace sanso::firmware {
namespace {

constexpr std::uint8_t kSync1 = 0x75, kSync2 = 0x65;
constexpr std::uint8_t kSensorSet = 0x80;
constexpr std::uint8_t kScaledAccel = 0x04, kScaledGyro = 0x05, kQuaternionField = 0x0A;

/// Fletcher's sums over all bytes before them.
std::uint16_t checksum(std::span<const std::uint8_t> bytes) {
  std::uint8_t a = 0, b = 0;
  for (const std::uint8_t byte : bytes) {
    a = static_cast<std::uint8_t>(a + byte);
    b = static_cast<std::uint8_t>(b + a);
  }
  return static_cast<std::uint16_t>(a << 8 | b);
}

/// Big-endian IEEE single number `index` of a field.
double number(std::span<const std::uint8_t> data, std::size_t index) {
  std::uint32_t bits = 0;
  for (std::size_t i = 0; i < 4; ++i) bits = bits << 8 | data[4 * index + i];
  return static_cast<double>(std::bit_cast<float>(bits));
}

math::Vec3 vector(std::span<const std::uint8_t> data) {
  return {number(data, 0), number(data, 1), number(data, 2)};
}

}  // namespace

void MipParser::drop(std::size_t count) {
  std::copy(buffer_.begin() + count, buffer_.end(), buffer_.begin());
  (void)buffer_.try_resize(buffer_.size() - count);
}

bool MipParser::cut_packet() {
  for (;;) {
    std::size_t start = 0;
    const auto begins = [&](std::size_t i) {
      return buffer_[i] == kSync1 && (i + 1 == buffer_.size() || buffer_[i + 1] == kSync2);
    };
    while (start < buffer_.size() && !begins(start)) ++start;
    if (start > 0) drop(start);
    if (buffer_.size() < kHeader || buffer_.size() < packet_size()) return false;
    const auto packet = buffer_.view().first(packet_size());
    const auto sums = packet.last(kChecksum);
    if (checksum(packet.first(packet.size() - kChecksum)) == (sums[0] << 8 | sums[1])) return true;
    ++bad_packets_;
    drop(1);  // perhaps a packet begins inside this one
  }
}

bool MipParser::packet_is_data() const { return buffer_[2] == kSensorSet; }

MipSample MipParser::decode() const {
  MipSample sample;
  auto fields = buffer_.view().subspan(kHeader, buffer_[3]);
  while (fields.size() >= 2 && fields[0] >= 2 && fields[0] <= fields.size()) {
    const auto data = fields.subspan(2, fields[0] - 2u);
    if (fields[1] == kScaledAccel && data.size() == 12)
      sample.accel = kStandardGravity * vector(data);
    else if (fields[1] == kScaledGyro && data.size() == 12)
      sample.gyro = vector(data);
    else if (fields[1] == kQuaternionField && data.size() == 16)
      sample.quat = math::Quat(number(data, 0), number(data, 1), number(data, 2), number(data, 3));
    fields = fields.subspan(fields[0]);
  }
  return sample;
}

std::size_t make_mip_packet(std::uint8_t descriptor_set, std::span<const std::uint8_t> payload,
                            std::span<std::uint8_t> out) {
  const std::size_t size = 4 + payload.size() + 2;
  if (out.size() < size || payload.size() > 255) return 0;
  out[0] = kSync1;
  out[1] = kSync2;
  out[2] = descriptor_set;
  out[3] = static_cast<std::uint8_t>(payload.size());
  std::copy(payload.begin(), payload.end(), out.begin() + 4);
  const std::uint16_t sums = checksum(out.first(size - 2));
  out[size - 2] = static_cast<std::uint8_t>(sums >> 8);
  out[size - 1] = static_cast<std::uint8_t>(sums & 0xFF);
  return size;
}

}  // namespace sanso::firmware
