// sanso-firmware: builds the objects, starts the threads, passes SIGINT and SIGTERM on: the first
// lowers the robot, the second ends the program with torque as it is. No logic.
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "firmware/app/devices.h"
#include "firmware/app/firmware.h"
#include "firmware/app/servo_check.h"
#include "firmware/board/device_list.h"
#include "firmware/board/holders.h"
#include "firmware/board/linux_clock.h"
#include "firmware/board/linux_socket.h"
#include "firmware/board/realtime.h"
#include "firmware/board/service_manager.h"
#include "firmware/config/key_file.h"
#include "firmware/config/program_config.h"
#include "firmware/imu/hid_description.h"
#include "firmware/log/black_box.h"
#include "firmware/log/flight_recorder.h"
#include "firmware/log/times_file.h"

namespace {

using namespace sanso;

constexpr char kHelp[] =
    R"(sanso-firmware: the onboard controller of the OP3; a tick every 10 ms until SIGINT or SIGTERM
SIGINT or SIGTERM lowers the robot, switches its torque off and ends; a second one ends at once,
with torque left on. At the next start a robot that stands with torque on is adopted.
On a terminal the Enter key is an emergency stop: torque off at once.

usage: sanso-firmware --config FILE
       sanso-firmware --config FILE --self-test [--reboot] [--write-eeprom]
                                        one table of the 20 servos and what differs from what is
                                        wanted; reads only, unless told to reboot those that have
                                        shut down or to write the differences into their EEPROM
       sanso-firmware --devices         lists what is plugged in and can be bus or IMU, and why not

Example of FILE, on the robot:
  [device]
  bus = "/dev/serial/by-id/usb-FTDI_USB__-__Serial_Converter-if00-port0"
  imu = "opencr"                  # the OP3's own; or hidraw:VID:PID, hidapi-libusb:VID:PID:SERIAL,
                                  # hidapi-hidraw:VID:PID, mip:/dev/ttyACM0 (3DM-GX5)
  offsets = "offset.yaml"         # the robot's own, from the maker's tuner
  key_file = "robot.key"          # as on the host: (umask 077; openssl rand -hex 32 > robot.key)
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
Exit codes: 0 stopped, or all servos ready; 1 the self-test found something; 2 could not start
(says why).
)";

std::atomic<bool> stop_requested{false};  // the threads end
std::atomic<int> signals{0};
void take_signal(int) { ++signals; }

int refuse(const std::string& message) {
  std::fprintf(stderr, "sanso-firmware: %s\n", message.c_str());
  return 2;
}

void warn(const std::string& message) {
  if (!message.empty()) std::fprintf(stderr, "sanso-firmware: warning: %s\n", message.c_str());
}

/// The tick thread: absolute sleep to every due time; a missed one is skipped, not caught up.
void run_ticks(firmware::Firmware& controller, int priority, bool allow_without) {
  const std::string denied = board::set_realtime_priority(priority);
  warn(denied);
  if (!denied.empty() && !allow_without) controller.handover().arming_allowed = false;
  if (!controller.handover().arming_allowed)
    warn("arming will be refused (R121); device.allow_without_realtime = true allows it");
  board::LinuxClock clock;
  Nanoseconds due = clock.now() + kTickPeriod;
  while (!stop_requested) {
    board::LinuxClock::sleep_until(due);
    const Nanoseconds begin = clock.now();
    const bool works = controller.controller().state() > wire::SupervisorState::self_test;
    if (works) controller.handover().times.wake.add(begin - due);
    if (signals > 0) controller.handover().end_requested = true;
    controller.tick(begin);
    if (works) controller.handover().times.tick.add(clock.now() - begin);
    if (controller.handover().may_end || signals > 1) stop_requested = true;
    do due += kTickPeriod;
    while (due < clock.now());
  }
}

