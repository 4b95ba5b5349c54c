// A foot is in contact while it is low and slow; heading and floor are estimated from the clip
// itself.
#include "host/motion/mocap/contacts.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "host/motion/mocap/filter.h"

namespace sanso::motion {
namespace {

constexpr double kStandingPercentile = 0.08;  // of a foot point's height: its value in stance
constexpr double kContactHeight_m = 0.030;
constexpr double kContactSpeed = 0.25;  // m/s, when the hips hardly move
constexpr double kMedian_s = 0.07;
constexpr double kFloorWindow_s = 0.7;
constexpr double kShortestStance_s = 0.08;

std::vector<double> heights(const HumanMotion& motion, int side, Eigen::Vector3d HumanLeg::*point) {
  std::vector<double> z;
  for (const auto& frame : motion.frames) z.push_back((frame.leg[side].*point).z());
  return z;
}

/// Height of the lower of ankle and toe, each above its own standing value.
std::vector<double> sole_height(const HumanMotion& motion, int side) {
  const std::vector<double> ankle = heights(motion, side, &HumanLeg::ankle);
  const std::vector<double> toe = heights(motion, side, &HumanLeg::toe);
  const double ankle_low = percentile(ankle, kStandingPercentile),
               toe_low = percentile(toe, kStandingPercentile);
  std::vector<double> height(ankle.size());
  for (std::size_t f = 0; f < ankle.size(); ++f)
    height[f] = std::min(ankle[f] - ankle_low, toe[f] - toe_low);
  return height;
}

double speed_at(const HumanMotion& motion, std::size_t f, int side,
                Eigen::Vector3d HumanLeg::*point) {
  const std::size_t a = f > 0 ? f - 1 : 0, b = std::min(f + 1, motion.frames.size() - 1);
  const Eigen::Vector3d step =
      motion.frames[b].leg[side].*point - motion.frames[a].leg[side].*point;
  return step.norm() / (static_cast<double>(b - a) * motion.dt_s);
}

/// Least-squares line z = offset + slope * x.
std::pair<double, double> fit_line(const std::vector<double>& x, const std::vector<double>& z) {
  const auto n = static_cast<double>(x.size());
  double sx = 0, sz = 0, sxx = 0, sxz = 0;
  for (std::size_t k = 0; k < x.size(); ++k) {
    sx += x[k];
    sz += z[k];
    sxx += x[k] * x[k];
    sxz += x[k] * z[k];
  }
  const double slope = (n * sxz - sx * sz) / (n * sxx - sx * sx);
  return {(sz - slope * sx) / n, slope};
}

double median(std::vector<double> values) { return percentile(std::move(values), 0.5); }

}  // namespace

HumanMotion aligned(const HumanMotion& motion, bool heading_by_body) {
  Eigen::Vector3d facing = Eigen::Vector3d::Zero();
  for (const auto& frame : motion.frames) {
    facing += (frame.leg[kLeft].hip - frame.leg[kRight].hip).cross(Eigen::Vector3d::UnitZ());
  }
  Eigen::Vector3d forward = facing;
  if (!heading_by_body) {
    const Eigen::Vector3d travel = motion.frames.back().hips() - motion.frames.front().hips();
    forward = travel.dot(facing) >= 0 ? travel : Eigen::Vector3d(-travel);
  }
  const double heading = std::atan2(forward.y(), forward.x());
  const double c = std::cos(heading), s = std::sin(heading);
  const Eigen::Vector3d origin = motion.frames.front().hips();
  HumanMotion out = motion;
  for (auto& frame : out.frames) {
    for_each_point(frame, [&](Eigen::Vector3d& p) {
      const double x = p.x() - origin.x(), y = p.y() - origin.y();
      p = {c * x + s * y, -s * x + c * y, p.z()};
    });
  }
  return out;
}

HumanMotion floor_levelled(const HumanMotion& motion) {
  const std::vector<double> right = sole_height(motion, kRight), left = sole_height(motion, kLeft);
  std::vector<double> lower(right.size()), x;
  for (std::size_t f = 0; f < lower.size(); ++f) {
    lower[f] = std::min(right[f], left[f]);
    x.push_back(motion.frames[f].hips().x());
  }
  const int half = static_cast<int>(0.5 * kFloorWindow_s / motion.dt_s);
  const auto [offset, slope] = fit_line(x, running_minimum(lower, half));
  HumanMotion out = motion;
  for (std::size_t f = 0; f < out.frames.size(); ++f) {
    for_each_point(out.frames[f],
                   [&, o = offset, s = slope](Eigen::Vector3d& p) { p.z() -= o + s * x[f]; });
  }
  return out;
}

std::array<std::vector<bool>, 2> foot_contacts(const HumanMotion& motion) {
  double hip_speed = 0.0;
  for (std::size_t f = 1; f < motion.frames.size(); ++f) {
    hip_speed += (motion.frames[f].hips() - motion.frames[f - 1].hips()).norm() / motion.dt_s;
  }
  hip_speed /= static_cast<double>(motion.frames.size() - 1);
  const double slow = std::max(0.5 * hip_speed, kContactSpeed);

  std::array<std::vector<bool>, 2> contacts;
  for (int side : {kRight, kLeft}) {
    const std::vector<double> height = sole_height(motion, side);
    std::vector<double> raw(height.size());
    for (std::size_t f = 0; f < raw.size(); ++f) {
      const double speed = std::min(speed_at(motion, f, side, &HumanLeg::ankle),
                                    speed_at(motion, f, side, &HumanLeg::toe));
      raw[f] = height[f] < kContactHeight_m && speed < slow ? 1.0 : 0.0;
    }
    for (const double c : running_median(raw, static_cast<int>(0.5 * kMedian_s / motion.dt_s))) {
      contacts[side].push_back(c > 0.5);
    }
  }
  return contacts;
}

std::vector<HumanStance> stances(const HumanMotion& motion) {
  const auto contacts = foot_contacts(motion);
  const std::size_t n = motion.frames.size();
  std::vector<HumanStance> found;
  for (int side : {kRight, kLeft}) {
    for (std::size_t f = 0; f < n;) {
      if (!contacts[side][f]) {
        ++f;
        continue;
      }
      const std::size_t from = f;
      std::vector<double> x, y;
      for (; f < n && contacts[side][f]; ++f) {
        x.push_back(motion.frames[f].leg[side].ankle.x());
        y.push_back(motion.frames[f].leg[side].ankle.y());
      }
      HumanStance stance{side,
                         static_cast<double>(from) * motion.dt_s,
                         static_cast<double>(f - 1) * motion.dt_s,
                         from > 0 && f < n,
                         {median(x), median(y)}};
      if (stance.to_s - stance.from_s >= kShortestStance_s || !stance.whole)
        found.push_back(stance);
    }
  }
  std::sort(found.begin(), found.end(),
            [](const auto& a, const auto& b) { return a.from_s < b.from_s; });
  return found;
}

HumanMotion unrolled(const HumanMotion& motion, int cycles) {
  HumanMotion out = motion;
  const Eigen::Vector3d shift = motion.frames.back().hips() - motion.frames.front().hips();
  const Eigen::Vector3d level(shift.x(), shift.y(), 0.0);
  for (int c = 1; c < cycles; ++c) {
    for (std::size_t f = 1; f < motion.frames.size(); ++f) {
      HumanFrame frame = motion.frames[f];
      for_each_point(frame, [&](Eigen::Vector3d& p) { p += c * level; });
      out.frames.push_back(frame);
    }
  }
  return out;
}

}  // namespace sanso::motion
