// ROS 2 messages to the rows of a recording, whatever container they came in. A row is made when
// the joints' state arrives, from the last known value of every column.
#pragma once

#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "shared/mcap/ros_messages.h"
#include "tools/recording/recording.h"

namespace sanso::recording {

/// What a row holds in a column of which nothing was said.
inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Topics of ours beyond states, commands and IMU: which columns their positions are. An empty
/// prefix: the supply's voltage.
struct ExtraTopic {
  std::string_view topic, prefix;
};
inline constexpr ExtraTopic kExtraTopics[] = {{"/joint_currents", "i:"},
                                              {"/joint_duties", "pwm:"},
                                              {"/joint_temperatures", "temp:"},
                                              {"/supply_voltage", ""}};

class RosRows {
 public:
  /// Rows are added to `recording`, whose file is named in errors; at most `max_values` in all.
  RosRows(Recording& recording, std::size_t max_values)
      : recording_(recording), max_values_(max_values) {}

  /// Whether messages of this type (as "sensor_msgs/msg/Imu") become columns.
  static bool reads(std::string_view type);
  /// Takes a message of a type that it reads. Throws files::InputError: another encoding than cdr,
  /// more values than allowed.
  void take(const std::string& topic, std::string_view type, const std::string& encoding,
            std::string_view bytes);
  /// Throws files::InputError when messages were damaged or no joint state was among them; reads
  /// the sidecar, if there is one.
  void finish();

 private:
  void set(const std::string& column, double value);
  void set_array(const mcap::JointState& m, const std::vector<double>& values,
                 const std::string& prefix);
  void row(double t);
  void take(const std::string& topic, const mcap::JointState& m);
  void take(const mcap::Imu& m);

  Recording& recording_;
  std::size_t max_values_;
  std::map<std::string, std::size_t> index_;
  std::vector<double> current_;  // last known value of every column
  int undecoded_ = 0;
};

}  // namespace sanso::recording
