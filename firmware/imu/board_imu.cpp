// Counts to SI and board axes to base axes; the rest is the assembler's.
#include "firmware/imu/board_imu.h"

#include "shared/servo_bus/opencr.h"

namespace sanso::firmware {
namespace {

constexpr double kRadPerDegree = 3.14159265358979323846 / 180.0;

/// The board lies turned by half a turn about z: the maker's own driver negates x and y.
math::Vec3 base_from_board(const std::array<std::int16_t, 3>& raw, double scale) {
  return {-scale * raw[0], -scale * raw[1], scale * raw[2]};
}

}  // namespace

void BoardImu::take(Nanoseconds now, const BoardReading& reading) {
  namespace opencr = servo_bus::opencr;
  const double rate = kRadPerDegree / opencr::kGyroCountsPerDegPerSecond;
  const double force = kStandardGravity / opencr::kAccelCountsPerG;
  assembler_.publish(now, base_from_board(reading.gyro_raw, rate),
                     base_from_board(reading.accel_raw, force), std::nullopt);
}

}  // namespace sanso::firmware
