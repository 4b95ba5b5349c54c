// Devices that go and come back. A device belongs to the thread that reads it while it is up, and
// to the helper thread while it is not: the helper opens it again, with pauses that grow from 10 ms
// to 1 s, so that no real-time thread ever opens, allocates or spins.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "firmware/board/board.h"

namespace sanso::board {

/// A device that can be opened by name, as often as needed.
class Openable {
 public:
  virtual ~Openable() = default;
  /// Closes what is open and opens anew. May block. `message` says what failed and what to do; with
  /// ok what is not as good as it should be, if anything.
  virtual Status open(std::string& message) = 0;
};

class OpenableSerial : public SerialPort, public Openable {};
class OpenableHid : public HidSource, public Openable {};
class OpenablePose : public PoseSource, public Openable {};

/// The state of one device: who may touch it, and when to try again.
class Reconnecting {
 public:
  Reconnecting(std::string name, Openable& device) : name_(std::move(name)), device_(device) {}
  virtual ~Reconnecting() = default;
  Reconnecting(const Reconnecting&) = delete;
  Reconnecting& operator=(const Reconnecting&) = delete;

  bool up() const { return up_.load(std::memory_order_acquire); }
  const std::string& name() const { return name_; }
  /// How often it was opened.
  std::uint32_t openings() const { return openings_.load(std::memory_order_relaxed); }

  // --- the reading thread ---
  /// The device failed, or turned out to be something else: the helper's from now on.
  void let_go() { up_.store(false, std::memory_order_release); }
  /// It delivered something: the next loss begins with the shortest pause again.
  void delivered() { delivered_.store(true, std::memory_order_relaxed); }

  // --- the helper thread ---
  /// Opens the device when it is down and its pause is over. Returns when to come back.
  Nanoseconds mend(Nanoseconds now);
  /// What there is to say since the last call: gone and why, or back. Empty: nothing new.
  std::string news();
  /// Called by mend() before it opens anew; what it returns is said beside "gone".
  void set_explanation(std::function<std::string()> why) { explanation_ = std::move(why); }

 private:
  std::string name_;
  Openable& device_;
  std::atomic<bool> up_{false};
  std::atomic<bool> delivered_{false};
  std::atomic<std::uint32_t> openings_{0};
  std::function<std::string()> explanation_;
  Nanoseconds pause_ = 0, next_ = 0;
  bool was_up_ = false;
  std::string news_, told_;
};

/// The servo bus behind Reconnecting.
class ReconnectingSerial final : public SerialPort, public Reconnecting {
 public:
  ReconnectingSerial(std::string name, std::unique_ptr<OpenableSerial> port)
      : Reconnecting(std::move(name), *port), port_(std::move(port)) {}
  Status write(Bytes data) override;
  Result<std::size_t> read(Buffer buffer, Nanoseconds deadline) override;
  /// ok when the helper has the device back, else not_ready. Never blocks.
  Status ready() override { return up() ? Status::ok : Status::not_ready; }

 private:
  std::unique_ptr<OpenableSerial> port_;
};

/// An IMU behind Reconnecting. While it is down the descriptor is empty.
class ReconnectingHid final : public HidSource, public Reconnecting {
 public:
  ReconnectingHid(std::string name, std::unique_ptr<OpenableHid> hid)
      : Reconnecting(std::move(name), *hid), hid_(std::move(hid)) {}
  Bytes descriptor() override { return up() ? hid_->descriptor() : Bytes{}; }
  HidIdentity identity() override { return up() ? hid_->identity() : HidIdentity{}; }
  Status set_feature(Bytes report) override;
  Result<std::size_t> get_feature(Buffer report) override;
  Result<std::size_t> read(Buffer buffer, Nanoseconds deadline) override;
  void reject() override { let_go(); }
  /// For the helper thread while the device is down: the last descriptor.
  Bytes last_descriptor() { return hid_->descriptor(); }

 private:
  std::unique_ptr<OpenableHid> hid_;
};

/// A pose source behind Reconnecting.
class ReconnectingPose final : public PoseSource, public Reconnecting {
 public:
  ReconnectingPose(std::string name, std::unique_ptr<OpenablePose> pose)
      : Reconnecting(std::move(name), *pose), pose_(std::move(pose)) {}
  Result<std::size_t> read(Buffer buffer, Nanoseconds deadline) override;

 private:
  std::unique_ptr<OpenablePose> pose_;
};

}  // namespace sanso::board
