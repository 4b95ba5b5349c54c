// Three stages, each left only when all twenty servos have confirmed it; see the header.
#include "firmware/app/arming.h"

#include <algorithm>
#include <cmath>

#include "shared/servo_bus/units.h"

namespace sanso::firmware {
namespace {

namespace xm430 = servo_bus::xm430;
constexpr int kTries = 20;  // ticks of a stage
// a joint that has been moved this far since its goal was set gets a new one
constexpr double kMoved_rad = 0.05;
constexpr std::uint16_t kGoalAddress = xm430::kGoalPwm.address;
constexpr std::uint16_t kGoalBytes = xm430::kGoalPosition.address + 4 - kGoalAddress;
static_assert(kGoalBytes <= ServoBlocks::kMaxBytes);

bool fresh(const ServoReadings& servos) {
  return std::ranges::all_of(servos.servo, [](const ServoReading& r) { return r.age_ticks == 0; });
}

}  // namespace

void Arming::begin() {
  stage_ = Stage::goals;
  tries_ = 0;
  torque_written_ = false;
  refusal_ = Refusal::none;
}

Arming::Progress Arming::again(Refusal why) {
  if (++tries_ < kTries) return Progress::busy;
  refusal_ = why;
  stage_ = Stage::none;
  return Progress::failed;
}

bool Arming::moved(const ServoReadings& servos) const {
  for (std::size_t s = 0; s < kNumServos; ++s)
    if (std::abs(servos.servo[s].position_rad - servo_bus::position_rad(goals_raw_[s])) >
        kMoved_rad)
      return true;
  return false;
}

Arming::Progress Arming::step(BusMaster& bus, ServoReadings& servos, const Duties& duties_raw) {
  switch (stage_) {
    case Stage::goals:
      return write_goals(bus, servos, duties_raw);
    case Stage::torque:
      return write_torque(bus, servos);
    case Stage::settle:
    case Stage::none:
      break;
  }
  stage_ = Stage::none;
  return Progress::done;
}

Arming::Progress Arming::write_goals(BusMaster& bus, const ServoReadings& servos,
                                     const Duties& duties_raw) {
  if (!fresh(servos)) return again(Refusal::servo_not_fresh);
  for (std::size_t s = 0; s < kNumServos; ++s) goals_raw_[s] = servos.servo[s].position_raw;
  (void)bus.write_each(xm430::kGoalPwm.address, 2, duties_raw);
  (void)bus.write_goals(goals_raw_);
  if (bus.read_block(kGoalAddress, kGoalBytes, blocks_) < kNumServos)
    return again(Refusal::goals_unconfirmed);
  for (std::size_t s = 0; s < kNumServos; ++s) {
    const std::span<const std::uint8_t> data = blocks_.data[s];
    if (servo_bus::get_i16(data) != duties_raw[s] ||
        bus.joint_raw(static_cast<int>(s), servo_bus::get_i32(data.subspan(kGoalBytes - 4))) !=
            goals_raw_[s])
      return again(Refusal::goals_unconfirmed);
  }
  stage_ = Stage::torque;
  tries_ = 0;
  return Progress::busy;
}

Arming::Progress Arming::write_torque(BusMaster& bus, ServoReadings& servos) {
  if (!torque_written_ && (!fresh(servos) || moved(servos))) {
    stage_ = Stage::goals;
    return again(Refusal::servo_not_fresh);
  }
  (void)bus.write_torque(true, servos);
  torque_written_ = true;
  const int answered = bus.read_block(xm430::kTorqueEnable.address, 1, blocks_);
  const bool all_on = std::ranges::all_of(blocks_.data, [](const auto& d) { return d[0] == 1; });
  if (answered < kNumServos || !all_on) return again(Refusal::torque_unconfirmed);
  stage_ = Stage::settle;
  return Progress::busy;
}

}  // namespace sanso::firmware
