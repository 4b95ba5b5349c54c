// The controller's own topics come from the code that writes its black box; here are the others.
#include "tools/export/trial_mcap.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include "firmware/log/tick_messages.h"
#include "shared/files/atomic_file.h"
#include "shared/mcap/cdr.h"
#include "shared/mcap/ros_messages.h"
#include "shared/model/joints.h"
#include "tools/emulator/emulated_robot.h"
#include "tools/export/op3_urdf.h"
#include "tools/plant/body_data.h"

namespace sanso::exports {
namespace {

constexpr std::string_view kLine =
    "================================================================================\n";
constexpr std::string_view kHeader =
    "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n";
constexpr std::string_view kTime = "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";
constexpr std::string_view kVector3 =
    "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n";
constexpr std::string_view kQuaternion =
    "MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n";

std::string definition(std::string_view head, std::initializer_list<std::string_view> parts) {
  std::string out(head);
  for (const std::string_view part : parts) out.append(kLine).append(part);
  return out;
}

std::string tf_definition() {
  return definition("geometry_msgs/TransformStamped[] transforms\n",
                    {"MSG: geometry_msgs/TransformStamped\nstd_msgs/Header header\n"
                     "string child_frame_id\ngeometry_msgs/Transform transform\n",
                     kHeader, kTime,
                     "MSG: geometry_msgs/Transform\ngeometry_msgs/Vector3 translation\n"
                     "geometry_msgs/Quaternion rotation\n",
                     kVector3, kQuaternion});
}

std::string wrench_definition() {
  return definition("std_msgs/Header header\ngeometry_msgs/Wrench wrench\n",
                    {kHeader, kTime,
                     "MSG: geometry_msgs/Wrench\ngeometry_msgs/Vector3 force\n"
                     "geometry_msgs/Vector3 torque\n",
                     kVector3});
}

std::string policy_definition() {
  return definition(
      "# One answer of the upper layer, as it was sent: knots of input and state.\n"
      "std_msgs/Header header\n"
      "uint32 sequence\n"
      "int32 observed_tick         # of the trial, that it was planned from\n"
      "int32 first_tick            # of the trial, of its first knot\n"
      "int32 ticks_per_knot\n"
      "float64 update_ms           # from observation to answer\n"
      "float64 cost_before         # predicted without the upper layer\n"
      "float64 cost_after\n"
      "float64 gain_norm           # of the first knot's gain\n"
      "uint8 late                  # 1: came after its first tick\n"
      "float64[] u                 # rad, 12 a knot\n"
      "float64[] x                 # 37 a knot, docs/conventions.md\n",
      {kHeader, kTime});
}

struct Transform {
  std::string parent, child;
  std::array<double, 3> p{};
  std::array<double, 4> w_x_y_z{1, 0, 0, 0};
};

void put(mcap::CdrWriter& out, double stamp_s, const Transform& t) {
  out.header(stamp_s, t.parent);
  out.string(t.child);
  for (const double v : t.p) out.number(v);
  for (const std::size_t k : {1u, 2u, 3u, 0u}) out.number(t.w_x_y_z[k]);
}

/// A link turned by `angle` about its joint's axis.
Transform turned(const plant::JointData& joint, double angle) {
  Transform t{joint.parent, joint.child, {}, {std::cos(0.5 * angle), 0, 0, 0}};
  for (std::size_t k = 0; k < 3; ++k) {
    t.p[k] = joint.origin_m[k];
    t.w_x_y_z[k + 1] = std::sin(0.5 * angle) * joint.axis[k];
  }
  return t;
}

/// Angle of a joint: of the legs as estimated, of arms and head as they are put down.
double angle_of(const plant::JointData& joint, const wire::Observation& o) {
  for (std::size_t j = 0; j < model::kJoints.size(); ++j)
    if (joint.name == model::kJoints[j].name) return o.x[model::kXJoint + static_cast<int>(j)];
  static const emulator::Placement kStanding = emulator::walkready();
  return kStanding.q.at(static_cast<std::size_t>(joint.servo_id - 1));
}

std::string tf(const wire::Observation& o) {
  const std::vector<plant::JointData>& joints = plant::op3_body().joints;
  mcap::CdrWriter out;
  out.number(static_cast<std::uint32_t>(joints.size() + 2));
  Transform base{"world", "base_link", {}, {}};
  for (std::size_t k = 0; k < 3; ++k) base.p[k] = o.x[model::kXPos + static_cast<int>(k)];
  for (std::size_t k = 0; k < 4; ++k) base.w_x_y_z[k] = o.x[model::kXQuat + static_cast<int>(k)];
  const double stamp_s = to_seconds(o.time);
  put(out, stamp_s, base);
  put(out, stamp_s, {"base_link", "body_link", {}, {1, 0, 0, 0}});
  for (const plant::JointData& joint : joints) put(out, stamp_s, turned(joint, angle_of(joint, o)));
  return out.bytes();
}

std::string wrench(double stamp_s, std::string_view foot, double force_z) {
  mcap::CdrWriter out;
  out.header(stamp_s, foot);
  for (const double v : {0.0, 0.0, force_z, 0.0, 0.0, 0.0}) out.number(v);
  return out.bytes();
}

std::string policy(double stamp_s, const learn::PlanRecord& plan) {
  std::vector<double> u, x;
  for (const policy::Knot& knot : plan.policy.knots) {
    u.insert(u.end(), knot.u.begin(), knot.u.end());
    x.insert(x.end(), knot.x.begin(), knot.x.end());
  }
  mcap::CdrWriter out;
  out.header(stamp_s);
  out.number(static_cast<std::uint32_t>(plan.policy.sequence));
  out.number(static_cast<std::int32_t>(plan.observed_tick));
  out.number(static_cast<std::int32_t>(plan.policy.first_tick));
  out.number(static_cast<std::int32_t>(plan.policy.ticks_per_knot));
  for (const double v : {plan.update_ms, plan.cost_before, plan.cost_after, plan.gain_norm})
    out.number(v);
  out.number(plan.late);
  out.doubles(u);
  out.doubles(x);
  return out.bytes();
}

std::string reference(double stamp_s, const std::array<float, model::kNx>& x) {
  mcap::JointState message;
  message.stamp_s = stamp_s;
  for (int j = 0; j < model::kNumJoints; ++j) {
    message.name.emplace_back(model::kJoints[static_cast<std::size_t>(j)].name);
    message.position.push_back(x[static_cast<std::size_t>(model::kXJoint + j)]);
    message.velocity.push_back(x[static_cast<std::size_t>(model::kXJointRate + j)]);
  }
  return mcap::encode(message);
}

/// The topics beside those of the black box.
class TrialTopics {
 public:
  explicit TrialTopics(mcap::Writer& out)
      : out_(out),
        description_(out.add_channel("/robot_description", "std_msgs/msg/String", "string data\n")),
        tf_(out.add_channel("/tf", "tf2_msgs/msg/TFMessage", tf_definition())),
        reference_(out.add_channel("/reference", std::string(mcap::kJointStateType),
                                   mcap::joint_state_definition())),
        policy_(out.add_channel("/policy", "sanso_msgs/msg/UpperPolicy", policy_definition())) {
    const std::string type = "geometry_msgs/msg/WrenchStamped", text = wrench_definition();
    feet_ = {out.add_channel("/foot_wrench/right", type, text),
             out.add_channel("/foot_wrench/left", type, text)};
  }

