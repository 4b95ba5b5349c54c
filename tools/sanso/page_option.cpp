// The page is made before the robot and goes after it; the robot's part of it is in watched_robot.
#include "tools/sanso/page_option.h"

#include <fmt/format.h>
#include <spawn.h>

#include <chrono>
#include <thread>

#include "firmware/app/faults_words.h"
#include "host/app/interrupt.h"
#include "host/app/network_robot.h"
#include "host/motion/motion.h"
#include "shared/files/atomic_file.h"
#include "tools/page/embedded/bundle.h"
#include "tools/page/embedded/urdf_scene.h"
#include "tools/page/scene.h"
#include "tools/sanso/watched_robot.h"

extern char** environ;

namespace sanso::cli {
namespace {

nlohmann::json fault_texts() {
  nlohmann::json out = nlohmann::json::object();
  for (const firmware::FaultWords& words : firmware::kFaultWords)
    out[std::to_string(static_cast<int>(words.fault))] = fmt::format(
        "{}: {} Look at: {}", firmware::name_of(words.fault), words.meaning, words.look_at);
  return out;
}

void open_browser(const std::string& address) {
  std::string program = "xdg-open", argument = address;
  char* arguments[] = {program.data(), argument.data(), nullptr};
  pid_t pid = 0;
  if (::posix_spawnp(&pid, arguments[0], nullptr, nullptr, arguments, environ) != 0)
    fmt::print(stderr, "--open: xdg-open is not there; open the address by hand\n");
}

/// What --robot names.
enum class Robot { in_process, emulated, network };

Robot kind_of(const std::string& robot) {
  if (robot == "in-process") return Robot::in_process;
  return robot == "emulated" ? Robot::emulated : Robot::network;
}

std::unique_ptr<EmulatedAccess> emulated(const app::LearnOptions& options) {
  return std::make_unique<EmulatedAccess>(options.world, options.seed, options.out / "run");
}

std::unique_ptr<learn::RobotAccess> plain_robot(const app::LearnOptions& options) {
  switch (kind_of(options.robot)) {
    case Robot::in_process:
      return inprocess::access_for(options);
    case Robot::emulated:
      return emulated(options);
    case Robot::network:
      break;
  }
  if (options.robot.find(':') == std::string::npos)
    throw std::runtime_error("--robot " + options.robot +
                             ": expected in-process, emulated or HOST:PORT");
  return std::make_unique<app::NetworkRobot>(options.robot, options.key, stderr, stdin);
}

std::unique_ptr<learn::RobotAccess> watched_robot(const app::LearnOptions& options,
                                                  page::LivePage& page) {
  switch (kind_of(options.robot)) {
    case Robot::in_process:
      return std::make_unique<WatchedRobot>(inprocess::access_for(options), page);
    case Robot::emulated:
      return std::make_unique<WatchedRobot>(emulated(options), page);
    case Robot::network:
      break;
  }
  return std::make_unique<WatchedRobot>(plain_robot(options), page, options.robot,
                                        app::read_key(options.key));
}

/// With the buttons on, the page stays after the last trial until a person asks for another motion
/// or presses Ctrl-C.
std::string wait_for_next_motion(page::LivePage& page) {
  const app::Interrupt interrupt;
  fmt::print("the page stays: choose the next motion there, or press Ctrl-C\n");
  std::fflush(stdout);
  while (!app::Interrupt::requested()) {
    std::string next = page.take_next_motion();
    if (!next.empty()) return next;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  return {};
}

}  // namespace

void add_page_options(CLI::App& command, PageOptions& options) {
  command
      .add_option("--page", options.port,
                  "serve a page that shows the robot, on this port of 127.0.0.1; 0: any free one")
      ->check(CLI::Range(0, 65535));
  command.add_flag("--control", options.control,
                   "the page's buttons work: emergency stop, pause, start, next motion, push");
  command
      .add_option("--urdf", options.urdf,
                  "draw the robot by this URDF and its meshes (STL), not by its primitives")
      ->check(CLI::ExistingFile);
  command.add_flag("--open", options.open, "open the page in the browser");
}

std::unique_ptr<page::LivePage> serve_page(const PageOptions& options, const std::string& robot,
                                           const std::string& world, const std::string& ground) {
  if (options.port < 0 && !options.control && !options.open) return nullptr;
  if (page::bundle().empty()) {
    fmt::print(stderr, "no page: {}\n", page::kNoBundle);
    return nullptr;
  }
  const bool emulated = kind_of(robot) != Robot::network;
  page::LivePageSettings settings;
  settings.port = std::max(0, options.port);
  settings.control = options.control;
  settings.interrupted = app::Interrupt::requested;
  const std::string there =
      (emulated ? world : "nominal") + (ground == "plane" ? "" : "+" + ground);
  settings.scene = page::scene_of(plant::load_world(there));
  if (!options.urdf.empty())
    settings.scene["urdf"] = page::scene_of_urdf(files::read_text(options.urdf), options.urdf,
                                                 std::filesystem::path(options.urdf).parent_path());
  settings.scene["robot"] = emulated ? fmt::format("{} robot, world {}", robot, world) : robot;
  settings.scene["faults"] = fault_texts();
  settings.scene["motions"] = motion::MotionLibrary().names();
  auto made = std::make_unique<page::LivePage>(std::move(settings));
  fmt::print("page: {}\n", made->address());
  std::fflush(stdout);
  if (options.open) open_browser(made->address());
  return made;
}

MakeRobot watched(page::LivePage* page) {
  if (!page) return plain_robot;
  return [page](const app::LearnOptions& options) { return watched_robot(options, *page); };
}

int learn_with_page(app::LearnOptions options, page::LivePage* page, const PageOptions& asked,
                    const std::function<void(const app::LearnOptions&)>& after) {
  options.watcher = page;
  const std::filesystem::path first = options.out;
  const bool buttons = page && asked.control;
  if (buttons) page->set_button("next", [] { return std::string(); });
  for (int round = 2;; ++round) {
    const int result = app::learn(options, watched(page));
    after(options);
    if (!buttons) return result;
    std::string next = page->take_next_motion();
    if (next.empty()) next = wait_for_next_motion(*page);
    if (next.empty()) return result;
    page->pause(false);
    options.motion = next;
    options.out = first.string() + fmt::format("_{}_{}", round, next);
    options.resume = false;
    fmt::print("next: {} in {}\n", next, options.out.string());
  }
}

}  // namespace sanso::cli
