// `sanso demo`: the learning session of the README on three processes, then its report.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <stdexcept>

#include "host/app/learn_command.h"
#include "shared/files/atomic_file.h"
#include "tools/sanso/commands.h"
#include "tools/sanso/page_option.h"
#include "tools/session_report/session_report.h"

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
  options->set = {"bring_up.on=false"};  // three quarters of a minute on a real clock
  CLI::App* command = app.add_subcommand(
      "demo", "the main job against the emulated robot: three processes, real clock, ten trials");
  command->add_option("--motion", options->motion, "name of a motion file")->capture_default_str();
  command->add_option("--iterations", options->iterations, "trials")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000));
  command
      ->add_option("--out", options->out, "folder of the session; an older demo in it is replaced")
      ->capture_default_str();
  auto page_options = std::make_shared<PageOptions>();
  page_options->port = 0;  // on by default
  auto no_page = std::make_shared<bool>(false);
  add_page_options(*command, *page_options);
  command->add_flag("--no-page", *no_page, "serve no page");
  command->footer("Example:\n  sanso demo --motion stand --iterations 3 --out out/stand");
  command->callback([options, page_options, no_page, &result] {
    remove_older_demo(options->out);
    fs::create_directories(options->out);
    files::write_atomically(
        options->out / kDemoMark,
        std::string_view("made by sanso demo; the next demo replaces this folder\n"));
    const auto page =
        *no_page ? nullptr : serve_page(*page_options, options->robot, options->world);
    result = learn_with_page(*options, page.get(), *page_options, [](const auto& done) {
      fmt::print("\n{}\n", report::session_table(done.out));
      fmt::print("report: {}\n", report::write_session_report(done.out).string());
    });
  });
}

}  // namespace sanso::cli