/// Calls `poll` with deadlines short enough to notice a stop. A poll that cannot wait, because its
/// device is gone, is followed by a sleep: no thread ever spins. What the tick waits for must not
/// wait for ordinary programs: real-time too, below the tick. Where that is not allowed the tick's
/// thread says so.
template <class Poll>
void run_poll(Poll poll, Nanoseconds wait, int priority) {
  if (priority > 0) (void)board::set_realtime_priority(priority);
  board::LinuxClock clock;
  while (!stop_requested) {
    const Nanoseconds deadline = clock.now() + wait;
    if (poll(deadline) != Status::ok) board::LinuxClock::sleep_until(deadline);
  }
}

/// The console's emergency stop: the Enter key.
void run_console(firmware::Firmware& controller) {
  if (isatty(STDIN_FILENO) == 0) return;
  std::signal(SIGTTIN, SIG_IGN);  // in the background the terminal belongs to somebody else
  while (!stop_requested) {
    board::LinuxClock clock;
    if (board::wait_readable(STDIN_FILENO, clock.now() + 20 * kMillisecond) <= 0) continue;
    std::array<char, 64> line;
    if (tcgetpgrp(STDIN_FILENO) != getpgrp()) {
      board::LinuxClock::sleep_until(clock.now() + kSecond);
      continue;
    }
    if (::read(STDIN_FILENO, line.data(), line.size()) <= 0) return;
    controller.handover().emergency_stop = true;
  }
}

/// Opens what is gone and says what happened; when to come back.
Nanoseconds mend_devices(const board::Devices& devices, Nanoseconds now) {
  Nanoseconds next = now + 50 * kMillisecond;
  for (board::Reconnecting* device : devices.all()) {
    next = std::min(next, device->mend(now));
    if (const std::string news = device->news(); !news.empty())
      std::fprintf(stderr, "sanso-firmware: %s\n", news.c_str());
  }
  return next;
}

/// The helper of the devices, at ordinary priority.
void run_devices(const board::Devices& devices) {
  board::LinuxClock clock;
  while (!stop_requested) board::LinuxClock::sleep_until(mend_devices(devices, clock.now()));
}

firmware::BlackBox make_black_box(const firmware::DeviceConfig& device, const std::string& boot) {
  constexpr double kMB = 1e6;
  const auto bytes = [](double megabytes) { return static_cast<std::uint64_t>(megabytes * kMB); };
  const firmware::BlackBoxLimits limits{
      bytes(device.log_file_MB),
      static_cast<Nanoseconds>(device.log_file_minutes * 60 * static_cast<double>(kSecond)),
      bytes(device.log_keep_MB)};
  return {device.log_keep_MB > 0 ? device.log_directory : "",
          boot,
          limits,
          {{"robot", device.robot_name},
           {"boot", boot},
           {"started_unix_s", std::to_string(std::time(nullptr))}}};
}

/// Tells systemd that ticks go by, several times in each period of its watchdog.
void run_watch(firmware::Firmware& controller, const board::ServiceManager& manager) {
  board::TickWatch watch(manager);
  Nanoseconds pause = 100 * kMillisecond;
  if (manager.watchdog_period() > 0) pause = std::min(pause, manager.watchdog_period() / 4);
  while (!stop_requested) {
    board::LinuxClock::sleep_until(board::LinuxClock().now() + pause);
    watch.look(controller.handover().ticks);
  }
}

/// The other master, when it is a program of this computer that has the same device open.
void tell_holders(const std::string& bus) {
  const std::string holders = board::holders_of(bus);
  if (!holders.empty())
    std::fprintf(stderr, "sanso-firmware: %s is also open in process %s\n", bus.c_str(),
                 holders.c_str());
}

