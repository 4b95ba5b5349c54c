// The devices that the settings name, closed at first: the helper thread opens them (reconnect.h).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "firmware/board/reconnect.h"
#include "firmware/config/program_config.h"

namespace sanso::board {

struct Devices {
  std::unique_ptr<ReconnectingSerial> bus;
  std::unique_ptr<ReconnectingHid> imu;     // null: another source
  std::unique_ptr<ReconnectingSerial> mip;  // a 3DM-GX5 instead of a HID sensor
  std::unique_ptr<ReconnectingPose> pose;   // null: none wanted

  /// Every device there is, for the helper thread.
  std::vector<Reconnecting*> all() const;
};

/// The servo bus alone, at this speed; null: `error` says which name is none.
std::unique_ptr<OpenableSerial> make_bus(const firmware::DeviceConfig& config, int baud,
                                         std::string& error);

/// A bus whose speed can change: opens the device anew for each.
class SwitchedBus final : public SerialPort {
 public:
  explicit SwitchedBus(const firmware::DeviceConfig& config) : config_(config) {}
  /// False: message() says why.
  bool set_baud(int baud);
  const std::string& message() const { return message_; }
  Status write(Bytes data) override { return port_ ? port_->write(data) : Status::io_error; }
  Result<std::size_t> read(Buffer buffer, Nanoseconds deadline) override {
    return port_ ? port_->read(buffer, deadline) : Result<std::size_t>(Status::io_error);
  }
  Status ready() override { return port_ ? port_->ready() : Status::not_ready; }

 private:
  firmware::DeviceConfig config_;
  std::unique_ptr<OpenableSerial> port_;
  int baud_ = 0;
  std::string message_;
};

/// Builds what the configuration names; opens nothing. False: `error` says which name is none.
bool make_devices(const firmware::DeviceConfig& config, const firmware::BusSettings& bus,
                  Devices& devices, std::string& error);

/// Stands where a HID sensor would: never there.
class NoHid final : public HidSource {
 public:
  Bytes descriptor() override { return {}; }
  Status set_feature(Bytes) override { return Status::io_error; }
  Result<std::size_t> read(Buffer, Nanoseconds) override { return Status::io_error; }
};

}  // namespace sanso::board
