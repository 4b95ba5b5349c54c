// One thread: advance to the wall clock, serve bus, sensors and control, wait. After a stall
// emulated time is shifted, not caught up.
#include "tools/emulator/emulator_process.h"

#include <poll.h>
#include <sys/stat.h>
#include <time.h>

#include <algorithm>
#include <filesystem>

#include "shared/servo_bus/xm430.h"
#include "tools/emulator/control.h"
#include "tools/emulator/usb/usb_bus.h"
#include "tools/plant/world_error.h"

namespace sanso::emulator {
namespace {

constexpr Nanoseconds kSensorPeriod = 1 * kMillisecond;  // one report slot of the IMU's endpoint
// reply bytes are handed over in lots of about this length
constexpr Nanoseconds kReplyGrain = 100 * kMicrosecond;
constexpr Nanoseconds kStall = 20 * kMillisecond;

Nanoseconds wall_now() {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return t.tv_sec * kSecond + t.tv_nsec;
}

std::string prepared(const std::string& directory) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (error)
    throw plant::WorldError("cannot make the directory " + directory + ": " + error.message());
  chmod(directory.c_str(), 0700);  // whoever can talk to these sockets can move the robot
  return directory;
}

}  // namespace

EmulatorProcess::EmulatorProcess(const EmulatorConfig& config)
    : robot_(plant::load_world(config.world), config.seed, config.baud),
      pose_(prepared(config.directory) + "/pose"),
      control_(config.directory + "/control") {
  for (const Fault& fault : config.faults) robot_.faults().add(fault);
  for (const ServoSetup& servo : config.servos) robot_.set_up(servo);
  if (config.usb)
    bus_ = std::make_unique<UsbBus>();
  else
    bus_ = std::make_unique<BusPty>(config.directory + "/bus");
  bus_->plug();
  if (config.hid_imu && config.usb) usb_imu_.emplace(robot_);
  if (config.hid_imu && !config.usb) imu_.emplace(config.directory + "/imu");
}

void EmulatorProcess::run(const volatile std::sig_atomic_t& stop) {
  wall_offset_ = wall_now() - robot_.now();
  while (!stop) {
    Nanoseconds wall = wall_now();
    if (wall - wall_offset_ - robot_.now() >
        kStall) {  // the machine gave us no time: do not race after it
      wall_offset_ = wall - robot_.now() - kSensorPeriod;
      ++stalls_;
    }
    robot_.advance(wall - wall_offset_);
    serve_bus();
    serve_sensors();
    if (!serve_control()) return;
    wait_for_work(wall_now());
  }
}

void EmulatorProcess::serve_bus() {
  std::uint8_t buffer[4096];
  (void)bus_->serve(robot_.now());
  // a client that sets no speed of the servos' (a pty begins with 38400) talks at theirs
  const auto& rates = servo_bus::xm430::kBaudRates;
  const int baud = bus_->baud();
  if (baud != line_baud_ && std::find(rates.begin(), rates.end(), baud) != rates.end()) {
    line_baud_ = baud;
    robot_.set_line_baud(baud);
  }
  for (std::size_t count; (count = bus_->read(buffer)) > 0;) robot_.bus_write({buffer, count});
  for (std::size_t count; (count = robot_.bus_read(buffer)) > 0;) bus_->write({buffer, count});
}

void EmulatorProcess::serve_sensors() {
  std::uint8_t buffer[256];
  int client = -1;
  if (imu_) {
    for (const int added : imu_->accept_new()) imu_->send(added, EmulatedRobot::imu_descriptor());
    for (std::size_t size; (size = imu_->receive(buffer, client)) > 0;)
      robot_.imu_set_feature({buffer, size});
    for (std::size_t size; (size = robot_.imu_read(buffer)) > 0;) imu_->send_all({buffer, size});
  }
  if (usb_imu_) usb_imu_->plug.serve(robot_.now());
  pose_.accept_new();
  while (pose_.receive(buffer, client) > 0) {
  }
  for (std::size_t size; (size = robot_.pose_read(buffer)) > 0;) pose_.send_all({buffer, size});
}

bool EmulatorProcess::serve_control() {
  std::uint8_t buffer[8192];
  int client = -1;
  control_.accept_new();
  for (std::size_t size; (size = control_.receive(buffer, client)) > 0;) {
    const ControlAnswer answer =
        execute_command(robot_, {reinterpret_cast<const char*>(buffer), size});
    control_.send(client,
                  {reinterpret_cast<const std::uint8_t*>(answer.json.data()), answer.json.size()});
    switch (answer.request) {
      case ProcessRequest::none:
        break;
      case ProcessRequest::unplug_bus:
        bus_->unplug();
        break;
      case ProcessRequest::replug_bus:
        bus_->plug();
        break;
      case ProcessRequest::quit:
        return false;
    }
  }
  return true;
}

/// Sleeps until a client speaks, a reply is due, or the next sensor slot: absolute times, so that
/// no error adds up.
void EmulatorProcess::wait_for_work(Nanoseconds wall) {
  const Nanoseconds now = robot_.now();
  Nanoseconds next = (now / kSensorPeriod + 1) * kSensorPeriod;
  if (const Nanoseconds byte = robot_.next_bus_byte(); byte != kNever)
    next = std::min(next, byte + kReplyGrain);
  next = std::min(next, bus_->serve(now));
  const Nanoseconds wait = std::max<Nanoseconds>(0, next + wall_offset_ - wall);

  std::vector<int> descriptors;
  if (bus_->fd() >= 0) descriptors.push_back(bus_->fd());
  if (usb_imu_ && usb_imu_->plug.fd() >= 0) descriptors.push_back(usb_imu_->plug.fd());
  if (imu_) imu_->add_descriptors(descriptors);
  pose_.add_descriptors(descriptors);
  control_.add_descriptors(descriptors);
  std::vector<pollfd> polled;
  polled.reserve(descriptors.size());
  for (const int fd : descriptors) polled.push_back({fd, POLLIN, 0});
  const timespec timeout{wait / kSecond, wait % kSecond};
  ppoll(polled.data(), polled.size(), &timeout, nullptr);
}

}  // namespace sanso::emulator
