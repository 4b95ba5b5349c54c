// sanso-firmware: builds the objects, starts the threads, stops on SIGINT or SIGTERM. No logic.
#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "firmware/app/firmware.h"
#include "firmware/board/linux_clock.h"
#include "firmware/board/linux_hidraw.h"
#include "firmware/board/linux_serial.h"
#include "firmware/board/linux_socket.h"
#include "firmware/board/realtime.h"
#include "firmware/config/program_config.h"
#include "firmware/log/flight_recorder.h"

namespace {

using namespace sanso;

constexpr char kHelp[] =
    R"(sanso-firmware: the onboard controller of the OP3; a tick every 10 ms until SIGINT or SIGTERM

usage: sanso-firmware --config FILE

Example of FILE, on the robot:
  [device]
  bus = "/dev/serial/by-id/usb-FTDI_USB__-__Serial_Converter-if00-port0"
  imu = "/dev/hidraw0"
  key_file = "robot.key"          # 64 hexadecimal digits, as on the host (openssl rand -hex 32)
  log_directory = "/var/log/sanso"

Example against `sanso-emulator --dir /tmp/sanso-robot`:
  [device]
  bus = "/tmp/sanso-robot/bus"
  imu = "unix:/tmp/sanso-robot/imu"
  pose = "unix:/tmp/sanso-robot/pose"
  key_file = "robot.key"
  listen = "127.0.0.1"            # hosts of this machine only
  port = 7531

All settings: docs/settings.md. On a robot: docs/howto/robot.md. Faults: docs/faults.md.
Exit codes: 0 stopped, 2 could not start (says why).
)";

std::atomic<bool> stop_requested{false};
void request_stop(int) { stop_requested = true; }

int refuse(const std::string& message) {
  std::fprintf(stderr, "sanso-firmware: %s\n", message.c_str());
  return 2;
}

void warn(const std::string& message) {
  if (!message.empty()) std::fprintf(stderr, "sanso-firmware: warning: %s\n", message.c_str());
}

/// PATH of "unix:PATH"; empty when it is something else.
std::string socket_path(const std::string& device) {
  return device.rfind("unix:", 0) == 0 ? device.substr(5) : std::string();
}

bool read_key(const std::string& path, wire::Key& key, std::string& error) {
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  const std::string digits = text.str();
  const Result<wire::Key> read = wire::key_from_hex(digits);
  if (!file || !read.ok())
    error = "device.key_file = '" + path +
            "': expected a file of 64 hexadecimal digits (make one with: openssl rand -hex 32)";
  key = *read;
  return error.empty();
}

std::unique_ptr<board::HidSource> open_imu(const std::string& device, std::string& error) {
  if (const std::string path = socket_path(device); !path.empty()) {
    auto hid = std::make_unique<board::SocketHid>(path);
    if (hid->open(error) != Status::ok) return nullptr;
    return hid;
  }
  auto hid = std::make_unique<board::LinuxHidraw>(device);
  if (hid->open(error) != Status::ok) return nullptr;
  return hid;
}

std::unique_ptr<board::PoseSource> open_pose(const std::string& device, std::string& error) {
  if (device.empty()) return nullptr;
  const std::string path = socket_path(device);
  if (path.empty()) {
    error = "device.pose = '" + device + "': expected unix:PATH";
    return nullptr;
  }
  auto pose = std::make_unique<board::SocketPose>(path);
  if (pose->open(error) != Status::ok) return nullptr;
  return pose;
}

/// The tick thread: absolute sleep to every due time; a missed one is skipped, not caught up.
void run_ticks(firmware::Firmware& controller, int priority) {
  warn(board::set_realtime_priority(priority));
  board::LinuxClock clock;
  Nanoseconds due = clock.now() + kTickPeriod;
  while (!stop_requested) {
    board::LinuxClock::sleep_until(due);
    const Nanoseconds begin = clock.now();
    controller.tick(begin);
    do due += kTickPeriod;
    while (due < clock.now());
  }
}

