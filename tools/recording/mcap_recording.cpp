// One row a message of the joints' state; what a message becomes is ros_rows.h's.
#include "tools/recording/mcap_recording.h"

#include "tools/recording/csv_reader.h"
#include "tools/recording/mcap_file.h"
#include "tools/recording/ros_rows.h"
#include "tools/recording/rosbag_db3.h"

namespace sanso::recording {

Recording read_mcap(const std::string& path, std::size_t max_values) {
  Recording recording;
  recording.file = path;
  RosRows rows(recording, max_values);
  recording.cut = !read_mcap_messages(
      path, [&](const McapChannel& channel, std::uint64_t, std::string_view bytes) {
        if (RosRows::reads(channel.schema))
          rows.take(channel.topic, channel.schema, channel.encoding, bytes);
      });
  rows.finish();
  return recording;
}

Recording read_recording(const std::string& path) {
  if (path.ends_with(".mcap")) return read_mcap(path);
  return path.ends_with(".db3") ? read_db3(path) : read_csv(path);
}

}  // namespace sanso::recording
