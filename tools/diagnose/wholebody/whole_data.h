// Recordings of a floating base, judged and brought into one form.
#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "tools/diagnose/gate/gate.h"
#include "tools/diagnose/settings.h"
#include "tools/diagnose/wholebody/kinematics.h"
#include "tools/recording/recording.h"

namespace sanso::diagnose {

/// Vertical force of the ground on one foot.
struct FootForce {
  std::string link;
  int joint = -1;          // of the tree, -1 = the base
  std::vector<double> fz;  // N; NaN = not sampled
};

struct WholeRecording {
  std::string file, name, condition;
  std::vector<double> t;
  std::vector<int> piece;  // by row; another after every gap
  // which of the following were recorded
  bool attitude = false, position = false, acc = false, gyro = false;
  std::vector<M3> R;                  // base axes into world axes
  std::vector<V3> p;                  // world, m
  std::vector<V3> v;                  // world, m/s: as recorded, else from p
  std::vector<V3> w;                  // base axes, rad/s: as recorded, else from R
  std::vector<V3> imu_acc, imu_gyro;  // IMU axes; NaN = not sampled
  Eigen::MatrixXd q;                  // joints x rows; those not recorded at rest
  bool commands = false;              // every joint has q and u
  bool current = false;               // every joint has i
  Eigen::MatrixXd u, i;               // joints x rows: goals, rad; A
  std::vector<FootForce> feet;
  double interval = 0.01;  // s, median

  std::size_t rows() const { return t.size(); }
};

struct WholeData {
  std::vector<WholeRecording> recordings;
  std::vector<Defect> defects;  // not empty: refused
  std::vector<std::string> notes;
  std::map<std::string, std::string> hashes;
};

/// Reads and judges all files; never throws for bad input.
WholeData load_whole(const std::vector<std::string>& files, const WholeBody& body,
                     const Settings& settings);
/// The same of recordings in memory.
WholeData judge_whole(const std::vector<recording::Recording>& recordings, const WholeBody& body,
                      const Settings& settings);

}  // namespace sanso::diagnose
