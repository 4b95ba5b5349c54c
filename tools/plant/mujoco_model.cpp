// MuJoCo's XML reader keeps global state, so one thread at a time may call it; its message
// becomes a WorldError.
#include "tools/plant/mujoco_model.h"

#include <cstring>
#include <mutex>

#include "tools/plant/world_error.h"

namespace sanso::plant {

ModelPtr compile_mjcf(const std::string& mjcf, const char* what) {
  static std::mutex parser;  // MuJoCo's XML reader keeps global state
  const std::lock_guard lock(parser);
  const auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  mj_makeEmptyFileVFS(files.get(), "world.xml", static_cast<int>(mjcf.size()));
  std::memcpy(files->filedata[mj_findFileVFS(files.get(), "world.xml")], mjcf.data(), mjcf.size());
  char error[500] = "";
  ModelPtr model(mj_loadXML("world.xml", files.get(), error, sizeof error));
  mj_deleteVFS(files.get());
  if (!model) throw WorldError(std::string("MuJoCo refuses ") + what + ": " + error);
  return model;
}

}  // namespace sanso::plant
