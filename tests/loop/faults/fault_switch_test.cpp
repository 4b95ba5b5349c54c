// Each thing that can go wrong, switched on in the middle of a planned trial: the trial ends with
// the documented fault, or carries on with the documented limit.
#include "firmware/exchange/faults.h"
#include "tests/loop/support/loop_fixture.h"

namespace sanso::loop {
namespace {

using emulator::FaultKind;
using firmware::Fault;
using firmware::Limit;
using learn::TrialEnd;

constexpr double kSwitchOn_s = 1.0;  // after the trial is started

/// A standing trial of three seconds in which `fault` begins after one.
learn::Episode trial_with(Loop& loop, emulator::Fault fault) {
  loop.setup.duration_ticks = 300;
  loop.settings.settle_s = 0.3;
  loop.stand(1);
  fault.start = loop.robot().now() + from_seconds(kSwitchOn_s);
  loop.robot().robot().faults().add(fault);
  return learn::run_trial(*loop.link, loop.upper, loop.setup, loop.settings);
}

bool limit_seen(const learn::Episode& episode, Limit limit) {
  for (const wire::Observation& o : episode.ticks)
    if ((o.limits & (1u << static_cast<unsigned>(limit))) != 0 && o.trial_tick > 50) return true;
  return false;
}

struct FaultCase {
  const char* name;
  emulator::Fault fault;
  Fault expected;
};
struct EndsTheTrial : testing::TestWithParam<FaultCase> {};

TEST_P(EndsTheTrial, WithItsNumber) {
  Loop loop("stand");
  const learn::Episode episode = trial_with(loop, GetParam().fault);
  EXPECT_EQ(episode.end, TrialEnd::fault) << learn::to_string(episode.end);
  EXPECT_EQ(episode.fault, static_cast<std::uint16_t>(GetParam().expected));
  EXPECT_GT(episode.ticks.size(), 90u) << "nothing is wrong before the switch";
}

INSTANTIATE_TEST_SUITE_P(
    Each, EndsTheTrial,
    testing::Values(
        FaultCase{"bus_drop", {.kind = FaultKind::bus_drop}, Fault::bus_silent},
        FaultCase{"bus_corrupt", {.kind = FaultKind::bus_corrupt}, Fault::bus_silent},
        FaultCase{"bus_truncate", {.kind = FaultKind::bus_truncate}, Fault::bus_silent},
        FaultCase{"bus_delay_beyond_the_tick",
                  {.kind = FaultKind::bus_delay, .amount = 0.02},
                  Fault::bus_silent},
        FaultCase{"servo_silent", {.kind = FaultKind::servo_silent, .id = 14}, Fault::servo_silent},
        FaultCase{"servo_overload", {.kind = FaultKind::servo_overload, .id = 13}, Fault::overload},
        FaultCase{"servo_hot", {.kind = FaultKind::servo_hot, .id = 13}, Fault::over_temperature},
        FaultCase{
            "supply_low", {.kind = FaultKind::brown_out, .amount = 9.0}, Fault::under_voltage},
        FaultCase{"brown_out", {.kind = FaultKind::brown_out, .amount = 6.0}, Fault::bus_silent},
        FaultCase{"imu_silent", {.kind = FaultKind::imu_silent}, Fault::imu_silent},
        FaultCase{"imu_frozen", {.kind = FaultKind::imu_frozen}, Fault::imu_frozen}),
    [](const auto& p) { return std::string(p.param.name); });

struct LimitCase {
  const char* name;
  emulator::Fault fault;
  bool informs;  // the limit `expected` is reported; else the disturbance is simply survived
  Limit expected;
};
struct CarriesOn : testing::TestWithParam<LimitCase> {};

TEST_P(CarriesOn, AndSaysSo) {
  Loop loop("stand");
  const learn::Episode episode = trial_with(loop, GetParam().fault);
  EXPECT_EQ(episode.end, TrialEnd::completed)
      << learn::to_string(episode.end) << ", fault " << episode.fault;
  EXPECT_TRUE(loop.on_its_feet());
  if (GetParam().informs) {
    EXPECT_TRUE(limit_seen(episode, GetParam().expected));
  }
}

INSTANTIATE_TEST_SUITE_P(
    Each, CarriesOn,
    testing::Values(
        LimitCase{
            "bus_drop", {.kind = FaultKind::bus_drop, .probability = 0.02}, true, Limit::bus_loss},
        LimitCase{"bus_corrupt",
                  {.kind = FaultKind::bus_corrupt, .probability = 0.02},
                  true,
                  Limit::bus_loss},
        LimitCase{"bus_truncate",
                  {.kind = FaultKind::bus_truncate, .probability = 0.02},
                  true,
                  Limit::bus_loss},
        LimitCase{"bus_delay",
                  {.kind = FaultKind::bus_delay, .probability = 0.02, .amount = 0.006},
                  true,
                  Limit::bus_loss},
        LimitCase{"bus_duplicate",
                  {.kind = FaultKind::bus_duplicate, .probability = 0.02},
                  true,
                  Limit::bus_loss},
        LimitCase{"bus_garbage",
                  {.kind = FaultKind::bus_garbage, .probability = 0.02},
                  true,
                  Limit::bus_loss},
        LimitCase{"pose_lost", {.kind = FaultKind::pose_lost}, true, Limit::pose_stale}),
    [](const auto& p) { return std::string(p.param.name); });

TEST(PulledCable, EndsTheTrialAndTheRobotStandsOnWithTorque) {
  Loop loop("squat");
  loop.stand(1);
  loop.robot().pull_bus_at(250);
  const learn::Episode episode =
      learn::run_trial(*loop.link, loop.upper, loop.setup, loop.settings);
  EXPECT_EQ(episode.end, TrialEnd::fault);
  EXPECT_EQ(episode.fault, static_cast<std::uint16_t>(Fault::bus_gone));
  // the servos hold their last goal by themselves: the knees still carry
  const emulator::Truth truth = loop.robot().robot().truth();
  EXPECT_GT(std::abs(truth.torque[13 - 1]) + std::abs(truth.torque[14 - 1]), 0.1);
}

}  // namespace
}  // namespace sanso::loop
