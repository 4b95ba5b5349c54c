// The black box: every tick as ROS 2 messages in MCAP files, which Foxglove, PlotJuggler and our
// own tools open. Runs in the log thread; may block and allocate. Packed and handed to the system
// every fifth of a second, on a fault at once, flushed to the disk every second: a killed program
// loses the newest fifth, a power cut the newest second. A file that was cut is readable.
//
//   topic             message                  holds
//   /joint_states     sensor_msgs/JointState   angles and rates as estimated, legs
//   /joint_commands   sensor_msgs/JointState   goals as sent to the servos, legs
//   /joint_currents   sensor_msgs/JointState   motor currents (position), A
//   /supply_voltage   sensor_msgs/JointState   V (position)
//   /imu              sensor_msgs/Imu          base axes; orientation as estimated
//   /odom             nav_msgs/Odometry        base pose and twist as estimated
//   /tick             sanso_msgs/Tick          state, fault, limits, layers, counters
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "firmware/exchange/record.h"
#include "shared/mcap/writer.h"

namespace sanso::firmware {

struct BlackBoxLimits {
  std::uint64_t file_bytes = 64u << 20;   // a larger file is closed, the next one begun
  Nanoseconds file_time = 600 * kSecond;  // an older one too
  std::uint64_t keep_bytes = 1u << 30;    // all files together; the oldest go first
};

class BlackBox {
 public:
  /// Files are `directory`/`boot`-NNNN.mcap, NNNN counting on from what is there; none when
  /// `directory` is empty. `about`: written in front of every file.
  BlackBox(std::filesystem::path directory, std::string boot, BlackBoxLimits limits,
           std::map<std::string, std::string> about);
  ~BlackBox();
  BlackBox(const BlackBox&) = delete;
  BlackBox& operator=(const BlackBox&) = delete;

  /// One tick. Never throws: what cannot be written is counted, error() says why, and another file
  /// is tried ten seconds later.
  void take(const LogRecord& record);
  /// Writes the index and closes the file; the next take() begins another.
  void close();

  const std::filesystem::path& file() const { return path_; }  // the newest; empty: none yet
  const std::string& error() const { return error_; }          // empty: the newest tick is written
  std::uint64_t lost() const { return lost_; }  // ticks that no file holds, the queue's among them

 private:
  struct OpenFile;
  void write_tick(const LogRecord& record);
  void open(Nanoseconds now);
  void finish();
  void prune() const;
  void fail(const std::string& why, Nanoseconds now);

  std::filesystem::path directory_;
  std::string boot_;
  BlackBoxLimits limits_;
  std::map<std::string, std::string> about_;
  std::unique_ptr<OpenFile> open_;
  std::filesystem::path path_;
  int number_ = 0;
  Nanoseconds retry_ = 0;
  std::uint64_t lost_ = 0, lost_here_ = 0;
  std::uint16_t fault_ = 0;
  std::string error_;
};

/// The running kernel's boot, eight hexadecimal digits; "00000000" where it has none.
std::string boot_name();

}  // namespace sanso::firmware