/// Says state changes and faults in words, writes every tick and the flight record of a fault.
void run_log(firmware::Firmware& controller, const firmware::DeviceConfig& device,
             const board::ServiceManager& manager) {
  const std::string boot = firmware::boot_name();
  firmware::BlackBox box = make_black_box(device, boot);
  const auto keep = [&](const firmware::LogRecord& record) { box.take(record); };
  firmware::FlightRecorder recorder(controller.handover(), device.log_directory, boot);
  std::uint16_t told = 0;
  wire::SupervisorState state = wire::SupervisorState::boot;
  std::string complained, box_complained;
  std::uint64_t lost = 0;
  while (!stop_requested) {
    board::LinuxClock::sleep_until(board::LinuxClock().now() + 50 * kMillisecond);
    if (recorder.poll(keep))
      std::fprintf(stderr, "sanso-firmware: flight record in %s\n", recorder.last_file().c_str());
    if (recorder.error() != complained) warn(complained = recorder.error());
    if (box.error() != box_complained) warn(box_complained = box.error());
    if (box.error().empty() && box.lost() != lost)
      warn(std::to_string(lost = box.lost()) + " ticks are in no log so far");
    const firmware::LogRecord record = recorder.newest();
    if (record.observation.state != state) {
      state = record.observation.state;
      std::fprintf(stderr, "sanso-firmware: t=%.2f s: %s\n", to_seconds(record.observation.time),
                   firmware::name_of(state));
      manager.status(firmware::name_of(state));
    }
    if (record.observation.fault != told) {
      told = record.observation.fault;
      if (told != 0)
        std::fprintf(stderr, "sanso-firmware: F%d %s (%d) at t=%.2f s; docs/faults.md#f%d\n", told,
                     firmware::name_of(static_cast<firmware::Fault>(told)), record.fault_detail,
                     to_seconds(record.observation.time), told);
      if (told == static_cast<std::uint16_t>(firmware::Fault::bus_foreign))
        tell_holders(device.bus);
    }
  }
}

/// All threads of the program; they end when a stop is requested. The arguments outlive them.
std::vector<std::thread> start_threads(firmware::Firmware& controller,
                                       const board::Devices& devices,
                                       const firmware::ProgramConfig& config,
                                       const board::ServiceManager& manager) {
  const int priority = config.device.tick_priority;
  std::vector<std::thread> threads;
  threads.emplace_back([&] { run_devices(devices); });
  if (!config.settings.imu.from_board)
    threads.emplace_back([&, priority] {
      run_poll([&](Nanoseconds deadline) { return controller.poll_imu(deadline); },
               5 * kMillisecond, std::max(priority - 10, 1));
    });
  if (devices.pose)
    threads.emplace_back([&, priority] {
      run_poll([&](Nanoseconds deadline) { return controller.poll_pose(deadline); },
               5 * kMillisecond, std::max(priority - 10, 1));
    });
  threads.emplace_back([&] {
    // an ordinary thread: the tick never waits for it, and a flood must not eat its time
    const auto poll_link = [&](Nanoseconds deadline) {
      controller.poll_link(deadline);
      return Status::ok;
    };
    run_poll(poll_link, kMillisecond, 0);
  });
  threads.emplace_back([&] { run_log(controller, config.device, manager); });
  threads.emplace_back([&] { run_console(controller); });
  if (manager.present()) threads.emplace_back([&] { run_watch(controller, manager); });
  threads.emplace_back(
      [&, priority] { run_ticks(controller, priority, config.device.allow_without_realtime); });
  return threads;
}

/// One line at the end; with a log directory the histograms too.
void tell_times(const firmware::TickTimes& times, const std::string& directory) {
  std::fputs(firmware::times_line(times).c_str(), stderr);
  if (directory.empty()) return;
  const std::string file = directory + "/times-" + firmware::boot_name() + ".csv";
  if (!firmware::write_times(times, file)) warn(file + ": cannot be written");
}

