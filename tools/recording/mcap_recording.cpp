// A row is made whenever the joints' state arrives, from the last known value of every column.
#include "tools/recording/mcap_recording.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>

#include "shared/files/atomic_file.h"
#include "shared/files/input_error.h"
#include "shared/mcap/ros_messages.h"
#include "shared/mcap/writer.h"
#include "tools/recording/csv_reader.h"
#include "tools/recording/mcap_file.h"
#include "tools/recording/reading_error.h"
#include "tools/recording/sidecar.h"

namespace sanso::recording {
namespace {

using mcap::Imu;
using mcap::JointState;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::string_view kStates = "/joint_states", kCommands = "/joint_commands", kImu = "/imu";
struct ExtraTopic {
  std::string_view topic, prefix;
};
constexpr ExtraTopic kExtra[] = {{"/joint_currents", "i:"},
                                 {"/joint_duties", "pwm:"},
                                 {"/joint_temperatures", "temp:"},
                                 {"/supply_voltage", ""}};

bool is_command(const std::string& topic) {
  return topic.find("command") != std::string::npos || topic.find("goal") != std::string::npos ||
         topic.find("target") != std::string::npos;
}

/// Last known value of every column; a row is copied from it when the joints' state arrives.
class RowBuilder {
 public:
  RowBuilder(Recording& recording, std::size_t max_values)
      : recording_(recording), max_values_(max_values) {}

  void set(const std::string& column, double value) {
    const auto [place, fresh] = index_.try_emplace(column, current_.size());
    if (fresh) {
      current_.push_back(kNaN);
      recording_.channels.push_back({column, std::vector<double>(recording_.rows(), kNaN)});
    }
    current_[place->second] = value;
  }
  void row(double t) {
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

 private:
  Recording& recording_;
  std::size_t max_values_;
  std::map<std::string, std::size_t> index_;
  std::vector<double> current_;
};

void set_array(RowBuilder& rows, const JointState& m, const std::vector<double>& values,
               const std::string& prefix) {
  for (std::size_t k = 0; k < std::min(values.size(), m.name.size()); ++k)
    rows.set(prefix + m.name[k], values[k]);
}

void take(RowBuilder& rows, const std::string& topic, const JointState& m) {
  for (const ExtraTopic& extra : kExtra) {
    if (topic != extra.topic) continue;
    if (extra.prefix.empty()) {
      if (!m.position.empty()) rows.set("volt", m.position[0]);
    } else {
      set_array(rows, m, m.position, std::string(extra.prefix));
    }
    return;
  }
  if (is_command(topic)) {
    set_array(rows, m, m.position, "u:");
    set_array(rows, m, m.effort, "tau_cmd:");
    return;
  }
  set_array(rows, m, m.position, "q:");
  set_array(rows, m, m.velocity, "dq:");
  set_array(rows, m, m.effort, "tau:");
  rows.row(m.stamp_s);
}

void take(RowBuilder& rows, const Imu& m) {
  constexpr const char* quaternion[] = {"base_q:w", "base_q:x", "base_q:y", "base_q:z"};
  constexpr const char* axes[] = {"x", "y", "z"};
  for (std::size_t k = 0; k < 4; ++k) rows.set(quaternion[k], m.orientation[k]);
  for (std::size_t k = 0; k < 3; ++k) {
    rows.set(std::string("base_w:") + axes[k], m.angular_velocity[k]);
    rows.set(std::string("imu_acc:") + axes[k], m.linear_acceleration[k]);
  }
}

/// Values of the columns `prefix`<joint> at a row, in the order of `joints`; NaN where there is
/// none.
std::vector<double> at_row(const Recording& r, const std::vector<std::string>& joints,
                           const std::string& prefix, std::size_t row) {
  std::vector<double> values;
  bool any = false;
  for (const std::string& joint : joints) {
    const auto column = r.find(prefix + joint);
    any = any || !column.empty();
    values.push_back(column.empty() ? kNaN : column[row]);
  }
  return any ? values : std::vector<double>{};
}

}  // namespace

Recording read_mcap(const std::string& path, std::size_t max_values) {
  Recording recording;
  recording.file = path;
  RowBuilder rows(recording, max_values);
  int undecoded = 0;
  const auto on_message = [&](const McapChannel& channel, std::uint64_t, std::string_view bytes) {
    const bool joint_state = channel.schema == mcap::kJointStateType,
               imu = channel.schema == mcap::kImuType;
    if (!joint_state && !imu) return;
    if (channel.encoding != "cdr")
      throw files::InputError(path, 0, channel.topic, "unknown message encoding", channel.encoding,
                              "cdr");
    if (joint_state) {
      const auto m = mcap::decode_joint_state(bytes);
      m ? take(rows, channel.topic, *m) : void(++undecoded);
    } else {
      const auto m = mcap::decode_imu(bytes);
      m ? take(rows, *m) : void(++undecoded);
    }
  };
  recording.cut = !read_mcap_messages(path, on_message);
  if (undecoded > 0)
    throw files::InputError(path, 0, "", "damaged message", std::to_string(undecoded) + " messages",
                            "CDR, little-endian");
  if (recording.rows() == 0)
    throw files::InputError(path, 0, "", "no joint states", "",
                            "a topic of type sensor_msgs/msg/JointState");
  std::error_code error;
  const std::string sidecar = std::filesystem::path(path).replace_extension(".toml").string();
  if (std::filesystem::exists(sidecar, error)) read_sidecar(sidecar, recording);
  return recording;
}

namespace {

/// A recording's rows as messages; the topics are declared at construction.
class RowWriter {
 public:
  RowWriter(const Recording& r, mcap::Writer& out) : r_(r), out_(out), joints_(r.joints()) {
    states_ = joint_channel(kStates);
    commands_ = joint_channel(kCommands);
    for (const ExtraTopic& e : kExtra) extra_[e.topic] = joint_channel(e.topic);
    has_imu_ = std::any_of(r.channels.begin(), r.channels.end(), [](const Channel& c) {
      return c.name.starts_with("imu_acc:") || c.name.starts_with("base_w:") ||
             c.name.starts_with("base_q:");
    });
    if (has_imu_)
      imu_ =
          out.add_channel(std::string(kImu), std::string(mcap::kImuType), mcap::imu_definition());
  }

