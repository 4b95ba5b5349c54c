// The names as people write them, and the search for the fault that is active now at a device.
#include "tools/emulator/fault_plan.h"

#include <array>
#include <utility>

namespace sanso::emulator {
namespace {

constexpr std::array<std::pair<FaultKind, const char*>, 17> kNames{{
    {FaultKind::bus_drop, "bus_drop"},
    {FaultKind::bus_corrupt, "bus_corrupt"},
    {FaultKind::bus_truncate, "bus_truncate"},
    {FaultKind::bus_delay, "bus_delay"},
    {FaultKind::bus_duplicate, "bus_duplicate"},
    {FaultKind::bus_garbage, "bus_garbage"},
    {FaultKind::request_drop, "request_drop"},
    {FaultKind::request_corrupt, "request_corrupt"},
    {FaultKind::reply_zeros, "reply_zeros"},
    {FaultKind::foreign_master, "foreign_master"},
    {FaultKind::servo_silent, "servo_silent"},
    {FaultKind::servo_overload, "servo_overload"},
    {FaultKind::servo_hot, "servo_hot"},
    {FaultKind::brown_out, "brown_out"},
    {FaultKind::imu_silent, "imu_silent"},
    {FaultKind::imu_frozen, "imu_frozen"},
    {FaultKind::pose_lost, "pose_lost"},
}};

}  // namespace

const char* to_string(FaultKind kind) {
  for (const auto& [k, name] : kNames) {
    if (k == kind) return name;
  }
  return "unknown";
}

std::optional<FaultKind> fault_from_string(std::string_view name) {
  for (const auto& [kind, text] : kNames) {
    if (name == text) return kind;
  }
  return std::nullopt;
}

const std::vector<FaultKind>& all_fault_kinds() {
  static const std::vector<FaultKind> kinds = [] {
    std::vector<FaultKind> out;
    for (const auto& entry : kNames) out.push_back(entry.first);
    return out;
  }();
  return kinds;
}

const Fault* FaultPlan::active(FaultKind kind, int id, Nanoseconds now) const {
  for (const Fault& fault : faults_) {
    const bool here = fault.id == 0 || fault.id == id;
    if (fault.kind == kind && here && now >= fault.start && now < fault.stop) return &fault;
  }
  return nullptr;
}

}  // namespace sanso::emulator
