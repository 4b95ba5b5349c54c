// CDR with its alignment rules, and the schemas as text that the files carry; a message that
// ends early decodes to nothing.
#include "tools/recording/ros_messages.h"

#include <cmath>

#include "shared/files/bytes.h"

namespace sanso::recording {
namespace {

constexpr std::uint32_t kMaxJointNames = 10'000;

/// Alignment counts from after the four bytes of encapsulation.
class CdrReader {
 public:
  explicit CdrReader(std::string_view cdr)
      : in_(cdr.size() >= 4 ? cdr.substr(4) : std::string_view()) {
    good_ = cdr.size() >= 4 && cdr[0] == 0 && cdr[1] == 1;  // CDR_LE
  }
  bool ok() const { return good_ && in_.ok(); }
  template <class T>
  T number() {
    in_.align(sizeof(T));
    return in_.number<T>();
  }
  std::string string() {
    std::string_view s = in_.take(number<std::uint32_t>());
    if (!s.empty() && s.back() == '\0') s.remove_suffix(1);
    return std::string(s);
  }
  std::uint32_t count() {
    const auto n = number<std::uint32_t>();
    if (n > kMaxJointNames) good_ = false;
    return good_ ? n : 0;
  }
  std::vector<double> doubles() {
    std::vector<double> values;
    for (std::uint32_t k = count(); k > 0 && ok(); --k) values.push_back(number<double>());
    return values;
  }
  double stamp() {
    const auto seconds = number<std::int32_t>();
    return seconds + 1e-9 * number<std::uint32_t>();
  }

 private:
  files::ByteReader in_;
  bool good_;
};

class CdrWriter {
 public:
  template <class T>
  void number(T value) {
    out_.align(sizeof(T));
    out_.number(value);
  }
  void string(std::string_view text) {
    number(static_cast<std::uint32_t>(text.size() + 1));
    out_.raw(text);
    out_.raw(std::string_view("\0", 1));
  }
  void doubles(const std::vector<double>& values) {
    number(static_cast<std::uint32_t>(values.size()));
    for (double v : values) number(v);
  }
  void header(double stamp_s) {
    const double seconds = std::floor(stamp_s);
    auto nanoseconds = static_cast<std::uint32_t>(std::lround((stamp_s - seconds) * 1e9));
    const std::uint32_t carry = nanoseconds >= 1'000'000'000u ? 1 : 0;
    number(static_cast<std::int32_t>(seconds) + static_cast<std::int32_t>(carry));
    number(nanoseconds - carry * 1'000'000'000u);
    string("");
  }
  std::string bytes() const { return std::string("\0\1\0\0", 4) + out_.bytes(); }

 private:
  files::ByteWriter out_;
};

}  // namespace

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

}  // namespace sanso::recording
