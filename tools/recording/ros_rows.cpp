// Which message becomes which column: mcap_recording.h has the table.
#include "tools/recording/ros_rows.h"

#include <algorithm>
#include <filesystem>
#include <limits>

#include "shared/files/input_error.h"
#include "tools/recording/reading_error.h"
#include "tools/recording/sidecar.h"

namespace sanso::recording {
namespace {

using mcap::Imu;
using mcap::JointState;

bool is_command(const std::string& topic) {
  return topic.find("command") != std::string::npos || topic.find("goal") != std::string::npos ||
         topic.find("target") != std::string::npos;
}

}  // namespace

bool RosRows::reads(std::string_view type) {
  return type == mcap::kJointStateType || type == mcap::kImuType;
}

void RosRows::take(const std::string& topic, std::string_view type, const std::string& encoding,
                   std::string_view bytes) {
  if (encoding != "cdr")
    throw files::InputError(recording_.file, 0, topic, "unknown message encoding", encoding, "cdr");
  if (type == mcap::kJointStateType) {
    const auto m = mcap::decode_joint_state(bytes);
    m ? take(topic, *m) : void(++undecoded_);
  } else {
    const auto m = mcap::decode_imu(bytes);
    m ? take(*m) : void(++undecoded_);
  }
}

void RosRows::finish() {
  if (undecoded_ > 0)
    throw files::InputError(recording_.file, 0, "", "damaged message",
                            std::to_string(undecoded_) + " messages", "CDR, little-endian");
  if (recording_.rows() == 0)
    throw files::InputError(recording_.file, 0, "", "no joint states", "",
                            "a topic of type sensor_msgs/msg/JointState");
  std::error_code error;
  const std::string sidecar =
      std::filesystem::path(recording_.file).replace_extension(".toml").string();
  if (std::filesystem::exists(sidecar, error)) read_sidecar(sidecar, recording_);
}

void RosRows::set(const std::string& column, double value) {
  const auto [place, fresh] = index_.try_emplace(column, current_.size());
  if (fresh) {
    current_.push_back(kNaN);
    recording_.channels.push_back({column, std::vector<double>(recording_.rows(), kNaN)});
  }
  current_[place->second] = value;
}

void RosRows::row(double t) {
  recording_.t.push_back(t);
  for (std::size_t k = 0; k < current_.size(); ++k)
    recording_.channels[k].values.push_back(current_[k]);
  if (recording_.rows() * (current_.size() + 1) > max_values_) {
    throw ReadingError(
        ReadFault::too_large, recording_.file, 0, "", "recording too large",
        std::to_string(recording_.rows()) + " rows",
        "at most " + std::to_string(max_values_) + " values; cut it into shorter recordings");
  }
}

void RosRows::set_array(const JointState& m, const std::vector<double>& values,
                        const std::string& prefix) {
  for (std::size_t k = 0; k < std::min(values.size(), m.name.size()); ++k)
    set(prefix + m.name[k], values[k]);
}

void RosRows::take(const std::string& topic, const JointState& m) {
  for (const ExtraTopic& extra : kExtraTopics) {
    if (topic != extra.topic) continue;
    if (extra.prefix.empty()) {
      if (!m.position.empty()) set("volt", m.position[0]);
    } else {
      set_array(m, m.position, std::string(extra.prefix));
    }
    return;
  }
  if (is_command(topic)) {
    set_array(m, m.position, "u:");
    set_array(m, m.effort, "tau_cmd:");
    return;
  }
  set_array(m, m.position, "q:");
  set_array(m, m.velocity, "dq:");
  set_array(m, m.effort, "tau:");
  row(m.stamp_s);
}

void RosRows::take(const Imu& m) {
  constexpr const char* quaternion[] = {"base_q:w", "base_q:x", "base_q:y", "base_q:z"};
  constexpr const char* axes[] = {"x", "y", "z"};
  for (std::size_t k = 0; k < 4; ++k) set(quaternion[k], m.orientation[k]);
  for (std::size_t k = 0; k < 3; ++k) {
    set(std::string("base_w:") + axes[k], m.angular_velocity[k]);
    set(std::string("imu_acc:") + axes[k], m.linear_acceleration[k]);
  }
}

}  // namespace sanso::recording
