// Asynchronous bulk transfers that are allocated once; their callbacks only note what ended, in the
// thread that waits for events.
#include "firmware/board/usb/libusb_line.h"

#include <libusb-1.0/libusb.h>

#include <array>
#include <cstdio>
#include <deque>
#include <memory>
#include <utility>

namespace sanso::board {
namespace {

constexpr unsigned char kBulkIn = 0x81, kBulkOut = 0x02;  // of every FTDI chip's first channel
constexpr std::uint8_t kVendorOut = 0x40, kVendorIn = 0xC0;
constexpr unsigned kControlTimeout_ms = 500;
constexpr int kInterface = 0;

std::string hex_name(std::uint16_t vendor, std::uint16_t product) {
  char text[16];
  std::snprintf(text, sizeof text, "%04x:%04x", vendor, product);
  return text;
}

std::string what_to_do(int error) {
  std::string text = libusb_strerror(static_cast<libusb_error>(error));
  if (error == LIBUSB_ERROR_ACCESS) text += "; a udev rule has to give this user the device";
  if (error == LIBUSB_ERROR_BUSY) text += "; another program holds it, stop it first";
  return text;
}

UsbIdentity identity_of(libusb_device* device, libusb_device_handle* handle) {
  libusb_device_descriptor d{};
  libusb_get_device_descriptor(device, &d);
  UsbIdentity id{d.idVendor, d.idProduct, {}, d.bcdDevice};
  std::array<unsigned char, 128> serial{};
  if (handle != nullptr && d.iSerialNumber != 0) {
    const int n = libusb_get_string_descriptor_ascii(handle, d.iSerialNumber, serial.data(),
                                                     static_cast<int>(serial.size()));
    if (n > 0)
      id.serial.assign(reinterpret_cast<const char*>(serial.data()), static_cast<std::size_t>(n));
  }
  return id;
}

using Context = std::shared_ptr<libusb_context>;

Context new_context() {
  libusb_context* context = nullptr;
  if (libusb_init(&context) != 0) return nullptr;
  return {context, libusb_exit};
}

class LibusbLine final : public UsbLine {
 public:
  LibusbLine(Context context, libusb_device_handle* handle, UsbIdentity identity)
      : context_(std::move(context)), handle_(handle), identity_(std::move(identity)) {
    const int packet = libusb_get_max_packet_size(libusb_get_device(handle), kBulkIn);
    packet_bytes_ = packet > 0 ? static_cast<std::size_t>(packet) : 64;
    for (int i = 0; i <= kReads; ++i) {
      Job& job = jobs_[static_cast<std::size_t>(i)];
      job.owner = this;
      job.transfer = libusb_alloc_transfer(0);
      job.slot = i;
    }
  }
  ~LibusbLine() override {
    for (Job& job : jobs_)
      if (job.busy) libusb_cancel_transfer(job.transfer);
    // the library still owns what is busy: its end has to come first. A device that is gone ends at
    // once; should one not, its memory is left alone rather than freed under the kernel's hands.
    for (int i = 0; i < 50 && any_busy(); ++i) handle_events(20);
    for (Job& job : jobs_)
      if (!job.busy) libusb_free_transfer(job.transfer);
    libusb_release_interface(handle_, kInterface);
    libusb_close(handle_);
  }
  LibusbLine(const LibusbLine&) = delete;
  LibusbLine& operator=(const LibusbLine&) = delete;

  const UsbIdentity& identity() const override { return identity_; }
  std::size_t packet_bytes() const override { return packet_bytes_; }
  Status control_out(std::uint8_t request, std::uint16_t value, std::uint16_t index) override {
    return libusb_control_transfer(handle_, kVendorOut, request, value, index, nullptr, 0,
                                   kControlTimeout_ms) >= 0
               ? Status::ok
               : Status::io_error;
  }
  Result<std::size_t> control_in(std::uint8_t request, std::uint16_t value, std::uint16_t index,
                                 Buffer data) override {
    const int n =
        libusb_control_transfer(handle_, kVendorIn, request, value, index, data.data(),
                                static_cast<std::uint16_t>(data.size()), kControlTimeout_ms);
    if (n < 0) return Status::io_error;
    return static_cast<std::size_t>(n);
  }
  Status submit_read(int slot, Buffer buffer) override {
    return submit(jobs_[static_cast<std::size_t>(slot)], kBulkIn, buffer.data(), buffer.size());
  }
  Status submit_write(Bytes data) override {
    return submit(jobs_[kReads], kBulkOut, const_cast<std::uint8_t*>(data.data()), data.size());
  }
  UsbEvent wait(int timeout_ms) override {
    if (ended_.empty()) handle_events(timeout_ms);
    if (ended_.empty()) return {};
    const UsbEvent event = ended_.front();
    ended_.pop_front();
    return event;
  }
  Status clear_stall(UsbEvent::Kind which) override {
    const unsigned char endpoint = which == UsbEvent::Kind::read ? kBulkIn : kBulkOut;
    return libusb_clear_halt(handle_, endpoint) == 0 ? Status::ok : Status::io_error;
  }
  void wake() override { libusb_interrupt_event_handler(context_.get()); }