/// Calls `poll` with deadlines short enough to notice a stop. What the tick waits for must not wait
/// for ordinary programs:
/// real-time too, below the tick. Where that is not allowed the tick's thread says so.
template <class Poll>
void run_poll(Poll poll, Nanoseconds wait, int priority) {
  (void)board::set_realtime_priority(std::max(priority, 1));
  board::LinuxClock clock;
  while (!stop_requested) {
    const Nanoseconds deadline = clock.now() + wait;
    poll(deadline);
  }
}

/// Says state changes and faults in words, and writes the flight record of a fault.
void run_log(firmware::Firmware& controller, const std::string& directory) {
  firmware::FlightRecorder recorder(controller.handover(), directory);
  std::uint16_t told = 0;
  std::string complained;
  while (!stop_requested) {
    board::LinuxClock::sleep_until(board::LinuxClock().now() + 50 * kMillisecond);
    if (recorder.poll())
      std::fprintf(stderr, "sanso-firmware: flight record in %s\n", recorder.last_file().c_str());
    if (recorder.error() != complained) warn(complained = recorder.error());
    const firmware::LogRecord record = recorder.newest();
    if (record.observation.fault != told) {
      told = record.observation.fault;
      if (told != 0)
        std::fprintf(stderr, "sanso-firmware: F%d %s (%d) at t=%.2f s; docs/faults.md#f%d\n", told,
                     firmware::name_of(static_cast<firmware::Fault>(told)), record.fault_detail,
                     to_seconds(record.observation.time), told);
    }
  }
}

int run(const std::string& config_path) {
  firmware::ProgramConfig config;
  std::string error;
  wire::Key key{};
  if (!firmware::read_program_config(config_path, config, error)) return refuse(error);
  if (!read_key(config.device.key_file, key, error)) return refuse(error);

  board::LinuxClock clock;
  board::LinuxSerial bus(config.device.bus, static_cast<int>(config.settings.bus.byte_rate_baud));
  if (bus.open(error) != Status::ok) return refuse(error);
  warn(bus.warning());
  const auto imu = open_imu(config.device.imu, error);
  if (imu == nullptr) return refuse(error);
  const auto pose = open_pose(config.device.pose, error);
  if (!error.empty()) return refuse(error);
  board::UdpSocket socket;
  if (socket.open(config.device.listen, config.device.port, error) != Status::ok)
    return refuse(error);

  const auto controller = std::make_unique<firmware::Firmware>(
      config.settings, key, firmware::Board{bus, *imu, pose.get(), socket, clock});
  warn(board::lock_memory());
  std::fprintf(stderr, "sanso-firmware: bus %s, imu %s, pose %s, hosts on UDP port %d\n",
               config.device.bus.c_str(), config.device.imu.c_str(),
               pose ? config.device.pose.c_str() : "none", socket.port());

  const int priority = config.device.tick_priority;
  std::vector<std::thread> threads;
  threads.emplace_back([&] {
    run_poll([&](Nanoseconds deadline) { controller->poll_imu(deadline); }, 5 * kMillisecond,
             priority - 10);
  });
  if (pose)
    threads.emplace_back([&] {
      run_poll([&](Nanoseconds deadline) { controller->poll_pose(deadline); }, 5 * kMillisecond,
               priority - 10);
    });
  threads.emplace_back([&] {
    run_poll([&](Nanoseconds deadline) { controller->poll_link(deadline); }, kMillisecond,
             priority - 20);
  });
  threads.emplace_back([&] { run_log(*controller, config.device.log_directory); });
  threads.emplace_back([&] { run_ticks(*controller, priority); });
  for (std::thread& thread : threads) thread.join();
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 2 && std::strcmp(argv[1], "--help") == 0) {
    std::fputs(kHelp, stdout);
    return 0;
  }
  if (argc != 3 || std::strcmp(argv[1], "--config") != 0)
    return refuse("expected --config FILE; sanso-firmware --help shows an example");
  std::signal(SIGINT, request_stop);
  std::signal(SIGTERM, request_stop);
  return run(argv[2]);
}
