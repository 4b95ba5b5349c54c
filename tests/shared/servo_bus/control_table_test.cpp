// Control table and units: order, overlap, and the data sheet's round numbers.
#include <gtest/gtest.h>

#include "shared/servo_bus/units.h"
#include "shared/servo_bus/xm430.h"

namespace sanso::servo_bus {
namespace {

TEST(ControlTable, RegistersAreInOrderAndDoNotOverlap) {
  for (std::size_t i = 1; i < xm430::kRegisters.size(); ++i) {
    const Register& a = xm430::kRegisters[i - 1];
    EXPECT_LE(a.address + a.size, xm430::kRegisters[i].address) << a.name;
    EXPECT_GE(a.initial_raw, a.min_raw) << a.name;
    EXPECT_LE(a.initial_raw, a.max_raw) << a.name;
  }
}

TEST(Units, DataSheetFigures) {
  EXPECT_DOUBLE_EQ(position_rad(2048), 0.0);
  EXPECT_NEAR(position_rad(2048 + 1024), 1.5707963267948966, 1e-12);
  EXPECT_NEAR(velocity_rad_s(1), 0.023981, 1e-6);
  EXPECT_NEAR(current_A(1193), 3.209, 1e-3);
  EXPECT_DOUBLE_EQ(duty(885), 1.0);
  EXPECT_DOUBLE_EQ(voltage_V(120), 12.0);
}

TEST(Units, RoundTripOfEveryPositionCount) {
  for (std::int32_t raw = -5000; raw < 9000; ++raw) ASSERT_EQ(position_raw(position_rad(raw)), raw);
}

}  // namespace
}  // namespace sanso::servo_bus
