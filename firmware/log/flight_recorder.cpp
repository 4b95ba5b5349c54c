// A ring of the newest records; on a fault it is written as CSV to a temporary file that is
// renamed when it is whole. May block and allocate.
#include "firmware/log/flight_recorder.h"

#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <new>

#include "shared/files/atomic_file.h"
#include "shared/model/joints.h"

namespace sanso::firmware {
namespace {

void write_header(std::FILE* file) {
  std::fprintf(file,
               "t,tick,state,fault,fault_detail,limits,trial_tick,tick_cpu_us,late_ticks,bus_lost,"
               "bus_corrupt,volt");
  for (const char* axis : {"x", "y", "z"}) std::fprintf(file, ",base_p:%s", axis);
  for (const char* part : {"w", "x", "y", "z"}) std::fprintf(file, ",base_q:%s", part);
  for (const char* what : {"base_v", "base_w"})
    for (const char* axis : {"x", "y", "z"}) std::fprintf(file, ",%s:%s", what, axis);
  for (const char* what : {"q", "dq", "u", "i"})
    for (const model::JointInfo& joint : model::kJoints)
      std::fprintf(file, ",%s:%s", what, joint.name);
  for (const char* axis : {"x", "y", "z"}) std::fprintf(file, ",imu_acc:%s", axis);
  std::fprintf(file, "\n");
}

void write_row(std::FILE* file, const LogRecord& record) {
  const wire::Observation& o = record.observation;
  std::fprintf(file, "%.6f,%" PRIu64 ",%d,%d,%d,%u,%d,%.1f,%u,%u,%u,%.1f", to_seconds(o.time),
               o.tick, static_cast<int>(o.state), o.fault, record.fault_detail, o.limits,
               o.trial_tick, o.tick_cpu_ns * 1e-3, o.late_ticks, o.bus_lost, o.bus_corrupt,
               static_cast<double>(o.voltage_V));
  for (int i = 0; i < 7; ++i) std::fprintf(file, ",%.6f", o.x[i]);
  for (int i = 0; i < 6; ++i) std::fprintf(file, ",%.6f", o.x[model::kXVel + i]);
  for (int first : {model::kXJoint, model::kXJointRate})
    for (int j = 0; j < model::kNumJoints; ++j) std::fprintf(file, ",%.6f", o.x[first + j]);
  for (int j = 0; j < model::kNumJoints; ++j) std::fprintf(file, ",%.6f", o.u_out[j]);
  for (const std::int16_t current : o.current_raw) std::fprintf(file, ",%.5f", current * 2.69e-3);
  for (const double a : o.imu_acc) std::fprintf(file, ",%.5f", a);
  std::fprintf(file, "\n");
}

}  // namespace

FlightRecorder::FlightRecorder(Handover& handover, std::string directory, std::string boot)
    : handover_(handover),
      directory_(std::move(directory)),
      boot_(std::move(boot)),
      ring_(kTicksKept) {}

bool FlightRecorder::poll(const std::function<void(const LogRecord&)>& also) {
  LogRecord record;
  bool due = false;
  while (handover_.log.pop(record)) {
    if (also) also(record);
    ring_[next_] = record;
    next_ = (next_ + 1) % kTicksKept;
    if (count_ < kTicksKept) ++count_;
    const std::uint16_t fault = record.observation.fault;
    if (fault != 0 && latched_ == 0) {
      until_write_ = kTicksAfterFault;
      name_ = "F" + std::to_string(fault) + "-" + boot_ + "-" +
              std::to_string(record.observation.time / kMillisecond) + "ms.csv";
    }
    latched_ = fault;
    if (until_write_ >= 0 && until_write_-- == 0) due = true;
  }
  if (!due || directory_.empty()) return false;
  return write(directory_ + "/" + name_);
}

std::vector<LogRecord> FlightRecorder::records() const {
  std::vector<LogRecord> out;
  out.reserve(count_);
  for (std::size_t i = 0; i < count_; ++i)
    out.push_back(ring_[(next_ + kTicksKept - count_ + i) % kTicksKept]);
  return out;
}

std::string FlightRecorder::text() const {
  char* bytes = nullptr;
  std::size_t size = 0;
  std::FILE* stream = ::open_memstream(&bytes, &size);
  if (stream == nullptr) throw std::bad_alloc();
  write_header(stream);
  for (const LogRecord& record : records()) write_row(stream, record);
  const bool whole = std::fclose(stream) == 0;
  const std::unique_ptr<char, decltype(&std::free)> owned(bytes, std::free);
  if (!whole) throw std::bad_alloc();
  return {owned.get(), size};
}

bool FlightRecorder::write(const std::string& path) {
  try {
    files::write_atomically(path, text());
  } catch (const std::exception& error) {
    error_ = path + ": the flight record cannot be written: " + error.what() +
             "; it is lost; look at device.log_directory";
    return false;
  }
  last_file_ = path;
  error_.clear();
  return true;
}

}  // namespace sanso::firmware
