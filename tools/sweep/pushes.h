// Survival under pushes: a learned motion is run again and again, each time with one push of the
// torso, with all layers and without each of them. Same pushes for every choice of layers.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tools/sweep/ranks.h"

namespace sanso::sweep {

struct PushOptions {
  std::filesystem::path session;  // what was learned: folder of `sanso learn`
  std::string motion = "squat", world = "lab";
  std::vector<std::string> without;  // one campaign each: "none", "lower", "middle", "upper"
  int count = 200;
  std::uint64_t seed = 1;
  double smallest_Ns = 0.0, largest_Ns = 2.4;  // impulses are drawn evenly between them
  std::vector<std::string> changes;            // NAME=VALUE, as sanso learn --set, in their order
  std::filesystem::path out;                   // pushes.json
};

/// One push, drawn by seed and number.
struct DrawnPush {
  double impulse_Ns = 0.0;     // horizontal
  double direction_rad = 0.0;  // 0 = from behind, towards +x of the world
  double duration_s = 0.1;
  double height_m = 0.0;  // point of the torso above its origin
  double time_s = 0.0;    // of the trial
};
/// `smallest_Ns` <= impulse < `largest_Ns`, `from_s` <= time < `to_s`.
DrawnPush draw_push(std::uint64_t seed, int number, double smallest_Ns, double largest_Ns,
                    double from_s, double to_s);

/// Writes pushes.json at rank 0: every push with the layers' survival, how its trial ended and the
/// controller's fault. Exit code: 0 done; 2 SIGINT
/// or SIGTERM came, no push began after that and nothing is written.
int run_pushes(Ranks& ranks, const PushOptions& options);

}  // namespace sanso::sweep
