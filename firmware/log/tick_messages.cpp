// What a reader makes a row of, the joint states, comes last: everything else of the tick is known
// then.
#include "firmware/log/tick_messages.h"

#include <string>
#include <vector>

#include "shared/math/so3.h"
#include "shared/mcap/cdr.h"
#include "shared/mcap/ros_messages.h"
#include "shared/model/joints.h"
#include "shared/servo_bus/units.h"

namespace sanso::firmware {
namespace {

constexpr std::string_view kWorld = "world", kBase = "base_link";

/// What every message with a header carries behind its own fields.
constexpr std::string_view kHeaderParts =
    R"(================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
)";

constexpr std::string_view kOdometryType = "nav_msgs/msg/Odometry";
constexpr std::string_view kOdometry = R"(std_msgs/Header header
string child_frame_id
geometry_msgs/PoseWithCovariance pose
geometry_msgs/TwistWithCovariance twist
================================================================================
MSG: geometry_msgs/PoseWithCovariance
geometry_msgs/Pose pose
float64[36] covariance
================================================================================
MSG: geometry_msgs/Pose
geometry_msgs/Point position
geometry_msgs/Quaternion orientation
================================================================================
MSG: geometry_msgs/Point
float64 x
float64 y
float64 z
================================================================================
MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
================================================================================
MSG: geometry_msgs/TwistWithCovariance
geometry_msgs/Twist twist
float64[36] covariance
================================================================================
MSG: geometry_msgs/Twist
geometry_msgs/Vector3 linear
geometry_msgs/Vector3 angular
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
)";

constexpr std::string_view kTickType = "sanso_msgs/msg/Tick";
constexpr std::string_view kTick = R"(# One tick of the controller, 10 ms.
uint8 STATE_BOOT=0
uint8 STATE_SELF_TEST=1
uint8 STATE_IDLE=2
uint8 STATE_STAND_UP=3
uint8 STATE_HOLD=4
uint8 STATE_RUN=5
uint8 STATE_SOFT_STOP=6
uint8 STATE_FAULT=7
std_msgs/Header header
uint64 tick                 # since the program started
uint64 lost                 # ticks so far that no file holds: queue full, disk full
int32 trial_tick            # -1 outside a trial
uint32 trial_id
uint8 state
uint16 fault                # latched, 0 none; docs/faults.md
uint16 fault_detail         # servo id or count behind it
uint32 limits               # bit set, docs/faults.md
uint8 contact               # bit 0 right, bit 1 left sole loaded
uint8 pose_age_ticks        # 255 none
float32 max_temperature     # of all servos, C
uint32 upper_sequence
int16 upper_age_ticks
float32 upper_weight        # 1 full, 0 faded out
float64[12] u_upper         # the layers' shares of the goals, rad
float64[12] u_middle
float64[12] u_lower
float64[12] u_out           # sum after the guard, rad
int32[12] position_raw      # counts, as read
float64 tick_cpu            # s
uint32 late_ticks           # since the program started, as all that follow
uint32 bus_lost             # servo replies missing
uint32 bus_corrupt          # servo replies damaged
uint32 datagrams_dropped
)";

std::string with_header(std::string_view definition) {
  return std::string(definition) + std::string(kHeaderParts);
}

/// ROS's order: x y z w.
void put_quaternion(mcap::CdrWriter& out, const double* w_x_y_z) {
  for (const int k : {1, 2, 3, 0}) out.number(w_x_y_z[k]);
}

std::string odometry(const wire::Observation& o) {
  constexpr double kUnknown[36] = {};
  mcap::CdrWriter out;
  out.header(to_seconds(o.time), kWorld);
  out.string(kBase);
  for (int a = 0; a < 3; ++a) out.number(o.x[model::kXPos + a]);
  put_quaternion(out, &o.x[model::kXQuat]);
  out.array(kUnknown);
  const math::Quat quat_world_base = o.x.segment<4>(model::kXQuat);
  const math::Vec3 v_base_in_world = o.x.segment<3>(model::kXVel);
  const math::Vec3 v_base_in_base =
      math::rotation_matrix(quat_world_base).transpose() * v_base_in_world;
  for (int a = 0; a < 3; ++a) out.number(v_base_in_base[a]);
  for (int a = 0; a < 3; ++a) out.number(o.x[model::kXVel + 3 + a]);
  out.array(kUnknown);
  return out.bytes();
}

