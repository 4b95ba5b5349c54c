// Finds the leg joints of a BVH skeleton by the two naming customs in use, and turns y up into z
// up.
#include "host/motion/mocap/human_motion.h"

#include <cmath>

#include "host/motion/mocap/deepmimic.h"
#include "host/motion/mocap/filter.h"

namespace sanso::motion {
namespace {

struct LegNames {
  std::string hip, knee, ankle, toe;
};

/// Joint names of one side. Two customs are known: <prefix>LeftUpLeg, LeftLeg, LeftFoot,
/// LeftToeBase, and UpperLeg_L.
LegNames find_leg(const BvhClip& clip, int side) {
  const std::string word = side == kLeft ? "Left" : "Right";
  const std::string up_leg = word + "UpLeg";
  for (const auto& joint : clip.joints) {
    const std::size_t at = joint.name.rfind(up_leg);
    if (at == std::string::npos || at + up_leg.size() != joint.name.size()) continue;
    const std::string prefix = joint.name.substr(0, at);
    return {prefix + up_leg, prefix + word + "Leg", prefix + word + "Foot",
            prefix + word + "ToeBase"};
  }
  const std::string suffix = side == kLeft ? "_L" : "_R";
  return {"UpperLeg" + suffix, "LowerLeg" + suffix, "Foot" + suffix, "Toes" + suffix};
}

/// y up -> z up by the cyclic permutation, which keeps the handedness.
Eigen::Vector3d cycled_to_z_up(const Eigen::Vector3d& p) { return {p.z(), p.x(), p.y()}; }

}  // namespace

double HumanMotion::leg_length() const {
  double sum = 0.0;
  for (const auto& frame : frames) {
    for (const auto& leg : frame.leg)
      sum += (leg.hip - leg.knee).norm() + (leg.knee - leg.ankle).norm();
  }
  return sum / (2.0 * static_cast<double>(frames.size()));
}

double HumanMotion::hip_spacing() const {
  double sum = 0.0;
  for (const auto& frame : frames) sum += (frame.leg[kLeft].hip - frame.leg[kRight].hip).norm();
  return sum / static_cast<double>(frames.size());
}

HumanMotion human_from_bvh(const BvhClip& clip) {
  std::array<std::array<int, 4>, 2> index;
  for (int side : {kRight, kLeft}) {
    const LegNames names = find_leg(clip, side);
    index[side] = {clip.joint(names.hip), clip.joint(names.knee), clip.joint(names.ankle),
                   clip.joint(names.toe)};
  }
  HumanMotion motion;
  motion.source = clip.file;
  motion.dt_s = clip.frame_time_s;
  for (std::size_t f = 0; f < clip.frames.size(); ++f) {
    const auto p = clip.positions(f);
    HumanFrame frame;
    for (int side : {kRight, kLeft}) {
      frame.leg[side] = {cycled_to_z_up(p[index[side][0]]), cycled_to_z_up(p[index[side][1]]),
                         cycled_to_z_up(p[index[side][2]]), cycled_to_z_up(p[index[side][3]])};
    }
    motion.frames.push_back(frame);
  }
  const double metres = motion.leg_length() > 10.0 ? 0.01 : 1.0;
  for (auto& frame : motion.frames)
    for_each_point(frame, [&](Eigen::Vector3d& point) { point *= metres; });
  const double length = motion.leg_length();
  if (length < 0.3 || length > 1.5) {
    throw ClipError(clip.file + ": legs of " + std::to_string(length) +
                    " m; expected a human of 0.3 to 1.5 m leg length in metres or centimetres");
  }
  return motion;
}

HumanMotion read_human_motion(const std::string& path) {
  if (path.size() > 4 && path.substr(path.size() - 4) == ".bvh")
    return human_from_bvh(read_bvh(path));
  return read_deepmimic(path);
}

HumanMotion cut(const HumanMotion& motion, int first, int last) {
  const int size = static_cast<int>(motion.frames.size());
  if (first < 0 || last < first || last >= size) {
    throw ClipError(motion.source + ": frames " + std::to_string(first) + " to " +
                    std::to_string(last) + " asked for, the clip has 0 to " +
                    std::to_string(size - 1));
  }
  HumanMotion part = motion;
  part.frames.assign(motion.frames.begin() + first, motion.frames.begin() + last + 1);
  return part;
}

HumanMotion smooth_and_resample(const HumanMotion& motion, double cutoff_Hz, double dt_s) {
  HumanMotion out = motion;
  const std::size_t n = motion.frames.size();
  const auto count =
      static_cast<std::size_t>(std::floor(static_cast<double>(n - 1) * motion.dt_s / dt_s + 1e-9)) +
      1;
  out.dt_s = dt_s;
  out.frames.assign(count, {});
  // the eight points are filtered coordinate by coordinate
  for (int point = 0; point < 8; ++point) {
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<double> signal(n);
      for (std::size_t f = 0; f < n; ++f) {
        HumanFrame frame = motion.frames[f];
        int k = 0;
        for_each_point(frame, [&](Eigen::Vector3d& p) {
          if (k++ == point) signal[f] = p[axis];
        });
      }
      const std::vector<double> smooth = low_pass(signal, motion.dt_s, cutoff_Hz);
      for (std::size_t f = 0; f < count; ++f) {
        const double value = sample_at(smooth, static_cast<double>(f) * dt_s / motion.dt_s);
        int k = 0;
        for_each_point(out.frames[f], [&](Eigen::Vector3d& p) {
          if (k++ == point) p[axis] = value;
        });
      }
    }
  }
  return out;
}

HumanMotion mirrored(const HumanMotion& motion) {
  HumanMotion out = motion;
  for (auto& frame : out.frames) {
    for_each_point(frame, [](Eigen::Vector3d& p) { p.y() = -p.y(); });
    std::swap(frame.leg[kRight], frame.leg[kLeft]);
  }
  return out;
}

}  // namespace sanso::motion
