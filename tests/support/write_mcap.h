// A recording as the MCAP file that a robot's own log would be.
#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "shared/files/atomic_file.h"
#include "shared/mcap/ros_messages.h"
#include "shared/mcap/writer.h"
#include "tools/recording/recording.h"
#include "tools/recording/ros_rows.h"

namespace sanso::recording {

/// Values of the columns `prefix`<joint> at a row, in the order of `joints`; NaN where there is
/// none.
inline std::vector<double> at_row(const Recording& r, const std::vector<std::string>& joints,
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

/// A recording's rows as messages; the topics are declared at construction.
class RowWriter {
 public:
  RowWriter(const Recording& r, mcap::Writer& out) : r_(r), out_(out), joints_(r.joints()) {
    states_ = joint_channel("/joint_states");
    commands_ = joint_channel("/joint_commands");
    for (const ExtraTopic& e : kExtraTopics) extra_[e.topic] = joint_channel(e.topic);
    has_imu_ = std::any_of(r.channels.begin(), r.channels.end(), [](const Channel& c) {
      return c.name.starts_with("imu_acc:") || c.name.starts_with("base_w:") ||
             c.name.starts_with("base_q:");
    });
    if (has_imu_)
      imu_ = out.add_channel("/imu", std::string(mcap::kImuType), mcap::imu_definition());
  }

  /// Commands and settings first: a reader takes the row when the joints' state arrives.
  void write(std::size_t k) {
    const double t = r_.t[k];
    const auto ns = static_cast<std::uint64_t>(std::llround(std::max(0.0, t) * 1e9));
    mcap::JointState command{t, joints_, at("u:", k), {}, at("tau_cmd:", k)};
    // JointState says effort for both
    if (command.effort.empty()) command.effort = at("force_cmd:", k);
    if (!command.position.empty() || !command.effort.empty())
      out_.write(commands_, ns, encode(command));
    for (const ExtraTopic& e : kExtraTopics) write_extra(e, k, ns);
    if (has_imu_) {
      const mcap::Imu imu{
          t,
          {value("base_q:w", k), value("base_q:x", k), value("base_q:y", k), value("base_q:z", k)},
          {value("base_w:x", k), value("base_w:y", k), value("base_w:z", k)},
          {value("imu_acc:x", k), value("imu_acc:y", k), value("imu_acc:z", k)}};
      out_.write(imu_, ns, encode(imu));
    }
    out_.write(states_, ns,
               encode(mcap::JointState{t, joints_, at("q:", k), at("dq:", k), at("tau:", k)}));
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
    mcap::JointState m{r_.t[k], joints_, {}, {}, {}};
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

/// Writes what the topics of mcap_recording.h can hold; base_p and base_v are not among them and
/// are left out.
inline void write_mcap(const Recording& r, const std::string& path) {
  std::string file;
  mcap::Writer out([&](std::string_view bytes) { file += bytes; });
  RowWriter rows(r, out);
  for (std::size_t k = 0; k < r.rows(); ++k) rows.write(k);
  out.finish();
  files::write_atomically(path, file);
}

}  // namespace sanso::recording
