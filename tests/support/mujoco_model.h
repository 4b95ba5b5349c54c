// Owning handles for MuJoCo's model and data, made from XML text.
#pragma once

#include <mujoco/mujoco.h>

#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>

namespace sanso::testing {

struct MujocoDeleter {
  void operator()(mjModel* m) const { mj_deleteModel(m); }
  void operator()(mjData* d) const { mj_deleteData(d); }
};

struct Mujoco {
  std::unique_ptr<mjModel, MujocoDeleter> model;
  std::unique_ptr<mjData, MujocoDeleter> data;

  explicit Mujoco(const std::string& xml) {
    mjVFS vfs;
    mj_defaultVFS(&vfs);
    if (mj_makeEmptyFileVFS(&vfs, "model.xml", static_cast<int>(xml.size())) != 0)
      throw std::runtime_error("MuJoCo VFS is full");
    std::memcpy(vfs.filedata[vfs.nfile - 1], xml.data(), xml.size());
    char error[1000] = "";
    model.reset(mj_loadXML("model.xml", &vfs, error, sizeof error));
    mj_deleteVFS(&vfs);
    if (!model) throw std::runtime_error(std::string("MuJoCo: ") + error);
    data.reset(mj_makeData(model.get()));
  }
};

}  // namespace sanso::testing
