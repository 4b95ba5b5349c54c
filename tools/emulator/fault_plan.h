// Fault switches: what goes wrong, at which device, from when to when. Named, so that tests,
// configuration files and the emulator's control socket mean the same.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/base/time.h"

namespace sanso::emulator {

enum class FaultKind : std::uint8_t {
  bus_drop,         // replies do not leave the device
  bus_corrupt,      // one bit of a reply is flipped
  bus_truncate,     // a reply ends half way
  bus_delay,        // replies leave `amount` seconds late
  bus_duplicate,    // replies are sent twice
  bus_garbage,      // `amount` random bytes before every reply
  request_drop,     // requests do not arrive at any device
  request_corrupt,  // one bit of a request is flipped
  reply_zeros,      // a register read is answered with zeros, whole and with a right CRC
  foreign_master,   // somebody else sends a request now and then
  servo_silent,     // the servo neither hears nor speaks (cable), physics goes on
  servo_overload,   // the overload condition is raised: shuts down when its mask says so
  servo_hot,        // winding temperature is held at `amount` C (default 85)
  // supply falls to `amount` V (default 6); below 7 V the servos reboot and lose their RAM
  brown_out,
  imu_silent,  // no reports
  imu_frozen,  // reports repeat the last sample
  pose_lost,   // tracking camera reports confidence 0
};

const char* to_string(FaultKind kind);
std::optional<FaultKind> fault_from_string(std::string_view name);
const std::vector<FaultKind>& all_fault_kinds();

struct Fault {
  FaultKind kind = FaultKind::bus_drop;
  int id = 0;  // device id; 0 = every device
  Nanoseconds start = 0;
  Nanoseconds stop = INT64_MAX;
  double probability = 1.0;  // per reply or request, for the kinds of the bus
  double amount = 0.0;       // 0 = the kind's default
};

class FaultPlan {
 public:
  void add(const Fault& fault) { faults_.push_back(fault); }
  void clear() { faults_.clear(); }
  /// The first fault of this kind that is active now at this device, nullptr when none is.
  const Fault* active(FaultKind kind, int id, Nanoseconds now) const;
  const std::vector<Fault>& all() const { return faults_; }

 private:
  std::vector<Fault> faults_;
};

}  // namespace sanso::emulator
