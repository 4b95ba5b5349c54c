// Reads the rows, turns y up into z up, and keeps hips, knees, ankles and root only; a row of
// wrong length is an error with its number.
#include "host/motion/mocap/deepmimic.h"

#include <Eigen/Geometry>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "shared/files/atomic_file.h"
#include "shared/files/input_error.h"

namespace sanso::motion {
namespace {

// Skeleton of the format's humanoid (public humanoid3d description): m, in its axes x forward, y
// up, z right.
constexpr double kHipHalfSpacing = 0.0849;
constexpr double kThigh = 0.4215;
constexpr double kShank = 0.4099;
const Eigen::Vector3d kToeInFoot(0.14, -0.04, 0.0);  // front lower edge of the foot box
constexpr std::size_t kColumns = 44;
constexpr std::size_t kRootPosition = 1, kRootQuat = 4;
// right, left
constexpr std::array<std::size_t, 2> kHipQuat = {16, 30}, kKneeAngle = {20, 34},
                                     kAnkleQuat = {21, 35};

Eigen::Quaterniond quaternion_at(const std::vector<double>& row, std::size_t column) {
  return Eigen::Quaterniond(row[column], row[column + 1], row[column + 2], row[column + 3])
      .normalized();
}

/// x forward, y up, z right -> x forward, y left, z up.
Eigen::Vector3d to_z_up(const Eigen::Vector3d& p) { return {p.x(), -p.z(), p.y()}; }

HumanLeg leg_of(const std::vector<double>& row, int side) {
  const Eigen::Vector3d root(row[kRootPosition], row[kRootPosition + 1], row[kRootPosition + 2]);
  const Eigen::Quaterniond root_rotation = quaternion_at(row, kRootQuat);
  const Eigen::Vector3d hip =
      root + root_rotation * Eigen::Vector3d(0, 0, -side_sign(side) * kHipHalfSpacing);
  const Eigen::Quaterniond thigh = root_rotation * quaternion_at(row, kHipQuat[side]);
  const Eigen::Vector3d knee = hip + thigh * Eigen::Vector3d(0, -kThigh, 0);
  const Eigen::Quaterniond shank = thigh * Eigen::Quaterniond(Eigen::AngleAxisd(
                                               row[kKneeAngle[side]], Eigen::Vector3d::UnitZ()));
  const Eigen::Vector3d ankle = knee + shank * Eigen::Vector3d(0, -kShank, 0);
  const Eigen::Vector3d toe = ankle + (shank * quaternion_at(row, kAnkleQuat[side])) * kToeInFoot;
  return {to_z_up(hip), to_z_up(knee), to_z_up(ankle), to_z_up(toe)};
}

std::vector<double> read_row(const nlohmann::json& json, const std::string& where) {
  if (!json.is_array() || json.size() != kColumns) {
    throw ClipError(where + ": found " +
                    (json.is_array() ? std::to_string(json.size()) + " values" : "no list") +
                    ", expected 44 numbers");
  }
  std::vector<double> row;
  for (const auto& value : json) {
    if (!value.is_number())
      throw ClipError(where + ": found " + value.dump() + ", expected a number");
    row.push_back(value.get<double>());
  }
  return row;
}

}  // namespace

HumanMotion parse_deepmimic(const std::string& text, const std::string& name) {
  const nlohmann::json json = nlohmann::json::parse(text, nullptr, false);
  if (json.is_discarded()) throw ClipError(name + ": not valid JSON; expected a DeepMimic motion");
  if (!json.contains("Frames") || !json["Frames"].is_array() || json["Frames"].size() < 2) {
    throw ClipError(name + ": expected a list \"Frames\" with at least two rows");
  }
  HumanMotion motion;
  motion.source = name;
  motion.loops = json.value("Loop", std::string("none")) == "wrap";
  std::size_t index = 0;
  for (const auto& entry : json["Frames"]) {
    const std::vector<double> row =
        read_row(entry, name + ": Frames[" + std::to_string(index++) + "]");
    if (motion.frames.empty()) motion.dt_s = row[0];
    motion.frames.push_back({{leg_of(row, kRight), leg_of(row, kLeft)}});
  }
  if (!(motion.dt_s > 0.0)) throw ClipError(name + ": Frames[0]: duration is not above 0 s");
  return motion;
}

HumanMotion read_deepmimic(const std::string& path) {
  try {
    return parse_deepmimic(files::read_text(path), path);
  } catch (const files::InputError& error) {
    throw ClipError(error.what() + std::string("; give the path of a DeepMimic motion (JSON)"));
  }
}

}  // namespace sanso::motion
