// The flight recorder: the last minute of ticks in memory, and on a fault the record of what led to
// it in a file. Runs in the log thread; the tick only pushes records into a queue.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "firmware/exchange/handover.h"

namespace sanso::firmware {

class FlightRecorder {
 public:
  static constexpr std::size_t kTicksKept = 6000;  // a minute
  static constexpr int kTicksAfterFault = 50;      // what happened next belongs to the record

  /// `directory`: where records go; empty: only memory. Files are named after fault, `boot` (one
  /// word that no other boot has) and time, so that none replaces another.
  FlightRecorder(Handover& handover, std::string directory, std::string boot);

  /// Takes what the tick has pushed, passing each record on; writes a file when a fault is half a
  /// second old. True when it wrote one.
  bool poll(const std::function<void(const LogRecord&)>& also = {});
  /// Oldest first.
  std::vector<LogRecord> records() const;
  /// The newest record; a default one before the first.
  LogRecord newest() const { return ring_[(next_ + kTicksKept - 1) % kTicksKept]; }
  /// Path of the last file written, empty before; why the newest one could not be written in
  /// `error()`, empty when it was.
  const std::string& last_file() const { return last_file_; }
  const std::string& error() const { return error_; }
  /// Writes all records to `path` (CSV, one row a tick). False: error() says why.
  bool write(const std::string& path);

 private:
  std::string text() const;

  Handover& handover_;
  std::string directory_, boot_;
  std::vector<LogRecord> ring_;  // allocated once
  std::size_t next_ = 0, count_ = 0;
  std::uint16_t latched_ = 0;
  int until_write_ = -1;
  // of the record to write: fault and tick that began it, which may be cleared before it is written
  std::string name_;
  std::string last_file_, error_;
};

}  // namespace sanso::firmware
