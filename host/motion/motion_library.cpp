// Motion files by name from one folder, and the judgement of an episode by the clauses of its
// motion.
#include <algorithm>
#include <cstdlib>

#include "host/motion/dmp_fit.h"
#include "host/motion/motion.h"
#include "shared/base/time.h"
#include "shared/grounds/ground_file.h"

namespace sanso::motion {

model::Ground Motion::ground() const {
  return skate ? grounds::load_ground(skate->ground) : model::make_plane();
}

Trajectory Motion::reference() const { return play(primitives); }

std::filesystem::path installed_motions(const std::filesystem::path& program) {
  const std::filesystem::path bin = program.parent_path();
  const std::filesystem::path folder = bin.parent_path() / "share" / "sanso" / "motions";
  std::error_code error;
  return bin.filename() == "bin" && std::filesystem::is_directory(folder, error) ? folder : "";
}

std::filesystem::path motions_of(const std::filesystem::path& program) {
  std::filesystem::path installed = installed_motions(program);
  if (!installed.empty()) return installed;
  const std::filesystem::path built = program.lexically_relative(SANSO_BUILD_TREE);
  // a program that was taken elsewhere does not look where it was built
  return !built.empty() && *built.begin() != ".." ? SANSO_MOTION_LIBRARY : "";
}

MotionLibrary::MotionLibrary() {
  const char* chosen = std::getenv("SANSO_MOTIONS");
  std::error_code error;
  folder_ = chosen && *chosen ? chosen
                              : motions_of(std::filesystem::read_symlink("/proc/self/exe", error));
}

MotionLibrary::MotionLibrary(std::filesystem::path folder) : folder_(std::move(folder)) {}

std::vector<std::string> MotionLibrary::names() const {
  if (folder_.empty())
    throw MotionError(
        "no motions: none are installed beside this program (../share/sanso/motions); set "
        "SANSO_MOTIONS to a folder of motion files");
  std::vector<std::string> found;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder_, error)) {
    if (entry.path().extension() == ".toml") found.push_back(entry.path().stem().string());
  }
  if (error)
    throw MotionError(folder_.string() + ": " + error.message() +
                      "; set SANSO_MOTIONS to a folder of motion files");
  std::sort(found.begin(), found.end());
  return found;
}

Motion MotionLibrary::load(const std::string& name) const {
  const auto known = names();
  if (std::find(known.begin(), known.end(), name) == known.end()) {
    std::string list;
    for (const auto& n : known) list += (list.empty() ? "" : ", ") + n;
    throw MotionError("no motion named '" + name + "' in " + folder_.string() +
                      "; there are: " + list);
  }
  return read_motion(folder_ / (name + ".toml"));
}

Verdict evaluate(const Motion& motion, const MotionEpisode& episode) {
  return evaluate(motion.success, episode, motion.reference(), motion.window, motion.ground());
}

}  // namespace sanso::motion
