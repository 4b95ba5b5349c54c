// Pings at the set speed first and at the others only for who is missing; every register is read
// with a few tries, because a factory bus loses replies too.
#include "firmware/app/servo_check.h"

#include <algorithm>
#include <array>
#include <cstdio>

#include "shared/servo_bus/opencr.h"
#include "shared/servo_bus/units.h"

namespace sanso::firmware {
namespace {

namespace xm430 = servo_bus::xm430;
constexpr int kTries = 5;
constexpr Nanoseconds kBootTime = 2 * kSecond;  // of a rebooted servo, with a margin

struct Wanted {
  const servo_bus::Register* reg;
  std::int64_t value;
  bool needed;  // the controller cannot work otherwise
};

std::int64_t baud_index(double baud) {
  const auto rate = std::find(xm430::kBaudRates.begin(), xm430::kBaudRates.end(),
                              static_cast<std::int32_t>(baud));
  return rate - xm430::kBaudRates.begin();
}

/// What lies in the EEPROM and has to be right before the controller starts; the speed last, since
/// the servo is lost to this line with it.
std::vector<Wanted> wanted_eeprom(const BusSettings& s) {
  return {{&xm430::kReturnDelayTime, s.return_delay_raw, true},
          {&xm430::kOperatingMode, xm430::kModePosition, true},
          {&xm430::kDriveMode, 0, true},
          {&xm430::kMinPositionLimit, 0, true},
          {&xm430::kMaxPositionLimit, 4095, true},
          {&xm430::kPwmLimit, 885, true},
          {&xm430::kSecondaryId, 255, true},
          {&xm430::kHomingOffset, 0, false},
          {&xm430::kShutdown, xm430::kShutdown.initial_raw, false},
          {&xm430::kBaudRate, baud_index(s.byte_rate_baud), true}};
}

/// A register's value, after a few tries.
Result<std::int64_t> read(BusMaster& bus, std::uint8_t id, const servo_bus::Register& r) {
  Result<std::int64_t> value = Status::timeout;
  for (int i = 0; i < kTries && !value.ok(); ++i)
    value = bus.read_register(id, r.address, r.size, r.is_signed);
  return value;
}

std::string error_words(std::uint8_t error) {
  std::string text;
  const auto add = [&](std::uint8_t bit, const char* word) {
    if ((error & bit) != 0) text += (text.empty() ? "" : "+") + std::string(word);
  };
  add(xm430::kErrorVoltage, "voltage");
  add(xm430::kErrorOverheat, "heat");
  add(xm430::kErrorEncoder, "encoder");
  add(xm430::kErrorShock, "shock");
  add(xm430::kErrorOverload, "overload");
  return text.empty() ? "-" : text;
}

}  // namespace

bool ServoRow::good() const {
  return baud != 0 && model == xm430::kModel && hardware_error == 0 &&
         std::none_of(differences.begin(), differences.end(),
                      [](const RegisterDifference& d) { return d.written; });
}

ServoCheck::ServoCheck(const BusSettings& settings, board::SerialPort& port, board::Clock& clock,
                       SetBaud set_baud)
    : settings_(settings),
      port_(port),
      clock_(clock),
      set_baud_(std::move(set_baud)),
      bus_(settings, port, clock) {}

void ServoCheck::pause(Nanoseconds time) {
  const Nanoseconds end = clock_.now() + time;
  std::array<std::uint8_t, 64> waste;
  while (clock_.now() < end)
    if (!port_.read(waste, end).ok()) return;
}

bool ServoCheck::power_up() {
  if (!settings_.require_opencr) return true;
  namespace opencr = servo_bus::opencr;
  for (int i = 0; i < kTries; ++i) {
    const Result<std::int64_t> power = bus_.read_register(opencr::kId, opencr::kServoPower, 1);
    if (power.ok() && *power == 1) return true;
    if (bus_.write_register(opencr::kId, opencr::kServoPower, 1, 1) != Status::ok) continue;
    pause(from_seconds(settings_.power_up_wait_s));
    return true;
  }
  return false;
}

/// At the speed of the line.
bool ServoCheck::find(ServoRow& row) {
  for (int i = 0; i < kTries; ++i) {
    const Result<BusMaster::Identity> identity = bus_.ping(row.id);
    if (!identity.ok()) continue;
    row.model = identity->model;
    row.firmware = identity->firmware;
    return true;
  }
  return false;
}

void ServoCheck::read_state(ServoRow& row) {
  row.hardware_error = static_cast<std::uint8_t>(*read(bus_, row.id, xm430::kHardwareErrorStatus));
  row.torque_on = *read(bus_, row.id, xm430::kTorqueEnable) == 1;
  row.voltage_V = servo_bus::voltage_V(
      static_cast<std::uint16_t>(*read(bus_, row.id, xm430::kPresentInputVoltage)));
  row.temperature_C = static_cast<int>(*read(bus_, row.id, xm430::kPresentTemperature));
  const Result<std::int64_t> mask = read(bus_, row.id, xm430::kShutdown);
  row.shut_down = mask.ok() && (row.hardware_error & *mask) != 0;
  for (const Wanted& w : wanted_eeprom(settings_)) {
    const Result<std::int64_t> value = read(bus_, row.id, *w.reg);
    if (value.ok() && *value != w.value)
      row.differences.push_back({w.reg, *value, w.value, w.needed});
  }
}

std::vector<ServoRow> ServoCheck::look() {
  std::vector<ServoRow> rows;
  for (int id = 1; id <= kNumServos; ++id) {
    ServoRow row;
    row.id = static_cast<std::uint8_t>(id);
    row.name = servo_name(slot_of(row.id));
    rows.push_back(row);
  }
  const int usual = static_cast<int>(settings_.byte_rate_baud);
  std::vector<int> speeds{usual};
  for (const std::int32_t rate : xm430::kBaudRates)
    if (rate != usual) speeds.push_back(rate);
  for (const int speed : speeds) {
    const bool missing =
        std::any_of(rows.begin(), rows.end(), [](const ServoRow& r) { return r.baud == 0; });
    if (!missing || !set_baud_(speed)) continue;
    for (ServoRow& row : rows) {
      if (row.baud != 0 || !find(row)) continue;
      row.baud = speed;
      if (row.model == xm430::kModel) read_state(row);
    }
  }
  (void)set_baud_(usual);
  return rows;
}

int ServoCheck::write_eeprom(const std::vector<ServoRow>& rows) {
  int written = 0;
  for (const ServoRow& row : rows) {
    if (row.baud == 0 || row.model != xm430::kModel || row.torque_on || !set_baud_(row.baud))
      continue;
    for (const RegisterDifference& d : row.differences) {
      if (!d.written) continue;
      Status status = Status::timeout;
      for (int i = 0; i < kTries && status != Status::ok; ++i)
        status = bus_.write_register(row.id, d.reg->address, d.reg->size, d.wanted);
      written += status == Status::ok ? 1 : 0;
    }
  }
  (void)set_baud_(static_cast<int>(settings_.byte_rate_baud));
  return written;
}

int ServoCheck::reboot(const std::vector<ServoRow>& rows) {
  std::vector<std::uint8_t> asked;
  for (const ServoRow& row : rows) {
    if (!row.shut_down || !set_baud_(row.baud)) continue;
    if (bus_.reboot(row.id) == Status::ok) asked.push_back(row.id);
  }
  if (asked.empty()) return 0;
  pause(kBootTime);
  int back = 0;
  for (const ServoRow& row : rows) {
    if (std::find(asked.begin(), asked.end(), row.id) == asked.end() || !set_baud_(row.baud))
      continue;
    ServoRow again = row;
    back += find(again) ? 1 : 0;
  }
  (void)set_baud_(static_cast<int>(settings_.byte_rate_baud));
  return back;
}

std::string servo_table(const std::vector<ServoRow>& rows) {
  std::string text =
      "id  name           baud     model  fw  error          volt  temp  differs from what is "
      "wanted\n";
  char line[160];
  for (const ServoRow& r : rows) {
    if (r.baud == 0) {
      std::snprintf(line, sizeof line, "%2d  %-13s  no answer at any speed\n", r.id, r.name);
      text += line;
      continue;
    }
    std::snprintf(line, sizeof line, "%2d  %-13s  %-7d  %5d  %2d  %-13s  %4.1f  %4d  ", r.id,
                  r.name, r.baud, r.model, r.firmware,
                  (error_words(r.hardware_error) + (r.shut_down ? " (off)" : "")).c_str(),
                  r.voltage_V, r.temperature_C);
    text += line;
    std::string notes;
    if (r.model != xm430::kModel) notes += "not an XM430-W350; ";
    if (r.firmware < xm430::kFirmwareWithFastRead) notes += "no fast sync read below firmware 45; ";
    if (r.torque_on) notes += "torque is on; ";
    for (const RegisterDifference& d : r.differences)
      notes += std::string(d.reg->name) + " " + std::to_string(d.found) + " (wanted " +
               std::to_string(d.wanted) + (d.written ? "); " : ", yours to decide); ");
    text += (notes.empty() ? "-" : notes.substr(0, notes.size() - 2)) + "\n";
  }
  return text;
}

}  // namespace sanso::firmware
