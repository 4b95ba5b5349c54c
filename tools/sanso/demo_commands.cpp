// What tools/demo needs to be built: half of the whole, so that the first squat is soon seen.
#include "tools/sanso/commands.h"

namespace sanso::cli {

const char* const kNext =
    R"(sanso-demo: the commands that tools/demo builds. What next?

  see a robot learn to squat, live   sanso-demo demo --open
  learn a motion, and its report     sanso-demo learn --motion stand --iterations 10 --out stand
  see a controller's robot           sanso-demo watch HOST:PORT --key FILE
  films, exports, diagnosis          cmake --build build/release --target sanso
)";

void add_commands(CLI::App& app, int& result) {
  add_demo(app, result);
  add_learn(app, result);
  add_watch(app, result);
}

}  // namespace sanso::cli
