// What drives and links of a standing robot must agree on, window by window: the position loop with
// the recorded current, joint by joint, and the torques with the motion, the forces of the ground
// taken out. Linear in everything that may be missing.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "tools/diagnose/effects/whole_figures.h"
#include "tools/diagnose/wholebody/questions.h"

namespace sanso::diagnose {

/// A joint's drive as the model states it, at the output shaft.
struct DriveLaw {
  double stiffness = 0.0, damping = 0.0;  // N m/rad; N m s/rad, all that is proportional to speed
  double torque_constant = 0.0;           // N m/A
  double armature = 0.0, coulomb = 0.0;
};

/// Places of the columns.
struct DriveColumns {
  Eigen::Index joints = 0;
  Eigen::Index joint(JointFigure what, Eigen::Index j) const {
    return static_cast<Eigen::Index>(what) * joints + j;
  }
  // of the link of joint j (-1: the base): kg at its origin, then kg m along its axes
  Eigen::Index mass(Eigen::Index j) const { return kJointFigures * joints + 4 * (j + 1); }
  // of all drives
  Eigen::Index back_emf() const { return kJointFigures * joints + 4 * (joints + 1); }
  Eigen::Index acc_bias() const { return back_emf() + 1; }  // three
  Eigen::Index count() const { return acc_bias() + 3; }
};

struct DriveRows {
  DriveColumns columns;
  std::vector<DriveLaw> laws;                 // by joint
  bool current = false;                       // recorded; else torques are the position loop's
  std::vector<std::string> sole_links;        // that may touch
  Eigen::MatrixXd X;                          // rows x columns
  Eigen::VectorXd y;                          // in deviations, as far as they are known beforehand
  std::vector<std::size_t> channel;           // by row: rows of one kind scatter alike
  std::vector<std::size_t> recording, piece;  // by row
  std::size_t channels = 0;
  std::string why_not;  // not empty: nothing can be asked, and why
};

DriveRows drive_rows(const Asking& asking);

}  // namespace sanso::diagnose
