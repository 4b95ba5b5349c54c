// MuJoCo's model and data with owners, and the compiler of a world's XML.
#pragma once

#include <mujoco/mujoco.h>

#include <memory>
#include <string>

namespace sanso::plant {

struct ModelDeleter {
  void operator()(mjModel* m) const { mj_deleteModel(m); }
};
struct DataDeleter {
  void operator()(mjData* d) const { mj_deleteData(d); }
};
using ModelPtr = std::unique_ptr<mjModel, ModelDeleter>;
using DataPtr = std::unique_ptr<mjData, DataDeleter>;

/// Compiles MJCF text; safe to call from several threads. `what` names the world in the WorldError
/// of a refusal.
ModelPtr compile_mjcf(const std::string& mjcf, const char* what);

}  // namespace sanso::plant
