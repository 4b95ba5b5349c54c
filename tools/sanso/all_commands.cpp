// Everything that sanso can do.
#include "tools/sanso/commands.h"

namespace sanso::cli {

const char* const kNext =
    R"(sanso: lets a humanoid learn to move, and finds what a simulation leaves out. What next?

  see a robot learn to squat, live      sanso demo --open
  learn a motion, and its report        sanso learn --motion walk --iterations 100 --out runs/walk
  which motions there are               sanso motions
  see a controller's robot              sanso watch HOST:PORT --key FILE
  what your simulation leaves out       sanso diagnose --help
  everything else                       sanso --help
)";

void add_commands(CLI::App& app, int& result) {
  add_demo(app, result);
  add_bench(app, result);
  add_conceal(app, result);
  add_learn(app, result);
  add_motions(app, result);
  add_report(app, result);
  add_reveal(app, result);
  add_export(app, result);
  add_import(app, result);
  add_watch(app, result);
  add_identify(app, result);
  add_score(app, result);
  add_diagnose(app, result);
  add_bench_diagnose(app, result);
}

}  // namespace sanso::cli