int run(const std::string& config_path) {
  firmware::ProgramConfig config;
  std::string error;
  wire::Key key{};
  if (!firmware::read_program_config(config_path, config, error)) return refuse(error);
  if (!firmware::read_key_file(config.device.key_file, key, error)) return refuse(error);

  board::LinuxClock clock;
  board::Devices devices;
  if (!board::make_devices(config.device, config.settings.bus, devices, error))
    return refuse(error);
  if (devices.imu)
    devices.imu->set_explanation(
        [&imu = *devices.imu] { return firmware::why_no_imu(imu.last_descriptor()); });
  board::NoHid no_hid;
  board::HidSource& hid = devices.imu ? static_cast<board::HidSource&>(*devices.imu) : no_hid;
  board::UdpSocket socket;
  if (socket.open(config.device.listen, config.device.port, error) != Status::ok)
    return refuse(error);

  const auto controller = std::make_unique<firmware::Firmware>(
      config.settings, key,
      firmware::Board{*devices.bus, hid, devices.pose.get(), socket, clock, devices.mip.get()},
      config.device.robot_name);
  const std::string not_locked = board::lock_memory();
  warn(not_locked);
  if (!not_locked.empty() && !config.device.allow_without_realtime)
    controller->handover().arming_allowed = false;
  std::fprintf(stderr, "sanso-firmware: bus %s, imu %s, pose %s, hosts on UDP port %d\n",
               config.device.bus.c_str(), config.device.imu.c_str(),
               devices.pose ? config.device.pose.c_str() : "none", socket.port());

  const board::ServiceManager manager;
  mend_devices(devices, clock.now());  // what is there is there before the first tick
  std::vector<std::thread> threads = start_threads(*controller, devices, config, manager);
  for (std::thread& thread : threads) thread.join();
  manager.stopping();
  tell_times(controller->handover().times, config.device.log_directory);
  if (controller->controller().torque_on())
    std::fprintf(stderr, "sanso-firmware: ended with torque on: the robot holds its last goals\n");
  return 0;
}

/// Looks at all servos; reboots and writes only when asked to.
int self_test(const std::string& config_path, bool reboot, bool write_eeprom) {
  firmware::ProgramConfig config;
  std::string error;
  if (!firmware::read_program_config(config_path, config, error)) return refuse(error);
  const firmware::BusSettings& settings = config.settings.bus;
  board::SwitchedBus bus(config.device);
  if (!bus.set_baud(static_cast<int>(settings.byte_rate_baud))) return refuse(bus.message());
  board::LinuxClock clock;
  firmware::ServoCheck check(settings, bus, clock, [&](int baud) { return bus.set_baud(baud); });
  if (!check.power_up())
    return refuse(
        "OpenCR (id 200) does not answer: battery, cable, bus.byte_rate_baud? Without an "
        "OpenCR set bus.require_opencr = false");
  std::vector<firmware::ServoRow> rows = check.look();
  std::fputs(firmware::servo_table(rows).c_str(), stdout);
  if (reboot) std::printf("\n%d servos rebooted\n", check.reboot(rows));
  if (write_eeprom) std::printf("\n%d registers written to EEPROM\n", check.write_eeprom(rows));
  if (reboot || write_eeprom) {
    rows = check.look();
    std::fputs(firmware::servo_table(rows).c_str(), stdout);
  }
  const auto good = [](const firmware::ServoRow& row) { return row.good(); };
  if (std::all_of(rows.begin(), rows.end(), good)) {
    std::puts("all 20 servos are ready");
    return 0;
  }
  std::puts("not ready; --write-eeprom mends what differs, --reboot those that have shut down");
  return 1;
}

int list_devices() {
  const board::HidJudge judge = firmware::why_no_imu;
  std::string text = board::device_table("serial devices (tty driver)", board::list_ttys({}));
#ifdef SANSO_HAVE_USB
  text += board::device_table("FTDI chips (libusb)", board::list_ftdi());
#endif
  text += board::device_table("HID devices (hidraw)", board::list_hidraw({}, judge));
#ifdef SANSO_HAVE_USB
  text += board::device_table("HID devices (hidapi)", board::list_hidapi(judge));
#endif
  std::fputs(text.c_str(), stdout);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 2 && std::strcmp(argv[1], "--help") == 0) {
    std::fputs(kHelp, stdout);
    return 0;
  }
  if (argc == 2 && std::strcmp(argv[1], "--devices") == 0) return list_devices();
  const std::vector<std::string> words(argv + 1, argv + argc);
  const auto said = [&](const char* word) {
    return std::find(words.begin(), words.end(), word) != words.end();
  };
  const bool configured = words.size() >= 2 && words[0] == "--config";
  if (configured && said("--self-test"))
    return self_test(words[1], said("--reboot"), said("--write-eeprom"));
  if (!configured || words.size() != 2)
    return refuse("expected --config FILE; sanso-firmware --help shows an example");
  std::signal(SIGINT, take_signal);
  std::signal(SIGTERM, take_signal);
  return run(argv[2]);
}
