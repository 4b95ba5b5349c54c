// CDR with its alignment rules, and the schemas as text that the files carry; a message that
// ends early decodes to nothing.
#include "shared/mcap/ros_messages.h"

#include "shared/mcap/cdr.h"

namespace sanso::mcap {
std::optional<JointState> decode_joint_state(std::string_view cdr) {
  CdrReader in(cdr);
  JointState m;
  m.stamp_s = in.stamp();
  in.string();  // frame_id
  for (std::uint32_t k = in.count(); k > 0 && in.ok(); --k) m.name.push_back(in.string());
  m.position = in.doubles();
  m.velocity = in.doubles();
  m.effort = in.doubles();
  if (!in.ok()) return std::nullopt;
  return m;
}

std::optional<Imu> decode_imu(std::string_view cdr) {
  CdrReader in(cdr);
  Imu m;
  m.stamp_s = in.stamp();
  in.string();
  // x y z w in the message
  for (std::size_t k : {1u, 2u, 3u, 0u}) m.orientation[k] = in.number<double>();
  for (int k = 0; k < 9; ++k) in.number<double>();
  for (double& w : m.angular_velocity) w = in.number<double>();
  for (int k = 0; k < 9; ++k) in.number<double>();
  for (double& a : m.linear_acceleration) a = in.number<double>();
  for (int k = 0; k < 9; ++k) in.number<double>();
  if (!in.ok()) return std::nullopt;
  return m;
}

std::string encode(const JointState& m) {
  CdrWriter out;
  out.header(m.stamp_s);
  out.number(static_cast<std::uint32_t>(m.name.size()));
  for (const std::string& name : m.name) out.string(name);
  out.doubles(m.position);
  out.doubles(m.velocity);
  out.doubles(m.effort);
  return out.bytes();
}

std::string encode(const Imu& m) {
  CdrWriter out;
  out.header(m.stamp_s);
  for (std::size_t k : {1u, 2u, 3u, 0u}) out.number(m.orientation[k]);
  for (int k = 0; k < 9; ++k) out.number(0.0);
  for (double w : m.angular_velocity) out.number(w);
  for (int k = 0; k < 9; ++k) out.number(0.0);
  for (double a : m.linear_acceleration) out.number(a);
  for (int k = 0; k < 9; ++k) out.number(0.0);
  return out.bytes();
}

std::string_view joint_state_definition() {
  return "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\n"
         "float64[] effort\n"
         "================================================================================\n"
         "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
         "================================================================================\n"
         "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";
}

std::string_view imu_definition() {
  return "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\nfloat64[9] "
         "orientation_covariance\n"
         "geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n"
         "geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance\n"
         "================================================================================\n"
         "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
         "================================================================================\n"
         "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
         "================================================================================\n"
         "MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"
         "================================================================================\n"
         "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n";
}

}  // namespace sanso::mcap
