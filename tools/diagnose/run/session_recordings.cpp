// Columns of Observation, one by one. Files are written, so that what was asked can be looked at
// and asked again with other options.
#include "tools/diagnose/run/session_recordings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "host/learn/model/prediction.h"
#include "shared/files/json.h"
#include "shared/model/joints.h"
#include "shared/model/step_model.h"
#include "shared/servo_bus/units.h"
#include "tools/diagnose/run/planner_model.h"
#include "tools/recording/csv_writer.h"

namespace sanso::diagnose {
namespace {

namespace fs = std::filesystem;
using recording::Recording;
using wire::Observation;

constexpr std::uint8_t kNoPose = 255;
constexpr double kNotSampled = std::numeric_limits<double>::quiet_NaN();

class Columns {
 public:
  Columns(const std::vector<Observation>& ticks, std::size_t rows, Recording& out)
      : ticks_(ticks), rows_(rows), out_(out) {}

  void add(const std::string& name, const std::function<double(const Observation&)>& value) {
    std::vector<double> column;
    for (std::size_t k = 0; k < rows_; ++k) column.push_back(value(ticks_[k]));
    out_.set(name, std::move(column));
  }
  void add_parts(const std::string& kind, const std::string& parts,
                 const std::function<double(const Observation&, int)>& value) {
    for (std::size_t i = 0; i < parts.size(); ++i)
      add(kind + ":" + parts[i],
          [&](const Observation& o) { return value(o, static_cast<int>(i)); });
  }

 private:
  const std::vector<Observation>& ticks_;
  std::size_t rows_;
  Recording& out_;
};

void add_joints(Columns& columns) {
  for (Eigen::Index j = 0; j < model::kNumJoints; ++j) {
    const auto i = static_cast<std::size_t>(j);
    const std::string name = model::kJoints[i].name;
    columns.add("q:" + name, [j](const Observation& o) { return o.x[model::kXJoint + j]; });
    columns.add("dq:" + name, [j](const Observation& o) { return o.x[model::kXJointRate + j]; });
    columns.add("u:" + name, [j](const Observation& o) { return o.u_out[j]; });
    columns.add("i:" + name,
                [i](const Observation& o) { return servo_bus::current_A(o.current_raw[i]); });
  }
}

void add_base(Columns& columns, bool posed) {
  columns.add_parts("base_q", "wxyz",
                    [](const Observation& o, int i) { return o.x[model::kXQuat + i]; });
  columns.add_parts("base_w", "xyz",
                    [](const Observation& o, int i) { return o.x[model::kXVel + 3 + i]; });
  columns.add_parts("imu_acc", "xyz", [](const Observation& o, int i) {
    return o.imu_acc[static_cast<std::size_t>(i)];
  });
  columns.add_parts("imu_gyro", "xyz", [](const Observation& o, int i) {
    return o.imu_gyro[static_cast<std::size_t>(i)];
  });
  if (!posed) return;
  const auto seen = [](const Observation& o, double value) {
    return o.pose_age_ticks == kNoPose ? kNotSampled : value;
  };
  columns.add_parts("base_p", "xyz",
                    [&](const Observation& o, int i) { return seen(o, o.x[model::kXPos + i]); });
  columns.add_parts("base_v", "xyz",
                    [&](const Observation& o, int i) { return seen(o, o.x[model::kXVel + i]); });
}

void require_soles(const fs::path& folder) {
  const fs::path file = folder / "summary.json";
  const auto summary = files::json_or_null(file);
  if (!summary.is_object() || !summary.contains("world") || !summary["world"].is_string())
    throw std::runtime_error(
        file.string() +
        ": missing or half written, so nobody knows what the robot stood on; `sanso learn "
        "--resume` completes the session");
  if (summary["world"].get<std::string>().ends_with("+wheels"))
    throw std::runtime_error(folder.string() +
                             ": a session on wheels; the diagnosis knows feet that stand. Name one "
                             "of a motion on soles");
}

std::vector<fs::path> trial_files(const fs::path& folder) {
  if (!fs::is_directory(folder))
    throw std::runtime_error(folder.string() +
                             ": no such folder; expected the one that `sanso learn --out` wrote");
  std::vector<fs::path> out;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".episode") out.push_back(entry.path());
  if (out.empty())
    throw std::runtime_error(folder.string() +
                             ": holds no trial (trial_NNNN.episode); expected the folder that "
                             "`sanso learn --out` wrote, after its first trial");
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace

Recording recording_of(const learn::Episode& episode) {
  const std::vector<Observation>& ticks = episode.ticks;
  const auto fell = std::find_if(ticks.begin(), ticks.end(), [](const Observation& o) {
    return !(learn::tilt_of(o.x) <= learn::kUprightTilt_rad);
  });
  const auto rows = static_cast<std::size_t>(fell - ticks.begin());
  Recording out;
  out.file = fmt::format("trial_{:04d}.csv", episode.trial + 1);
  if (rows == 0) return out;
  for (std::size_t k = 0; k < rows; ++k)
    out.t.push_back(to_seconds(ticks[k].time - ticks.front().time));
  Columns columns(ticks, rows, out);
  add_joints(columns);
  const bool posed = std::any_of(ticks.begin(), fell,
                                 [](const Observation& o) { return o.pose_age_ticks != kNoPose; });
  add_base(columns, posed);
  columns.add("volt", [](const Observation& o) { return static_cast<double>(o.voltage_V); });
  return out;
}

SessionTrials read_session(const fs::path& folder, const GateSettings& settings) {
  const std::vector<fs::path> files = trial_files(folder);
  require_soles(folder);
  SessionTrials out;
  for (const fs::path& file : files) {
    const learn::Episode episode = learn::load_episode(file);
    Recording made = recording_of(episode);
    if (std::cmp_greater_equal(made.rows(), settings.least_rows))
      out.recordings.push_back(std::move(made));
    else
      out.left_out.push_back(fmt::format("trial {}: {} ticks upright ({})", episode.trial + 1,
                                         made.rows(), learn::to_string(episode.end)));
  }
  if (out.recordings.empty())
    throw std::runtime_error(
        fmt::format("{}: none of {} trials has {} ticks with the robot upright; the first is {}",
                    folder.string(), files.size(), settings.least_rows, out.left_out.front()));
  return out;
}

void use_sessions(const std::vector<fs::path>& folders, DiagnoseOptions& options) {
  SessionTrials all;
  for (std::size_t i = 0; i < folders.size(); ++i) {
    SessionTrials trials = read_session(folders[i], options.settings.gate);
    for (Recording& r : trials.recordings) {
      if (folders.size() > 1) r.file = fmt::format("session_{}_{}", i + 1, r.file);
      all.recordings.push_back(std::move(r));
    }
    for (const std::string& line : trials.left_out)
      all.left_out.push_back(folders[i].string() + ": " + line);
  }
  const fs::path out = fs::path(options.out) / "session";
  options.model = (out / "model").string();
  write_whole_body(planner_body(model::nominal_parameters()), options.model);
  options.recordings.clear();
  for (const Recording& r : all.recordings) {
    options.recordings.push_back((out / r.file).string());
    recording::write_csv(r, options.recordings.back());
  }
  if (options.quiet) return;
  for (const std::string& line : all.left_out) fmt::print(stderr, "left out: {}\n", line);
}

}  // namespace sanso::diagnose
