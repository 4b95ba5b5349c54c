// The first look at a robot as the factory delivers it: every difference is named, nothing is
// written unasked, and after the writing the controller's own start-up is content.
#include "firmware/app/servo_check.h"

#include <gtest/gtest.h>

#include "firmware/bus/bus_setup.h"
#include "tests/firmware/support/emulated_controller.h"

namespace sanso::firmware {
namespace {

class FactoryRobot {
 public:
  FactoryRobot() : robot(plant::load_world("nominal"), 1) {
    for (int id = 1; id <= emulator::kNumServos; ++id) {
      emulator::ServoSetup servo;
      servo.id = id;
      servo.return_delay_raw = 250;
      if (id == 5) servo.baud = 1'000'000;
      if (id == 9) servo.firmware = 42;
      if (id == 13) servo.shut_down = true;
      robot.set_up(servo);
    }
  }
  ServoCheck check() {
    return {settings, port, clock, [&](int baud) {
              robot.set_line_baud(baud);
              return true;
            }};
  }
  emulator::EmulatedRobot robot;
  firmware::testing::RobotPort port{robot};
  firmware::testing::RobotClock clock{robot};
  BusSettings settings;
};

std::string line_of(const std::string& table, int id) {
  char head[8];
  std::snprintf(head, sizeof head, "\n%2d  ", id);
  const std::size_t begin = table.find(head);
  if (begin == std::string::npos) return {};
  return table.substr(begin + 1, table.find('\n', begin + 1) - begin);
}

TEST(ServoCheck, OnePageNamesEveryDifferenceOfAFactoryRobot) {
  FactoryRobot factory;
  ServoCheck check = factory.check();
  ASSERT_TRUE(check.power_up());
  const std::vector<ServoRow> rows = check.look();
  const std::string table = servo_table(rows);
  SCOPED_TRACE(table);
  ASSERT_EQ(rows.size(), 20u);
  for (const ServoRow& row : rows) {
    EXPECT_NE(row.baud, 0);
    EXPECT_FALSE(row.good());
    EXPECT_NEAR(row.voltage_V, 12.0, 1.5);
    EXPECT_NE(line_of(table, row.id).find("Return Delay Time 250 (wanted 1)"), std::string::npos);
  }
  EXPECT_NE(line_of(table, 5).find("1000000"), std::string::npos);
  EXPECT_NE(line_of(table, 5).find("Baud Rate 3 (wanted 4)"), std::string::npos);
  EXPECT_NE(line_of(table, 9).find("no fast sync read below firmware 45"), std::string::npos);
  EXPECT_NE(line_of(table, 13).find("overload (off)"), std::string::npos);
}

TEST(ServoCheck, LookingWritesNothing) {
  FactoryRobot factory;
  ServoCheck check = factory.check();
  ASSERT_TRUE(check.power_up());
  const std::string first = servo_table(check.look());
  const std::string second = servo_table(check.look());
  EXPECT_EQ(first, second);
}

TEST(ServoCheck, AfterWritingAndRebootingTheControllersOwnStartUpIsContent) {
  FactoryRobot factory;
  ServoCheck check = factory.check();
  ASSERT_TRUE(check.power_up());
  std::vector<ServoRow> rows = check.look();
  EXPECT_EQ(check.reboot(rows), 1);
  EXPECT_EQ(check.write_eeprom(rows), 21) << "20 return delays and one speed";
  rows = check.look();
  SCOPED_TRACE(servo_table(rows));
  for (const ServoRow& row : rows) EXPECT_TRUE(row.good()) << int(row.id);

  BusMaster bus(factory.settings, factory.port, factory.clock);
  BusSetup setup(factory.settings);
  auto progress = BusSetup::Progress::running;
  for (int tick = 0; tick < 3000 && progress == BusSetup::Progress::running; ++tick) {
    factory.robot.advance(factory.robot.now() + kTickPeriod);
    progress = setup.step(bus, factory.robot.now());
  }
  EXPECT_EQ(progress, BusSetup::Progress::done)
      << "fault " << int(setup.fault()) << ", detail " << setup.fault_detail();
  EXPECT_FALSE(bus.fast_read()) << "servo 9 does not know it";
}

TEST(ServoCheck, AServoWithTorqueOnIsNotWritten) {
  FactoryRobot factory;
  ServoCheck check = factory.check();
  ASSERT_TRUE(check.power_up());
  BusMaster bus(factory.settings, factory.port, factory.clock);
  ASSERT_EQ(bus.write_register(7, servo_bus::xm430::kTorqueEnable.address, 1, 1), Status::ok);
  (void)check.write_eeprom(check.look());
  const std::vector<ServoRow> rows = check.look();
  EXPECT_TRUE(rows[6].torque_on);
  EXPECT_FALSE(rows[6].good());
  EXPECT_TRUE(rows[7].good());
}

TEST(ServoCheck, AServoThatIsNotThereIsNamed) {
  FactoryRobot factory;
  factory.robot.faults().add({.kind = emulator::FaultKind::servo_silent, .id = 17});
  ServoCheck check = factory.check();
  ASSERT_TRUE(check.power_up());
  const std::string table = servo_table(check.look());
  EXPECT_NE(line_of(table, 17).find("no answer at any speed"), std::string::npos) << table;
}

}  // namespace
}  // namespace sanso::firmware
