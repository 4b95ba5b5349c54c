// The table of column suffixes, units and meanings that readers and writers share, and the check
// of the time stamps.
#include "tools/recording/recording.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "shared/files/input_error.h"
#include "tools/recording/reading_error.h"

namespace sanso::recording {
namespace {

using Suffix = ChannelKind::Suffix;
constexpr std::array<ChannelKind, 18> kKinds{{
    {"q", "rad (m for prismatic joints)", Suffix::joint},
    {"dq", "rad/s (m/s)", Suffix::joint},
    {"u", "goal position, rad (m)", Suffix::joint},
    {"tau_cmd", "commanded torque, N m", Suffix::joint},
    {"force_cmd", "commanded force, N", Suffix::joint},
    {"tau", "measured torque, N m (N)", Suffix::joint},
    {"i", "current, A", Suffix::joint},
    {"pwm", "duty, -1..1", Suffix::joint},
    {"temp", "temperature, C", Suffix::joint},
    {"volt", "supply, V", Suffix::none},
    {"base_p", "base position in world axes, m", Suffix::xyz},
    {"base_q", "base orientation, unit quaternion w x y z", Suffix::wxyz},
    {"base_v", "base velocity in world axes, m/s", Suffix::xyz},
    {"base_w", "angular velocity in base axes, rad/s", Suffix::xyz},
    {"imu_acc", "specific force in the axes of the IMU, m/s^2", Suffix::xyz},
    {"imu_gyro", "angular velocity in the axes of the IMU, rad/s", Suffix::xyz},
    // a link's name, spelled as a joint's
    {"fz", "vertical force of the ground on a foot, N", Suffix::joint},
    {"t", "s", Suffix::none},
}};

bool suffix_fits(Suffix suffix, std::string_view after_colon) {
  switch (suffix) {
    case Suffix::none:
      return false;
    case Suffix::joint:
      return !after_colon.empty();
    case Suffix::xyz:
      return after_colon == "x" || after_colon == "y" || after_colon == "z";
    case Suffix::wxyz:
      return after_colon == "w" || after_colon == "x" || after_colon == "y" || after_colon == "z";
  }
  return false;
}

}  // namespace

const ChannelKind* kind_of(std::string_view column) {
  const auto colon = column.find(':');
  for (const ChannelKind& kind : kKinds) {
    if (colon == std::string_view::npos) {
      if (kind.suffix == Suffix::none && column == kind.prefix) return &kind;
    } else if (column.substr(0, colon) == kind.prefix &&
               suffix_fits(kind.suffix, column.substr(colon + 1))) {
      return &kind;
    }
  }
  return nullptr;
}

std::span<const double> Recording::find(std::string_view name) const {
  for (const Channel& channel : channels) {
    if (channel.name == name) return channel.values;
  }
  return {};
}

void Recording::set(std::string_view name, std::vector<double> values) {
  for (Channel& channel : channels) {
    if (channel.name == name) {
      channel.values = std::move(values);
      return;
    }
  }
  channels.push_back({std::string(name), std::move(values)});
}

std::vector<std::string> Recording::joints() const {
  std::vector<std::string> names;
  for (const Channel& channel : channels) {
    const ChannelKind* kind = kind_of(channel.name);
    if (kind == nullptr || kind->suffix != Suffix::joint || kind->prefix == "fz") continue;
    const std::string joint = channel.name.substr(channel.name.find(':') + 1);
    if (std::find(names.begin(), names.end(), joint) == names.end()) names.push_back(joint);
  }
  return names;
}

std::string Recording::stem() const {
  std::string name = file.substr(file.find_last_of('/') + 1);
  for (const char* ending : {".gz", ".csv", ".mcap"}) {
    const std::string_view e = ending;
    if (name.size() > e.size() && name.compare(name.size() - e.size(), e.size(), e) == 0) {
      name.resize(name.size() - e.size());
    }
  }
  return name;
}

void require_increasing_time(const Recording& recording) {
  for (std::size_t k = 0; k < recording.rows(); ++k) {
    const int line = recording.header_line + 1 + static_cast<int>(k);
    const double t = recording.t[k];
    if (!std::isfinite(t))
      throw ReadingError(ReadFault::not_a_number, recording.file, line, "t", "time missing", "",
                         "seconds in every row");
    if (k > 0 && t <= recording.t[k - 1]) {
      throw files::InputError(
          recording.file, line, "t", "time does not increase", std::to_string(t),
          "more than " + std::to_string(recording.t[k - 1]) + " s, the row before");
    }
  }
}

}  // namespace sanso::recording
