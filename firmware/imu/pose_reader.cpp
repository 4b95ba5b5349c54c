// Decodes whatever comes until the deadline; a report that does not decode is counted and
// forgotten.
#include "firmware/imu/pose_reader.h"

#include <array>

#include "shared/base/pose_report.h"

namespace sanso::firmware {

Status PoseReader::poll(Nanoseconds deadline) {
  if (source_ == nullptr) return Status::ok;
  std::array<std::uint8_t, 64> bytes;
  for (int i = 0; i < kMaxReportsAtOnce; ++i) {
    const Result<std::size_t> n = source_->read(bytes, i == 0 ? deadline : 0);
    if (!n.ok()) return n.status();
    if (*n == 0) break;
    const Result<PoseReport> report = decode_pose_report(std::span(bytes).first(*n));
    if (!report.ok()) continue;
    const auto& p = report->p_world_base;
    const auto& q = report->quat_world_base;
    const auto& v = report->v_base_in_world;
    PoseSample& sample = out_.back();
    sample.time = clock_.now() - report->age_us * kMicrosecond;
    sample.sequence = ++samples_;  // the tick asks only whether it is new
    sample.confidence = report->confidence;
    sample.p_track_base = {p[0], p[1], p[2]};
    sample.quat_track_base = math::quat_normalized({q[0], q[1], q[2], q[3]});
    sample.v_base_in_track = {v[0], v[1], v[2]};
    out_.publish();
  }
  return Status::ok;
}

}  // namespace sanso::firmware
