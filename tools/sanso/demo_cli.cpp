#include <fmt/format.h>

#include <memory>

#include "host/app/learn_command.h"
#include "tools/report/session_report.h"
#include "tools/sanso/commands.h"
#include "tools/sanso/emulated_access.h"

namespace sanso::cli {

void add_demo(CLI::App& app, int& result) {
  auto options = std::make_shared<app::LearnOptions>();
  options->robot = "emulated";
  options->out = "out/demo";
  CLI::App* command = app.add_subcommand("demo", "the main job against the emulated robot: three processes, real clock, ten trials");
  command->add_option("--motion", options->motion, "name of a motion file")->capture_default_str();
  command->add_option("--iterations", options->iterations, "trials")->capture_default_str()->check(CLI::Range(1, 1000));
  command->add_option("--out", options->out, "folder of the session; an older demo in it is replaced")->capture_default_str();
  command->footer("Example:\n  sanso demo --motion stand --iterations 3 --out out/stand");
  command->callback([options, &result] {
    if (std::filesystem::exists(options->out / "state.bin")) std::filesystem::remove_all(options->out);
    result = app::learn(*options, [](const app::LearnOptions& o) {
      return std::make_unique<EmulatedAccess>(o.world, o.seed, o.out / "run");
    });
    fmt::print("\n{}\n", report::session_table(options->out));
    fmt::print("report: {}\n", report::write_session_report(options->out).string());
  });
}

}  // namespace sanso::cli
