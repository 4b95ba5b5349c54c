// A motion as the rest of the program uses it, and the library that holds the shipped ones.
#pragma once

#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/motion/flight.h"
#include "host/motion/recipe.h"
#include "host/motion/skate.h"
#include "host/motion/success.h"
#include "host/mpc/cost.h"
#include "shared/model/ground.h"
#include "shared/policy/primitives.h"

namespace sanso::motion {

/// A motion file that cannot be used: file, line, value, expected.
struct MotionError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Where a motion comes from; the licence of the clip asks for it.
struct ClipSource {
  std::string credit;  // who to name
  std::string licence;
  std::string changes;  // what was done to it
};

/// When a trial ends early and counts as failed.
struct StopRule {
  double cost_limit = 350.0;      // J_th (paper)
  double tilt_limit_rad = 0.698;  // 40 deg between the base's vertical and the reference's
  double drop_limit_m = 0.09;     // base below its reference
};

struct Motion {
  std::string name;
  std::string title;
  ClipSource source;
  Recipe recipe;                    // of a motion that a clip became
  std::optional<Skate> skate;       // of a motion on wheels
  std::optional<FlightJog> flight;  // of a jog that flies
  mpc::CostWeights weights;
  // how fast targets may change, of the controller that runs it; nothing: as it is set
  std::optional<double> target_rate_rad_s;
  StopRule stop;
  Window window;
  std::vector<Clause> success;
  policy::PrimitiveSet primitives;

  /// What it takes place on: level, or its profile.
  model::Ground ground() const;
  double duration_s() const { return primitives.duration_s; }
  /// x_DMP at every 10 ms tick, first and last included.
  Trajectory reference() const;
};

/// Reads and writes a motion file (TOML, docs/motions.md). Reading refuses unknown keys and invalid
/// primitives.
Motion read_motion(const std::filesystem::path& path);
Motion parse_motion(const std::string& text, const std::string& name_for_messages);
std::string to_toml(const Motion& motion);
/// Atomic: the file is either the old or the new one. Throws MotionError naming the file.
void write_motion(const std::filesystem::path& path, const Motion& motion);

/// ../share/sanso/motions beside a program that stands in a folder bin; empty: there is none.
std::filesystem::path installed_motions(const std::filesystem::path& program);

/// Where a program finds its motions: installed with it, else in the source tree while it stands in
/// its build tree; empty: nowhere.
std::filesystem::path motions_of(const std::filesystem::path& program);

/// A folder of motion files: SANSO_MOTIONS, else motions_of() this program.
class MotionLibrary {
 public:
  MotionLibrary();
  explicit MotionLibrary(std::filesystem::path folder);
  const std::filesystem::path& folder() const { return folder_; }
  /// In alphabetical order.
  std::vector<std::string> names() const;
  /// Throws MotionError naming the motions there are.
  Motion load(const std::string& name) const;

 private:
  std::filesystem::path folder_;
};

/// Verdict of an episode of this motion.
Verdict evaluate(const Motion& motion, const MotionEpisode& episode);

}  // namespace sanso::motion