  /// Commands and settings first: a reader takes the row when the joints' state arrives.
  void write(std::size_t k) {
    const double t = r_.t[k];
    const auto ns = static_cast<std::uint64_t>(std::llround(std::max(0.0, t) * 1e9));
    JointState command{t, joints_, at("u:", k), {}, at("tau_cmd:", k)};
    // JointState says effort for both
    if (command.effort.empty()) command.effort = at("force_cmd:", k);
    if (!command.position.empty() || !command.effort.empty())
      out_.write(commands_, ns, encode(command));
    for (const ExtraTopic& e : kExtra) write_extra(e, k, ns);
    if (has_imu_) {
      const Imu imu{
          t,
          {value("base_q:w", k), value("base_q:x", k), value("base_q:y", k), value("base_q:z", k)},
          {value("base_w:x", k), value("base_w:y", k), value("base_w:z", k)},
          {value("imu_acc:x", k), value("imu_acc:y", k), value("imu_acc:z", k)}};
      out_.write(imu_, ns, encode(imu));
    }
    out_.write(states_, ns,
               encode(JointState{t, joints_, at("q:", k), at("dq:", k), at("tau:", k)}));
  }

 private:
  std::uint16_t joint_channel(std::string_view topic) {
    return out_.add_channel(std::string(topic), std::string(mcap::kJointStateType),
                            mcap::joint_state_definition());
  }
  std::vector<double> at(const std::string& prefix, std::size_t k) const {
    return at_row(r_, joints_, prefix, k);
  }
  double value(const std::string& column, std::size_t k) const {
    return r_.has(column) ? r_.find(column)[k] : kNaN;
  }
  void write_extra(const ExtraTopic& e, std::size_t k, std::uint64_t ns) {
    JointState m{r_.t[k], joints_, {}, {}, {}};
    if (e.prefix.empty()) {
      m.name = {"supply"};
      if (r_.has("volt")) m.position = {value("volt", k)};
    } else {
      m.position = at(std::string(e.prefix), k);
    }
    if (!m.position.empty()) out_.write(extra_[e.topic], ns, encode(m));
  }

  const Recording& r_;
  mcap::Writer& out_;
  std::vector<std::string> joints_;
  std::uint16_t states_ = 0, commands_ = 0, imu_ = 0;
  std::map<std::string_view, std::uint16_t> extra_;
  bool has_imu_ = false;
};

}  // namespace

void write_mcap(const Recording& r, const std::string& path) {
  std::string file;
  mcap::Writer out([&](std::string_view bytes) { file += bytes; });
  RowWriter rows(r, out);
  for (std::size_t k = 0; k < r.rows(); ++k) rows.write(k);
  out.finish();
  files::write_atomically(path, file);
}

Recording read_recording(const std::string& path) {
  return path.ends_with(".mcap") ? read_mcap(path) : read_csv(path);
}

}  // namespace sanso::recording