 private:
  struct Job {
    LibusbLine* owner = nullptr;
    libusb_transfer* transfer = nullptr;
    int slot = 0;  // kReads: the write
    bool busy = false;
  };

  bool any_busy() const {
    for (const Job& job : jobs_)
      if (job.busy) return true;
    return false;
  }
  void handle_events(int timeout_ms) {
    timeval wait{timeout_ms / 1000, (timeout_ms % 1000) * 1000};
    libusb_handle_events_timeout_completed(context_.get(), &wait, nullptr);
  }
  Status submit(Job& job, unsigned char endpoint, std::uint8_t* data, std::size_t size) {
    if (job.transfer == nullptr || job.busy) return Status::io_error;
    libusb_fill_bulk_transfer(job.transfer, handle_, endpoint, data, static_cast<int>(size), ended,
                              &job, 0);
    job.busy = libusb_submit_transfer(job.transfer) == 0;
    return job.busy ? Status::ok : Status::io_error;
  }
  static void LIBUSB_CALL ended(libusb_transfer* transfer) {
    Job& job = *static_cast<Job*>(transfer->user_data);
    job.busy = false;
    UsbEvent event;
    event.kind = job.slot == kReads ? UsbEvent::Kind::write : UsbEvent::Kind::read;
    event.slot = job.slot;
    event.bytes = static_cast<std::size_t>(transfer->actual_length);
    if (transfer->status == LIBUSB_TRANSFER_STALL)
      event.outcome = UsbEvent::Outcome::stalled;
    else if (transfer->status != LIBUSB_TRANSFER_COMPLETED)
      event.outcome = UsbEvent::Outcome::gone;
    job.owner->ended_.push_back(event);
  }

  Context context_;
  libusb_device_handle* handle_;
  UsbIdentity identity_;
  std::size_t packet_bytes_ = 64;
  std::array<Job, kReads + 1> jobs_;
  std::deque<UsbEvent> ended_;
};

}  // namespace

std::vector<LibusbLibrary::Listed> LibusbLibrary::list(std::uint16_t vendor) const {
  std::vector<Listed> found;
  const Context context = new_context();
  libusb_device** devices = nullptr;
  const ssize_t count = context ? libusb_get_device_list(context.get(), &devices) : 0;
  for (ssize_t i = 0; i < count; ++i) {
    if (identity_of(devices[i], nullptr).vendor != vendor) continue;
    libusb_device_handle* handle = nullptr;
    const int error = libusb_open(devices[i], &handle);
    found.push_back({identity_of(devices[i], handle), error == 0 ? "" : what_to_do(error)});
    if (handle != nullptr) libusb_close(handle);
  }
  if (devices != nullptr) libusb_free_device_list(devices, 1);
  return found;
}

std::unique_ptr<UsbLine> LibusbLibrary::open(const UsbIdentity& wanted, std::string& message) {
  const std::string name = "USB device " + hex_name(wanted.vendor, wanted.product) +
                           (wanted.serial.empty() ? "" : " " + wanted.serial);
  message = name + ": not plugged in";
  const Context context = new_context();
  libusb_device** devices = nullptr;
  const ssize_t count = context ? libusb_get_device_list(context.get(), &devices) : 0;
  std::unique_ptr<UsbLine> line;
  for (ssize_t i = 0; i < count && !line; ++i) {
    const UsbIdentity bare = identity_of(devices[i], nullptr);
    if (bare.vendor != wanted.vendor || bare.product != wanted.product) continue;
    libusb_device_handle* handle = nullptr;
    if (const int error = libusb_open(devices[i], &handle); error != 0) {
      message = name + ": " + what_to_do(error);
      continue;
    }
    UsbIdentity id = identity_of(devices[i], handle);
    if (!wanted.serial.empty() && id.serial != wanted.serial) {
      libusb_close(handle);
      continue;
    }
    // the tty driver gives the chip up while we have it, and gets it back at the end
    libusb_set_auto_detach_kernel_driver(handle, 1);
    if (const int error = libusb_claim_interface(handle, kInterface); error != 0) {
      message = name + ": " + what_to_do(error);
      libusb_close(handle);
      continue;
    }
    line = std::make_unique<LibusbLine>(context, handle, std::move(id));
    message.clear();
  }
  if (devices != nullptr) libusb_free_device_list(devices, 1);
  return line;
}

}  // namespace sanso::board
