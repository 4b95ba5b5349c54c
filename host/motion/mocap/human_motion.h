// The legs of a recorded human in metres, z up, whatever the format they came from.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "host/motion/mocap/bvh.h"

namespace sanso::motion {

enum Side : int { kRight = 0, kLeft = 1 };                                // the order of the joints
inline double side_sign(int side) { return side == kLeft ? 1.0 : -1.0; }  // of y

struct HumanLeg {
  Eigen::Vector3d hip, knee, ankle, toe;  // m, world
};

struct HumanFrame {
  std::array<HumanLeg, 2> leg;  // right, left
  /// Midway between the hip joints, world axes, m.
  Eigen::Vector3d hips() const { return 0.5 * (leg[kRight].hip + leg[kLeft].hip); }
};

struct HumanMotion {
  std::string source;  // file name, for messages
  double dt_s = 0.0;
  bool loops = false;  // the last frame is the first one again, displaced
  std::vector<HumanFrame> frames;

  double leg_length() const;   // mean of |hip - knee| + |knee - ankle|   m
  double hip_spacing() const;  // mean distance of the hip joints         m
};

/// Legs of a BVH clip. Knows the joint names of the ACCAD, MASS and Bandai skeletons (LeftUpLeg ..,
/// with or without a prefix ending in _, and UpperLeg_L ..). Length unit by leg length: centimetres
/// when the leg is longer than 10.
HumanMotion human_from_bvh(const BvhClip& clip);

/// Reads either format by its extension (.bvh, else DeepMimic).
HumanMotion read_human_motion(const std::string& path);

/// Frames first .. last (inclusive). Throws ClipError when they are not in the clip.
HumanMotion cut(const HumanMotion& motion, int first, int last);

/// Positions low-passed at `cutoff_Hz` (second-order Butterworth, forwards and backwards) and
/// resampled at `dt_s`.
HumanMotion smooth_and_resample(const HumanMotion& motion, double cutoff_Hz, double dt_s);

/// Mirror image: y -> -y, left and right swapped.
HumanMotion mirrored(const HumanMotion& motion);

/// Calls `visit(Vector3d&)` for the eight points of a frame.
template <class Frame, class Visitor>
void for_each_point(Frame& frame, Visitor&& visit) {
  for (auto& leg : frame.leg) {
    visit(leg.hip);
    visit(leg.knee);
    visit(leg.ankle);
    visit(leg.toe);
  }
}

}  // namespace sanso::motion
