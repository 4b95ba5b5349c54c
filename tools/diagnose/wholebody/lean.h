// A direction that should be upright and leans: how much of that belongs to the world, and how much
// turns with the robot. Only headings that differ tell the two.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "tools/diagnose/wholebody/answers.h"

namespace sanso::diagnose {

using V2 = Eigen::Vector2d;

/// World axes along the ground: x ahead as far as it is horizontal, up, left of it.
struct Level {
  /// `up`: of length 1, world axes.
  explicit Level(const V3& up);
  V3 x, y, up;
  /// Of the base's x axis along the ground, rad.
  double heading(const M3& R_world_base) const;
  /// Horizontal part of a direction.
  V2 lean(const V3& direction) const { return {x.dot(direction), y.dot(direction)}; }
};

/// Rotation about the level's x and y that leans the upright by `lean`, rad.
inline V2 rotation_of(const V2& lean) { return {-lean[1], lean[0]}; }
/// How a rotation about the level's x and y, rad, leans the upright: the inverse of rotation_of.
inline V2 lean_of(const V2& rotation) { return {rotation[1], -rotation[0]}; }

/// Readings of one kind, summed by piece of a recording.
class Leans {
 public:
  /// `part`: what leans with the robot on its own account (a foot). `group`: resampled as one.
  /// `piece`: of the recording; every third is held out.
  void add(const V2& lean, double heading, const std::string& part, std::size_t recording,
           std::size_t piece, std::size_t group);
  bool empty() const { return cells_.empty(); }

 private:
  friend struct LeanFit;
  struct Cell {
    std::size_t recording = 0, piece = 0, group = 0;
    std::size_t part = 0;
    double rows = 0.0, squares = 0.0;
    V2 world = V2::Zero(), body = V2::Zero();        // sums of leans in world axes, in the robot's
    Eigen::Matrix2d turn = Eigen::Matrix2d::Zero();  // sum of rotations by the heading
  };
  std::vector<Cell> cells_;
  std::vector<std::string> parts_;
};

/// What the readings come to. Sizes of vectors are in value, low, high and sigma of `Measured`,
/// with the proof on held-out pieces against the same without this vector.
struct LeanFit {
  V2 in_world = V2::Zero(), in_body = V2::Zero();  // told from each other
  Measured world, body;
  V2 alike = V2::Zero();  // all of it as the world's, where the two cannot be told
  Measured together;
  Measured
      apart;  // beside what all share, for themselves: what half of the recordings have at least

  /// Nothing where there are too few groups. `wander`: rad, by which what leans with the robot
  /// changes between recordings.
  static std::optional<LeanFit> of(const Leans& leans, double wander, const Chance& chance);
};

}  // namespace sanso::diagnose
