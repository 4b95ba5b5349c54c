// All servos before the first hour: which are there, at which speed, in what state, and what in
// them differs from what the controller needs. Reads only; writing and rebooting are calls of their
// own. Single transactions with pauses: not for the tick. Allocates.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "firmware/board/board.h"
#include "firmware/bus/bus_master.h"
#include "firmware/config/settings.h"

namespace sanso::firmware {

/// A register that does not hold what it should.
struct RegisterDifference {
  const servo_bus::Register* reg = nullptr;
  std::int64_t found = 0, wanted = 0;
  bool written = false;  // by write_eeprom: needed by the controller; else the owner decides
};

struct ServoRow {
  std::uint8_t id = 0;
  const char* name = "";
  int baud = 0;  // 0: no answer at any speed
  std::uint16_t model = 0;
  std::uint8_t firmware = 0;
  std::uint8_t hardware_error = 0;
  bool shut_down = false;  // refuses torque until it is rebooted
  bool torque_on = false;
  double voltage_V = 0;
  int temperature_C = 0;
  std::vector<RegisterDifference> differences;
  bool good() const;
};

class ServoCheck {
 public:
  /// Changes the speed of `port`; false when it cannot.
  using SetBaud = std::function<bool(int baud)>;

  ServoCheck(const BusSettings& settings, board::SerialPort& port, board::Clock& clock,
             SetBaud set_baud);

  /// Switches the supply on where an OpenCR does that, and waits for the servos to boot. False: the
  /// board does not answer.
  bool power_up();
  /// One row a servo, in the order of the ids.
  std::vector<ServoRow> look();
  /// Writes what the controller needs into the EEPROM of servos whose torque is off, the speed
  /// last; how many registers were written.
  int write_eeprom(const std::vector<ServoRow>& rows);
  /// Reboots servos that have shut down and waits for them; how many answer again.
  int reboot(const std::vector<ServoRow>& rows);

 private:
  bool find(ServoRow& row);
  void read_state(ServoRow& row);
  void pause(Nanoseconds time);

  BusSettings settings_;
  board::SerialPort& port_;
  board::Clock& clock_;
  SetBaud set_baud_;
  BusMaster bus_;
};

/// The table that `--self-test` prints.
std::string servo_table(const std::vector<ServoRow>& rows);

}  // namespace sanso::firmware
