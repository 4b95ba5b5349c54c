// Writes a black box and an exported recording for the npm reader, and what it has to find in them.
// Usage: mcap_samples FOLDER
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>

#include "firmware/log/black_box.h"
#include "tests/support/write_mcap.h"
#include "tools/export/trial_mcap.h"
#include "tools/recording/mcap_file.h"

namespace {

using namespace sanso;
namespace fs = std::filesystem;

constexpr int kTicks = 30;  // small: the file is read cut at every byte

fs::path write_box(const fs::path& folder) {
  firmware::BlackBox box(folder, "0badb007", {}, {{"robot", "test"}});
  for (int k = 1; k <= kTicks; ++k) {
    firmware::LogRecord record;
    wire::Observation& o = record.observation;
    o.tick = static_cast<std::uint64_t>(k);
    o.time = k * kTickPeriod;
    o.state = wire::SupervisorState::fault;
    o.fault = 30;
    o.x[model::kXQuat] = 0.6;
    o.x[model::kXQuat + 3] = 0.8;
    o.x[model::kXJoint + 3] = 0.7 + 0.01 * (k - 1);
    o.u_out[3] = 0.5;
    o.u_upper[3] = 0.25;
    o.u_lower[11] = -0.125;
    o.imu_acc = {0, 0.5, 9.81};
    o.datagrams_dropped = 5;
    record.position_raw[11] = 2048;
    record.dropped = 2;
    box.take(record);
  }
  box.close();
  return box.file();
}

void write_export(const fs::path& file) {
  recording::Recording r;
  std::vector<double> q;
  for (int k = 0; k < 5000; ++k) r.t.push_back(0.005 * k), q.push_back(std::sin(0.005 * k));
  r.set("q:knee", q);
  r.set("u:knee", q);
  r.set("imu_acc:z", std::vector<double>(5000, 9.81));
  recording::write_mcap(r, file);
}

/// A trial in which a knee is bent, one foot carries more than the other, and a plan was late.
void write_trial(const fs::path& file) {
  learn::Episode episode;
  for (int k = 0; k < kTicks; ++k) {
    wire::Observation o;
    o.time = (k + 1) * kTickPeriod;
    o.trial_tick = k;
    o.x[model::kXJoint + 3] = 0.7;
    episode.ticks.push_back(o);
    episode.reference.emplace_back();
    learn::TrueSample truth;
    truth.foot_load_N = {12.5F, 18.0F};
    episode.truth.push_back(truth);
  }
  learn::PlanRecord plan;
  plan.policy.sequence = 4;
  plan.observed_tick = 6;
  plan.late = 1;
  plan.policy.knots.try_resize(2);
  plan.policy.knots[1].u[3] = 0.25;
  episode.plans.push_back(plan);
  exports::write_trial_mcap(episode, file);
}

/// Joint states that our own reader finds in the file cut at every size, from the magic bytes on.
std::string rows_of_cuts(const fs::path& box, const fs::path& scratch) {
  fs::copy_file(box, scratch);
  std::string rows;
  for (std::uintmax_t size = fs::file_size(box); size-- > 8;) {
    fs::resize_file(scratch, size);
    int found = 0;
    (void)recording::read_mcap_messages(
        scratch, [&](const recording::McapChannel& channel, std::uint64_t, std::string_view) {
          found += channel.topic == "/joint_states" ? 1 : 0;
        });
    rows = std::to_string(found) + (rows.empty() ? "" : ",") + rows;
  }
  fs::remove(scratch);
  return rows;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const fs::path folder = argv[1];
  fs::rename(write_box(folder), folder / "box.mcap");
  write_export(folder / "export.mcap");
  write_trial(folder / "trial.mcap");
  std::FILE* out = std::fopen((folder / "expected.json").c_str(), "w");
  if (out == nullptr) return 2;
  std::fprintf(out, "{\"knee\": 0.7, \"command\": 0.5, \"files\": {\"box.mcap\": {");
  const char* comma = "";
  for (const char* topic : {"/joint_states", "/joint_commands", "/joint_currents",
                            "/supply_voltage", "/imu", "/odom", "/tick"}) {
    std::fprintf(out, "%s\"%s\": %d", comma, topic, kTicks);
    comma = ", ";
  }
  std::fprintf(out,
               "}, \"export.mcap\": {\"/joint_states\": 5000, \"/joint_commands\": 5000, "
               "\"/imu\": 5000}, \"trial.mcap\": {\"/robot_description\": 1, \"/policy\": 1, "
               "\"/tf\": %d, \"/reference\": %d, \"/foot_wrench/right\": %d, "
               "\"/foot_wrench/left\": %d, \"/joint_states\": %d, \"/joint_commands\": %d, "
               "\"/joint_currents\": %d, \"/supply_voltage\": %d, \"/imu\": %d, \"/odom\": %d, "
               "\"/tick\": %d}}, \"rows_of_cut\": [%s]}\n",
               kTicks, kTicks, kTicks, kTicks, kTicks, kTicks, kTicks, kTicks, kTicks, kTicks,
               kTicks, rows_of_cuts(folder / "box.mcap", folder / "cut.mcap").c_str());
  return std::fclose(out) == 0 ? 0 : 2;
}
