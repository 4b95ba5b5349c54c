// What drives and links of a standing robot must agree on, window by window: the position loop with
// the recorded current, joint by joint, and the torques with the motion, the forces of the ground
// taken out. Linear in everything that may be missing.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "tools/diagnose/effects/whole_figures.h"
#include "tools/diagnose/wholebody/drive_law.h"
#include "tools/diagnose/wholebody/questions.h"

namespace sanso::diagnose {

/// Places of the columns.
struct DriveColumns {
  Eigen::Index joints = 0;
  /// Of a figure of joint j; one unit of it is that of its effect.
  Eigen::Index joint(JointFigure what, Eigen::Index j) const {
    return static_cast<Eigen::Index>(what) * joints + j;
  }
  // of the link of joint j (-1: the base): kg at its origin, then kg m along its axes
  Eigen::Index mass(Eigen::Index j) const { return kJointFigures * joints + 4 * (j + 1); }
  // of all drives
  Eigen::Index back_emf() const { return kJointFigures * joints + 4 * (joints + 1); }
  Eigen::Index acc_bias() const { return back_emf() + 1; }     // three
  Eigen::Index force_scale() const { return acc_bias() + 3; }  // of the feet's forces
  Eigen::Index count() const { return force_scale() + 1; }
};

/// A stretch of a recording over which means are compared.
struct StanceWindow {
  std::size_t recording = 0;
  double from = 0.0, to = 0.0;  // s
  // by joint, means: rad, rad/s, goal that acts less position, N m that the drive gave as measured
  Eigen::VectorXd q, dq, error, given;
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
  std::vector<std::size_t> window;            // by row, of the following
  std::vector<StanceWindow> windows;
  // what a newton on the base's centre of mass (three, base axes) and a newton metre at each joint,
  // of whatever, would add to y
  Eigen::MatrixXd unknown;
  Eigen::VectorXd loop;  // what a newton metre more of a joint's current adds to y; 0: no such row
  std::size_t channels = 0;
  bool weighed = false;  // the feet's forces are recorded
  std::string why_not;   // not empty: nothing can be asked, and why
};

/// What a fit has found already, where rows are not linear in it. Empty: nothing.
struct DriveGuess {
  // by joint: what torques are to those that the model makes of goals or currents. Says how soles
  // press against each other, nothing else.
  Eigen::VectorXd scales;
  Eigen::VectorXd lags;  // by joint, s beyond the model's: goals are shifted by it
  // by joint, of one that moves: N m at most (infinite: it never did), share of the load. Says what
  // may hold one that stands
  Eigen::VectorXd dry, load;
};
DriveRows drive_rows(const Asking& asking, const DriveGuess& guess = {});

}  // namespace sanso::diagnose
