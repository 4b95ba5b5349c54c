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

#include "firmware/app/devices.h"
#include "firmware/app/firmware.h"
#include "firmware/app/servo_check.h"
#include "firmware/board/device_list.h"
#include "firmware/board/linux_clock.h"
#include "firmware/board/linux_socket.h"
#include "firmware/board/realtime.h"
#include "firmware/config/program_config.h"
#include "firmware/imu/hid_description.h"
#include "firmware/log/flight_recorder.h"

namespace {

using namespace sanso;

constexpr char kHelp[] =
    R"(sanso-firmware: the onboard controller of the OP3; a tick every 10 ms until SIGINT or SIGTERM

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
Exit codes: 0 stopped, or all servos ready; 1 the self-test found something; 2 could not start
(says why).
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

/// Calls `poll` with deadlines short enough to notice a stop. A poll that cannot wait, because its
/// device is gone, is followed by a sleep: no thread ever spins. What the tick waits for must not
/// wait for ordinary programs: real-time too, below the tick. Where that is not allowed the tick's
/// thread says so.
template <class Poll>
void run_poll(Poll poll, Nanoseconds wait, int priority) {
  (void)board::set_realtime_priority(std::max(priority, 1));
  board::LinuxClock clock;
  while (!stop_requested) {
    const Nanoseconds deadline = clock.now() + wait;
    if (poll(deadline) != Status::ok) board::LinuxClock::sleep_until(deadline);
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
      firmware::Board{*devices.bus, hid, devices.pose.get(), socket, clock, devices.mip.get()});
  warn(board::lock_memory());
  std::fprintf(stderr, "sanso-firmware: bus %s, imu %s, pose %s, hosts on UDP port %d\n",
               config.device.bus.c_str(), config.device.imu.c_str(),
               devices.pose ? config.device.pose.c_str() : "none", socket.port());

  mend_devices(devices, clock.now());  // what is there is there before the first tick
  const int priority = config.device.tick_priority;
  std::vector<std::thread> threads;
  threads.emplace_back([&] { run_devices(devices); });
  if (!config.settings.imu.from_board)
    threads.emplace_back([&] {
      run_poll([&](Nanoseconds deadline) { return controller->poll_imu(deadline); },
               5 * kMillisecond, priority - 10);
    });
  if (devices.pose)
    threads.emplace_back([&] {
      run_poll([&](Nanoseconds deadline) { return controller->poll_pose(deadline); },
               5 * kMillisecond, priority - 10);
    });
  threads.emplace_back([&] {
    const auto poll_link = [&](Nanoseconds deadline) {
      controller->poll_link(deadline);
      return Status::ok;
    };
    run_poll(poll_link, kMillisecond, priority - 20);
  });
  threads.emplace_back([&] { run_log(*controller, config.device.log_directory); });
  threads.emplace_back([&] { run_ticks(*controller, priority); });
  for (std::thread& thread : threads) thread.join();
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
  std::signal(SIGINT, request_stop);
  std::signal(SIGTERM, request_stop);
  return run(argv[2]);
}
