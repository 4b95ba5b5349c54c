// An FTDI chip as USB shows it: control requests with state, bulk reads answered by packets with
// two status bytes, stalls, and a plug that can be pulled at any moment. It outlives its lines.
#pragma once

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <vector>

#include "firmware/board/usb/usb_line.h"

namespace sanso::board::testing {

class FakeChip : public UsbLibrary {
 public:
  using Packet = std::vector<std::uint8_t>;
  std::unique_ptr<UsbLine> open(const UsbIdentity& wanted, std::string& message) override;

  void plug() {
    const std::lock_guard lock(mutex);
    plugged = true;
  }
  void unplug() {
    const std::lock_guard lock(mutex);
    plugged = false;
    changed.notify_all();
  }
  /// The chip has received `data` on its serial side: one transfer, in packets of packet_bytes.
  void receive_serial(Bytes data, std::uint8_t line_status = 0) {
    Packet transfer;
    do {
      const std::size_t n = std::min(data.size(), packet_bytes - 2);
      transfer.insert(transfer.end(), {0x01, line_status});
      transfer.insert(transfer.end(), data.begin(), data.begin() + static_cast<std::ptrdiff_t>(n));
      data = data.subspan(n);
    } while (!data.empty());
    const std::lock_guard lock(mutex);
    transfers.push_back(transfer);
    changed.notify_all();
  }
  void stall(int times) {
    const std::lock_guard lock(mutex);
    stalls += times;
    changed.notify_all();
  }
  Packet sent_serial() {
    const std::lock_guard lock(mutex);
    return sent;
  }
  template <class Condition>
  bool wait_for(Condition&& condition) {
    std::unique_lock lock(mutex);
    return changed.wait_for(lock, std::chrono::seconds(60), condition);
  }

  std::mutex mutex;
  std::condition_variable changed;
  UsbIdentity id{0x0403, 0x6014, "FT1", 0x0900};
  std::size_t packet_bytes = 512, largest_write = 4096;
  bool plugged = true, keeps_latency = false, woken = false;
  int latency = 16, stalls = 0, most_reads = 0, cleared = 0;
  std::map<int, std::pair<std::uint16_t, std::uint16_t>> requests;  // last value, index by request
  std::deque<Packet> transfers;
  Packet sent;
};

class FakeLine final : public UsbLine {
 public:
  explicit FakeLine(FakeChip& chip) : chip_(chip) {}
  const UsbIdentity& identity() const override { return chip_.id; }
  std::size_t packet_bytes() const override { return chip_.packet_bytes; }
  Status control_out(std::uint8_t request, std::uint16_t value, std::uint16_t index) override {
    const std::lock_guard lock(chip_.mutex);
    if (!chip_.plugged) return Status::io_error;
    chip_.requests[request] = {value, index};
    if (request == 9 && !chip_.keeps_latency) chip_.latency = value;
    return Status::ok;
  }
  Result<std::size_t> control_in(std::uint8_t request, std::uint16_t, std::uint16_t,
                                 Buffer data) override {
    const std::lock_guard lock(chip_.mutex);
    if (!chip_.plugged || request != 10) return Status::io_error;
    data[0] = static_cast<std::uint8_t>(chip_.latency);
    return std::size_t{1};
  }
  Status submit_read(int slot, Buffer buffer) override {
    const std::lock_guard lock(chip_.mutex);
    if (!chip_.plugged) return Status::io_error;
    reads_.push_back({slot, buffer});
    chip_.most_reads = std::max(chip_.most_reads, static_cast<int>(reads_.size()));
    chip_.changed.notify_all();
    return Status::ok;
  }
  Status submit_write(Bytes data) override {
    const std::lock_guard lock(chip_.mutex);
    if (!chip_.plugged) return Status::io_error;
    const std::size_t n = std::min(data.size(), chip_.largest_write);
    chip_.sent.insert(chip_.sent.end(), data.begin(),
                      data.begin() + static_cast<std::ptrdiff_t>(n));
    written_.push_back(n);
    chip_.changed.notify_all();
    return Status::ok;
  }
  UsbEvent wait(int timeout_ms) override {
    std::unique_lock lock(chip_.mutex);
    const auto something = [&] {
      return chip_.woken || !written_.empty() || !chip_.plugged ||
             (!reads_.empty() && (!chip_.transfers.empty() || chip_.stalls > 0));
    };
    chip_.changed.wait_for(lock, std::chrono::milliseconds(timeout_ms), something);
    chip_.woken = false;
    UsbEvent event;
    if (!written_.empty()) {
      event.kind = UsbEvent::Kind::write;
      event.bytes = written_.front();
      written_.pop_front();
    } else if (!reads_.empty() &&
               (!chip_.plugged || chip_.stalls > 0 || !chip_.transfers.empty())) {
      end_read(event);
    }
    return event;
  }
  Status clear_stall(UsbEvent::Kind) override {
    const std::lock_guard lock(chip_.mutex);
    ++chip_.cleared;
    return Status::ok;
  }
  void wake() override {
    const std::lock_guard lock(chip_.mutex);
    chip_.woken = true;
    chip_.changed.notify_all();
  }

 private:
  void end_read(UsbEvent& event) {
    const auto [slot, buffer] = reads_.front();
    reads_.pop_front();
    event.kind = UsbEvent::Kind::read;
    event.slot = slot;
    if (!chip_.transfers.empty()) {
      const FakeChip::Packet transfer = chip_.transfers.front();
      chip_.transfers.pop_front();
      std::copy(transfer.begin(), transfer.end(), buffer.begin());
      event.bytes = transfer.size();
    } else if (!chip_.plugged) {
      event.outcome = UsbEvent::Outcome::gone;
    } else {
      --chip_.stalls;
      chip_.changed.notify_all();
      event.outcome = UsbEvent::Outcome::stalled;
    }
  }
  FakeChip& chip_;
  std::deque<std::pair<int, Buffer>> reads_;
  std::deque<std::size_t> written_;
};

inline std::unique_ptr<UsbLine> FakeChip::open(const UsbIdentity& wanted, std::string& message) {
  const std::lock_guard lock(mutex);
  const bool same = wanted.vendor == id.vendor && wanted.product == id.product &&
                    (wanted.serial.empty() || wanted.serial == id.serial);
  if (plugged && same) return std::make_unique<FakeLine>(*this);
  message = "not plugged in";
  return nullptr;
}

}  // namespace sanso::board::testing