  void describe(std::uint64_t time) {
    mcap::CdrWriter urdf;
    urdf.string(op3_urdf());
    out_.write(description_, time, urdf.bytes());
  }
  void write_tick(const learn::Episode& episode, std::size_t i) {
    const wire::Observation& o = episode.ticks[i];
    const auto time = static_cast<std::uint64_t>(o.time);
    out_.write(tf_, time, tf(o));
    if (i < episode.reference.size())
      out_.write(reference_, time, reference(to_seconds(o.time), episode.reference[i]));
    if (i >= episode.truth.size()) return;
    constexpr std::array<std::string_view, 2> kFeet{"r_ank_roll_link", "l_ank_roll_link"};
    for (std::size_t foot = 0; foot < 2; ++foot)
      out_.write(feet_[foot], time,
                 wrench(to_seconds(o.time), kFeet[foot],
                        static_cast<double>(episode.truth[i].foot_load_N[foot])));
  }
  void write_plan(std::uint64_t time, const learn::PlanRecord& plan) {
    out_.write(policy_, time, policy(1e-9 * static_cast<double>(time), plan));
  }

 private:
  mcap::Writer& out_;
  std::uint16_t description_, tf_, reference_, policy_;
  std::array<std::uint16_t, 2> feet_{};
};

}  // namespace

std::uint64_t write_trial_mcap(const learn::Episode& episode, const std::filesystem::path& file) {
  if (episode.ticks.empty())
    throw std::runtime_error(file.string() + ": this trial holds no tick: " +
                             learn::to_string(episode.end) + "; export another one");
  std::string bytes;
  mcap::Writer out([&](std::string_view more) { bytes.append(more); });
  out.add_metadata("sanso", {{"trial", std::to_string(episode.trial + 1)},
                             {"cost", std::to_string(episode.cost)},
                             {"end", learn::to_string(episode.end)},
                             {"seed", std::to_string(episode.seed)}});
  firmware::TickMessages tick_topics(out);
  TrialTopics topics(out);
  topics.describe(static_cast<std::uint64_t>(episode.ticks.front().time));
  std::size_t next_plan = 0;
  for (std::size_t i = 0; i < episode.ticks.size(); ++i) {
    const wire::Observation& o = episode.ticks[i];
    firmware::LogRecord record;
    record.observation = o;
    for (;
         next_plan < episode.plans.size() && episode.plans[next_plan].observed_tick <= o.trial_tick;
         ++next_plan)
      topics.write_plan(static_cast<std::uint64_t>(o.time), episode.plans[next_plan]);
    topics.write_tick(episode, i);
    tick_topics.write(record, 0);
  }
  out.finish();
  files::write_atomically(file, bytes);
  return out.messages();
}

}  // namespace sanso::exports
