// sanso-emulator: a robot that is not there, behind the same bytes.
#include <fmt/format.h>

#include <sched.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <csignal>
#include <cstring>

#include "tools/emulator/control_client.h"
#include "tools/emulator/emulator_process.h"
#include "tools/plant/world_error.h"

namespace {

volatile std::sig_atomic_t stop_requested = 0;
void request_stop(int) { stop_requested = 1; }

constexpr char kExamples[] = R"(Examples:
  sanso-emulator --world lab                          serve /tmp/sanso-robot/{bus,imu,pose,control}
  sanso-emulator --world seed:7 --dir /tmp/robot2     another robot, elsewhere
  sanso-emulator --world lab --ground ramp            the same robot at the top of a ramp
  sudo sanso-emulator --usb                           bus and IMU as USB devices of this kernel
  sanso-emulator --config robot.toml                  world, seed, directory, baud, [[fault]] tables
  sanso-emulator --tell '{"command": "truth"}'        ask the running emulator
  sanso-emulator --tell '{"command": "push", "force": [0, 8, 0], "duration_s": 0.1}'
  sanso-emulator --tell '{"command": "fault", "kind": "servo_silent", "id": 13, "duration_s": 2}'
  sanso-emulator --tell '{"command": "place", "pose": "walkready"}'
All commands, keys and faults: docs/howto/emulator.md)";

/// A real robot does not wait for other programs: real-time priority, below the controller's. As
/// USB devices of this kernel it is hardware, for which nobody waits.
void ask_for_priority(bool usb) {
  sched_param parameters{};
  parameters.sched_priority = usb ? 95 : 40;
  if (sched_setscheduler(0, SCHED_FIFO, &parameters) == 0) return;
  fmt::print(
      "ordinary priority ({}): on a busy machine replies and samples come late, which the "
      "controller takes for faults\n",
      std::strerror(errno));
}

int serve(const sanso::emulator::EmulatorConfig& config) {
  std::signal(SIGINT, request_stop);
  std::signal(SIGTERM, request_stop);
  std::signal(SIGPIPE, SIG_IGN);
  sanso::emulator::EmulatorProcess process(config);
  fmt::print("world      {}, seed {}\n", config.world, config.seed);
  fmt::print("servo bus  {}{}, {} baud\n", config.usb ? "" : config.directory + "/bus -> ",
             process.bus_device(), config.baud);
  fmt::print("sockets    {}{}/pose  {}/control\n", config.usb ? "" : config.directory + "/imu  ",
             config.directory, config.directory);
  ask_for_priority(config.usb);
  fmt::print("ready\n");
  std::fflush(stdout);
  process.run(stop_requested);
  if (process.stalls() > 0) {
    fmt::print("the machine held this process up {} times for more than 20 ms\n", process.stalls());
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "sanso-emulator: the emulated OP3 (MuJoCo physics) behind real servo packets, IMU and pose "
      "reports"};
  app.footer(kExamples);
  sanso::emulator::EmulatorConfig config;
  std::string config_file, world, ground, directory, command;
  std::uint64_t seed = 0;
  bool usb = false;
  app.add_option("--config", config_file, "TOML file with world, seed, directory, baud, [[fault]]");
  app.add_option("--world", world, "nominal, lab (default), hard, seed:N or a TOML file");
  app.add_option("--ground", ground,
                 "plane, slope3, ramp, ramp_high, jump_ramp, plates, stairs or a profile file");
  const auto* seed_option =
      app.add_option("--seed", seed, "seed of noise and random faults (default 1)");
  app.add_option("--dir", directory,
                 "where bus, imu, pose and control appear (default /tmp/sanso-robot)");
  app.add_flag(
      "--usb", usb,
      "plug bus (FTDI 0403:6014) and IMU (HID 1209:5a50) into this kernel's vhci_hcd; root");
  app.add_option("--tell", command,
                 "send one JSON command to the emulator that serves --dir, and print the answer");
  CLI11_PARSE(app, argc, argv);
  try {
    if (!config_file.empty()) config = sanso::emulator::load_emulator_config(config_file);
    if (!world.empty()) config.world = world;
    if (!ground.empty()) config.world += "+" + ground;
    if (!directory.empty()) config.directory = directory;
    if (seed_option->count() > 0) config.seed = seed;
    config.usb = config.usb || usb;
    if (command.empty()) return serve(config);
    const std::string answer = sanso::emulator::tell_emulator(config.directory, command);
    fmt::print("{}\n", answer);
    return answer.find("\"ok\":true") != std::string::npos ? 0 : 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "sanso-emulator: {}\n", error.what());
    return 2;
  }
}
