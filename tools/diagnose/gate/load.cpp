// What the readers refuse becomes a defect with the same name that the checks would give it.
#include "tools/diagnose/gate/load.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "shared/files/hash.h"
#include "tools/diagnose/gate/held.h"
#include "tools/diagnose/gate/jumps.h"
#include "tools/diagnose/gate/stale.h"
#include "tools/recording/mcap_recording.h"
#include "tools/recording/reading_error.h"

namespace sanso::diagnose {
namespace {

/// The bytes of the columns, time first.
std::string hash_of(const recording::Recording& r) {
  std::vector<std::uint8_t> bytes;
  const auto add = [&](const std::vector<double>& values) {
    const auto* first = reinterpret_cast<const std::uint8_t*>(values.data());
    bytes.insert(bytes.end(), first, first + values.size() * sizeof(double));
  };
  add(r.t);
  for (const recording::Channel& c : r.channels) add(c.values);
  return fmt::format("{:016x}", files::fnv1a(bytes));
}

void keep_one_row_per_refresh(recording::Recording& recording, const GateSettings& settings) {
  for (const HeldChannel& held : held_channels(gate_view(recording), settings)) {
    const auto c = std::find_if(recording.channels.begin(), recording.channels.end(),
                                [&](const auto& other) { return other.name == held.channel; });
    c->values = one_row_per_refresh(c->values, held.rows);
  }
}

/// What was read in rows that repeat the row before, though the motion went on, is none.
void leave_out_stale_rows(recording::Recording& recording, const GateSettings& settings) {
  const GateRecording view = gate_view(recording);
  const std::vector<char> stale = stale_rows(view, settings);
  if (stale.empty()) return;
  for (recording::Channel& c : recording.channels) {
    if (!is_reading(c.name)) continue;
    for (std::size_t k = 0; k < stale.size(); ++k)
      if (stale[k] != 0) c.values[k] = NAN;
  }
}

/// Where a position jumps one recording becomes several, each of them with its own starts; what was
/// cut is told.
void cut_at_jumps(LoadedRecordings& loaded, const std::vector<GateJoint>& joints,
                  const GateSettings& settings) {
  std::vector<recording::Recording> out;
  for (recording::Recording& r : loaded.recordings) {
    const std::vector<std::size_t> rows = position_jumps(gate_view(r), joints, settings);
    if (!rows.empty()) {
      loaded.gate.notes.push_back(
          fmt::format("{}: a position is elsewhere from one row to the next, {} times (first at "
                      "{:.4g} s); the recording is cut there",
                      r.file, rows.size(), r.t[rows.front()]));
    }
    for (recording::Recording& piece : cut_at(std::move(r), rows, settings))
      out.push_back(std::move(piece));
  }
  loaded.recordings = std::move(out);
}

const char* name_of(recording::ReadFault fault) {
  switch (fault) {
    case recording::ReadFault::unreadable:
      return defect::kUnreadable;
    case recording::ReadFault::too_large:
      return defect::kTooLarge;
    case recording::ReadFault::not_a_number:
      return defect::kNotANumber;
    case recording::ReadFault::missing_channel:
      return defect::kMissingChannel;
  }
  return defect::kUnreadable;
}

}  // namespace

GateRecording gate_view(const recording::Recording& recording) {
  GateRecording view{recording.file, recording.condition, recording.t, {}};
  for (const recording::Channel& c : recording.channels)
    view.channels.push_back({c.name, c.values});
  return view;
}

std::vector<GateJoint> gate_joints(const ModelFolder& model) {
  std::vector<GateJoint> joints;
  for (std::size_t j = 0; j < model.tree.joints.size(); ++j) {
    const TreeJoint& joint = model.tree.joints[j];
    const JointSettings& settings = model.joints[j];
    GateJoint g;
    g.name = joint.name;
    g.prismatic = joint.prismatic;
    if (joint.lower < joint.upper) g.lower = joint.lower, g.upper = joint.upper;
    g.torque_limit = settings.torque_limit;
    g.position_quantum = settings.position_quantum;
    if (settings.actuator == Actuator::dc_servo) {
      g.voltage = settings.voltage;
      g.speed_limit = settings.back_emf > 0.0 ? settings.voltage / settings.back_emf : 0.0;
      g.current_limit = settings.resistance > 0.0 ? settings.voltage / settings.resistance : 0.0;
      g.torque_limit = g.current_limit * settings.torque_constant;
    }
    joints.push_back(std::move(g));
  }
  return joints;
}

Defect defect_of(const files::InputError& error) {
  const auto* reading = dynamic_cast<const recording::ReadingError*>(&error);
  return {error.file, error.channel, error.line > 1 ? error.line - 2 : -1,
          reading != nullptr ? name_of(reading->fault) : error.defect, error.what()};
}

LoadedRecordings load_recordings(const std::vector<std::string>& files,
                                 const std::vector<GateJoint>& joints,
                                 const GateSettings& settings) {
  LoadedRecordings loaded;
  for (const std::string& file : files) {
    std::vector<Defect> defects = inspect_file(file, settings);
    if (defects.empty()) {
      try {
        loaded.recordings.push_back(recording::read_recording(file));
      } catch (const files::InputError& error) {
        defects.push_back(defect_of(error));
      }
    }
    std::move(defects.begin(), defects.end(), std::back_inserter(loaded.gate.defects));
  }
  // nothing left to judge, and each file has its reason
  if (loaded.recordings.empty() && !files.empty()) return loaded;
  std::vector<GateRecording> views;
  for (const recording::Recording& r : loaded.recordings) views.push_back(gate_view(r));
  GateReport report = inspect(views, joints, settings);
  // unreadable files first: they explain what else is missing
  report.defects.insert(report.defects.begin(), loaded.gate.defects.begin(),
                        loaded.gate.defects.end());
  if (files.empty())
    report.defects.push_back({"", "", -1, defect::kEmpty, "no recording was given"});
  for (const recording::Recording& r : loaded.recordings)
    if (r.cut)
      report.notes.push_back(r.file + ": the file was cut (its writer lost power, or still " +
                             "writes): " + std::to_string(r.rows()) + " complete rows are used");
  loaded.gate = std::move(report);
  loaded.hashes = data_hash(loaded.recordings);
  if (!loaded.gate.refused()) cut_at_jumps(loaded, joints, settings);
  for (recording::Recording& r : loaded.recordings) {
    leave_out_stale_rows(r, settings);
    keep_one_row_per_refresh(r, settings);
  }
  return loaded;
}

std::map<std::string, std::string> data_hash(const std::vector<recording::Recording>& recordings) {
  std::map<std::string, std::string> out;
  for (const recording::Recording& r : recordings) out[r.file] = hash_of(r);
  return out;
}

}  // namespace sanso::diagnose
