// The emulator as a process: an EmulatedRobot on the real clock, its bus on a pty, its sensors on
// packet sockets; or bus and IMU as USB devices of the running kernel.
#pragma once

#include <csignal>
#include <memory>
#include <optional>

#include "tools/emulator/emulated_robot.h"
#include "tools/emulator/emulator_config.h"
#include "tools/emulator/sockets.h"
#include "tools/emulator/usb/hid_function.h"
#include "tools/emulator/usb/usbip_plug.h"

namespace sanso::emulator {

class EmulatorProcess {
 public:
  /// Makes DIRECTORY/bus (link to the pty), imu, pose and control; with `usb` the first two are
  /// plugged into the kernel instead. Throws plant::WorldError.
  explicit EmulatorProcess(const EmulatorConfig& config);

  /// Serves until `stop` is set or the control socket says quit.
  void run(const volatile std::sig_atomic_t& stop);

  std::string bus_device() const { return bus_->device(); }
  /// How often the process woke up more than 20 ms late; the robot's clock then stood still for the
  /// excess.
  std::uint64_t stalls() const { return stalls_; }

 private:
  void serve_bus();
  void serve_sensors();
  bool serve_control();  // false: quit
  void wait_for_work(Nanoseconds wall);

  EmulatedRobot robot_;
  /// The IMU as a USB device.
  struct UsbImu {
    explicit UsbImu(EmulatedRobot& robot) : function(robot) { plug.plug(); }
    HidFunction function;
    UsbipPlug plug{function};
  };
  std::unique_ptr<BusEnd> bus_;
  std::optional<PacketServer> imu_;  // a robot as the factory delivers it has none
  std::optional<UsbImu> usb_imu_;
  PacketServer pose_, control_;
  int line_baud_ = 0;
  Nanoseconds wall_offset_ = 0;  // robot time = wall time - offset
  std::uint64_t stalls_ = 0;
};

}  // namespace sanso::emulator
