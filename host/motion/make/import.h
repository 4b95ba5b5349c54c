// `sanso motions import`: a clip in, a checked motion out.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/motion/make/retarget.h"
#include "host/motion/motion.h"

namespace sanso::motion {

struct ImportRequest {
  std::filesystem::path clip;  // .bvh, or DeepMimic's JSON
  std::string name;            // of the new motion
  // motion of the catalogue whose figures are used; empty: `name` itself
  std::string like = {};
  std::vector<std::string> figures = {};  // "key=value" of the recipe, instead of the catalogue's
};

/// How well the primitives repeat the trajectory they were fitted to.
struct FitError {
  double joint_rad = 0.0, position_m = 0.0;  // largest
};

/// Over the samples that both have.
FitError fit_error(const policy::PrimitiveSet& set, const Trajectory& wanted);

struct ImportedMotion {
  Motion motion;
  Retargeted retargeted;
  ReferenceCheck check;
  FitError fit;
};

/// Retargets, fits, rounds to what the file holds, and checks. Throws ClipError when the clip
/// cannot be used or the motion asks for what the robot cannot do, naming the figures to change;
/// MotionError for an unknown `like`.
ImportedMotion import_motion(const ImportRequest& request);

/// Window, primitives and the error of the fit, from the solved body; rounded to what the file
/// holds.
void finish_motion(ImportedMotion& made);

/// One line per check that does not hold; empty when the reference may be shipped.
std::vector<std::string> complaints(const ReferenceCheck& check, MotionKind kind);

}  // namespace sanso::motion