std::string imu(const wire::Observation& o) {
  constexpr double kUnknown[9] = {};
  mcap::CdrWriter out;
  out.header(to_seconds(o.time), kBase);
  put_quaternion(out, &o.x[model::kXQuat]);
  out.array(kUnknown);
  out.array(o.imu_gyro);
  out.array(kUnknown);
  out.array(o.imu_acc);
  out.array(kUnknown);
  return out.bytes();
}

std::string tick(const LogRecord& record, std::uint64_t lost) {
  const wire::Observation& o = record.observation;
  mcap::CdrWriter out;
  out.header(to_seconds(o.time), kBase);
  out.number(o.tick);
  out.number(lost);
  out.number(o.trial_tick);
  out.number(o.trial_id);
  out.number(static_cast<std::uint8_t>(o.state));
  out.number(o.fault);
  out.number(record.fault_detail);
  out.number(o.limits);
  out.number(o.contact);
  out.number(o.pose_age_ticks);
  out.number(o.max_temperature_C);
  out.number(o.upper_sequence);
  out.number(o.upper_age_ticks);
  out.number(o.upper_weight);
  for (const model::Input* u : {&o.u_upper, &o.u_middle, &o.u_lower, &o.u_out})
    out.array({u->data(), static_cast<std::size_t>(u->size())});
  for (const std::int32_t raw : record.position_raw) out.number(raw);
  out.number(1e-9 * o.tick_cpu_ns);
  out.number(o.late_ticks);
  out.number(o.bus_lost);
  out.number(o.bus_corrupt);
  out.number(o.datagrams_dropped);
  return out.bytes();
}

std::uint16_t joint_topic(mcap::Writer& out, const char* topic) {
  return out.add_channel(topic, std::string(mcap::kJointStateType), mcap::joint_state_definition());
}

}  // namespace

TickMessages::TickMessages(mcap::Writer& out)
    : out_(out),
      states_(joint_topic(out, "/joint_states")),
      commands_(joint_topic(out, "/joint_commands")),
      currents_(joint_topic(out, "/joint_currents")),
      supply_(joint_topic(out, "/supply_voltage")),
      imu_(out.add_channel("/imu", std::string(mcap::kImuType), mcap::imu_definition())),
      odometry_(out.add_channel("/odom", std::string(kOdometryType), with_header(kOdometry))),
      tick_(out.add_channel("/tick", std::string(kTickType), with_header(kTick))) {}

void TickMessages::write_joints(std::uint16_t channel, const wire::Observation& o,
                                const double* position, const double* velocity) {
  mcap::JointState message;
  message.stamp_s = to_seconds(o.time);
  for (const model::JointInfo& joint : model::kJoints) message.name.emplace_back(joint.name);
  message.position.assign(position, position + model::kNumJoints);
  if (velocity != nullptr) message.velocity.assign(velocity, velocity + model::kNumJoints);
  out_.write(channel, static_cast<std::uint64_t>(o.time), mcap::encode(message));
}

void TickMessages::write(const LogRecord& record, std::uint64_t lost) {
  const wire::Observation& o = record.observation;
  const auto time = static_cast<std::uint64_t>(o.time);
  write_joints(commands_, o, o.u_out.data(), nullptr);
  std::array<double, model::kNumJoints> current{};
  for (std::size_t j = 0; j < current.size(); ++j)
    current[j] = servo_bus::current_A(o.current_raw[j]);
  write_joints(currents_, o, current.data(), nullptr);
  out_.write(supply_, time,
             mcap::encode(mcap::JointState{
                 to_seconds(o.time), {"supply"}, {static_cast<double>(o.voltage_V)}, {}, {}}));
  out_.write(imu_, time, imu(o));
  out_.write(odometry_, time, odometry(o));
  out_.write(tick_, time, tick(record, lost));
  write_joints(states_, o, &o.x[model::kXJoint], &o.x[model::kXJointRate]);
}

}  // namespace sanso::firmware
