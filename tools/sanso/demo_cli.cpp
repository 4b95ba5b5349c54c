// `sanso demo`: the learning session of the README on three processes, then its report.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <stdexcept>

#include "host/app/learn_command.h"
#include "shared/files/atomic_file.h"
#include "tools/report/session_report.h"
#include "tools/sanso/commands.h"
#include "tools/sanso/emulated_access.h"

namespace sanso::cli {
namespace {

namespace fs = std::filesystem;
constexpr char kDemoMark[] = "demo.txt";

/// Makes room for a new demo. Anything else than an older demo stays: hours of learning may be in
/// it.
void remove_older_demo(const fs::path& out) {
  if (!fs::exists(out) || fs::is_empty(out)) return;
  if (!fs::exists(out / kDemoMark))
    throw std::runtime_error(fmt::format(
        "--out {}: holds something else than an older demo; name another folder", out.string()));
  fs::remove_all(out);
}

}  // namespace

void add_demo(CLI::App& app, int& result) {
  auto options = std::make_shared<app::LearnOptions>();
  options->robot = "emulated";
  options->out = "out/demo";
  CLI::App* command = app.add_subcommand(
      "demo", "the main job against the emulated robot: three processes, real clock, ten trials");
  command->add_option("--motion", options->motion, "name of a motion file")->capture_default_str();
  command->add_option("--iterations", options->iterations, "trials")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000));
  command
      ->add_option("--out", options->out, "folder of the session; an older demo in it is replaced")
      ->capture_default_str();
  command->footer("Example:\n  sanso demo --motion stand --iterations 3 --out out/stand");
  command->callback([options, &result] {
    remove_older_demo(options->out);
    fs::create_directories(options->out);
    files::write_atomically(
        options->out / kDemoMark,
        std::string_view("made by sanso demo; the next demo replaces this folder\n"));
    result = app::learn(*options, [](const app::LearnOptions& o) {
      return std::make_unique<EmulatedAccess>(o.world, o.seed, o.out / "run");
    });
    fmt::print("\n{}\n", report::session_table(options->out));
    fmt::print("report: {}\n", report::write_session_report(options->out).string());
  });
}

}  // namespace sanso::cli
