// `sanso watch`: the page of a controller that runs somewhere, whoever owns it.
#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <thread>

#include "host/app/interrupt.h"
#include "host/app/network_robot.h"
#include "tools/page/embedded/bundle.h"
#include "tools/page/robot_watch.h"
#include "tools/sanso/commands.h"
#include "tools/sanso/page_option.h"
#include "tools/sanso/watched_robot.h"

namespace sanso::cli {
namespace {

struct WatchOptions {
  std::string address;
  std::filesystem::path key;
  std::string ground = "plane";
  PageOptions page{.port = 0, .control = false, .open = false, .urdf = {}};
};

int run_watch(const WatchOptions& options) {
  if (page::bundle().empty()) throw std::runtime_error(page::kNoBundle);
  const wire::Key key = app::read_key(options.key);
  const std::unique_ptr<page::LivePage> page =
      serve_page(options.page, options.address, "nominal", options.ground);
  for (const char* name : {"stop", "start"}) page->set_button(name, {});  // no session to hold
  page::RobotWatch watch(options.address, key,
                         [&](const wire::Observation& o) { page->observe(o); });
  if (options.page.control) {
    add_controller_buttons(*page, watch);
    page->set_button("lower", [&watch] { return watch.ask(wire::CommandKind::lower); });
  }
  const app::Interrupt interrupt;
  bool there = false;
  while (!app::Interrupt::requested()) {
    if (watch.connected() != there) {
      there = watch.connected();
      fmt::print("{}: {}\n", options.address, there ? "connected" : "gone; waiting for it");
      std::fflush(stdout);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  remove_controller_buttons(*page);
  return kDone;
}

}  // namespace

void add_watch(CLI::App& app, int& result) {
  auto options = std::make_shared<WatchOptions>();
  CLI::App* command = app.add_subcommand("watch", "show a running controller's robot on a page");
  command->add_option("HOST:PORT", options->address, "of the controller")->required();
  command
      ->add_option("--key", options->key,
                   "file of 64 hexadecimal digits, the controller's key_file")
      ->required();
  command
      ->add_option("--ground", options->ground,
                   "what it stands on, to be drawn: plane, ramp, plates, stairs or a profile file "
                   "(shared/grounds/README.md)")
      ->capture_default_str();
  add_page_options(*command, options->page);
  command->footer(
      "Beside a host that learns it only looks; the emergency stop works from everywhere.\n"
      "The controller knows no ground: name the one that the planner was told.\n"
      "Example:\n  sanso watch 192.168.1.20:47100 --key robot.key --open");
  command->callback([options, &result] { result = run_watch(*options); });
}

}  // namespace sanso::cli
