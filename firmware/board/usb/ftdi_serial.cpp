// One thread submits and ends all transfers; rings without locks carry the bytes, an event
// descriptor wakes the reader. Opening and closing happen only while nobody reads.
#include "firmware/board/usb/ftdi_serial.h"

#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

#include "firmware/board/linux_clock.h"
#include "firmware/board/realtime.h"
#include "firmware/board/usb/ftdi_chip.h"

namespace sanso::board {
namespace {

constexpr std::uint16_t kLatency_ms = 1;
constexpr int kWait_ms = 100;
constexpr int kMaxStalls = 8;  // one after another: the device is not coming round

}  // namespace

// --- ring ----------------------------------------------------------------------------------------

std::size_t ByteRing::push(Bytes data) {
  const std::size_t head = head_.load(std::memory_order_relaxed);
  const std::size_t room = kCapacity - (head - tail_.load(std::memory_order_acquire));
  const std::size_t n = std::min(room, data.size());
  for (std::size_t i = 0; i < n; ++i) bytes_[(head + i) % kCapacity] = data[i];
  head_.store(head + n, std::memory_order_release);
  return n;
}

std::size_t ByteRing::pop(Buffer out) {
  const std::size_t tail = tail_.load(std::memory_order_relaxed);
  const std::size_t n = std::min(head_.load(std::memory_order_acquire) - tail, out.size());
  for (std::size_t i = 0; i < n; ++i) out[i] = bytes_[(tail + i) % kCapacity];
  tail_.store(tail + n, std::memory_order_release);
  return n;
}

// --- opening and closing (helper thread) ---------------------------------------------------------

FtdiSerial::FtdiSerial(UsbLibrary& library, UsbIdentity wanted, int baud, int priority)
    : library_(library),
      wanted_(std::move(wanted)),
      baud_(baud),
      priority_(priority),
      event_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {}

FtdiSerial::~FtdiSerial() {
  close();
  if (event_ >= 0) ::close(event_);
}

void FtdiSerial::close() {
  stop_ = true;
  if (line_) line_->wake();
  if (thread_.joinable()) thread_.join();
  line_.reset();
  gone_ = true;
}

Status FtdiSerial::open(std::string& message) {
  close();
  line_ = library_.open(wanted_, message);
  if (!line_) return Status::io_error;
  if (!configure(message)) {
    line_.reset();
    return Status::io_error;
  }
  std::array<std::uint8_t, 256> old;
  while (in_.pop(old) > 0 || out_.pop(old) > 0) {
  }
  to_write_ = written_ = 0;
  write_busy_ = false;
  failures_in_a_row_ = 0;
  stop_ = false;
  gone_ = false;
  thread_ = std::thread([this] { run(); });
  return Status::ok;
}

bool FtdiSerial::configure(std::string& message) {
  using ftdi::Request;
  const std::string name = "FTDI device " + line_->identity().serial;
  const auto ask = [&](Request request, std::uint16_t value, std::uint16_t index = 0) {
    return line_->control_out(static_cast<std::uint8_t>(request), value, index) == Status::ok;
  };
  const Result<ftdi::Divisor> divisor = ftdi::divisor_for(baud_, line_->identity().release);
  if (!divisor.ok()) {
    message = name + ": cannot make " + std::to_string(baud_) + " baud";
    return false;
  }
  const bool set = ask(Request::reset, ftdi::kResetAll) &&
                   ask(Request::set_baud, divisor->value, divisor->index) &&
                   ask(Request::set_data, ftdi::kData8N1) && ask(Request::set_flow, 0) &&
                   ask(Request::set_latency, kLatency_ms) &&
                   ask(Request::reset, ftdi::kPurgeInput) &&
                   ask(Request::reset, ftdi::kPurgeOutput);
  if (!set) {
    message = name + ": refuses its settings";
    return false;
  }
  std::array<std::uint8_t, 1> latency{};
  const Result<std::size_t> n =
      line_->control_in(static_cast<std::uint8_t>(Request::get_latency), 0, 0, latency);
  if (n.ok() && *n == 1 && latency[0] == kLatency_ms) return true;
  message = name + ": latency timer is " + (n.ok() ? std::to_string(latency[0]) : "unknown") +
            " ms, expected 1; replies would come too late for a tick of 10 ms";
  return false;
}

// --- transfers (transfer thread) -----------------------------------------------------------------

void FtdiSerial::tell_reader() const {
  const std::uint64_t one = 1;
  (void)!::write(event_, &one, sizeof one);
}

bool FtdiSerial::start_reads() {
  for (int slot = 0; slot < UsbLine::kReads; ++slot)
    if (line_->submit_read(slot, buffers_[static_cast<std::size_t>(slot)]) != Status::ok)
      return false;
  return true;
}

void FtdiSerial::run() {
  if (priority_ > 0) (void)set_realtime_priority(priority_);
  bool good = start_reads();
  while (good && !stop_) good = send() && take(line_->wait(kWait_ms));
  if (!good) gone_ = true;
  tell_reader();
}

bool FtdiSerial::send() {
  if (write_busy_) return true;
  if (written_ == to_write_) {
    written_ = 0;
    to_write_ = out_.pop(writing_);
  }
  if (to_write_ == 0) return true;
  write_busy_ = true;
  return line_->submit_write(Bytes(writing_).subspan(written_, to_write_ - written_)) == Status::ok;
}

bool FtdiSerial::take(const UsbEvent& event) {
  if (event.kind == UsbEvent::Kind::none) return true;
  if (event.outcome == UsbEvent::Outcome::gone) return false;
  if (event.outcome == UsbEvent::Outcome::stalled) {
    ++counters_.stalls;
    if (++failures_in_a_row_ > kMaxStalls) return false;
    if (line_->clear_stall(event.kind) != Status::ok) return false;
  } else {
    failures_in_a_row_ = 0;
  }
  if (event.kind == UsbEvent::Kind::read) return take_read(event);
  write_busy_ = false;
  written_ = std::min(to_write_, written_ + event.bytes);  // a short write goes on where it ended
  return true;
}

bool FtdiSerial::take_read(const UsbEvent& event) {
  auto& buffer = buffers_[static_cast<std::size_t>(event.slot)];
  std::uint32_t errors = 0;
  const std::size_t n = ftdi::strip_status(
      Buffer(buffer).first(std::min(event.bytes, buffer.size())), line_->packet_bytes(), errors);
  counters_.line_errors += errors;
  if (n > 0) {
    const std::size_t kept = in_.push(Bytes(buffer).first(n));
    counters_.dropped += static_cast<std::uint32_t>(n - kept);
    tell_reader();
  }
  return line_->submit_read(event.slot, buffer) == Status::ok;
}

// --- the tick's thread ---------------------------------------------------------------------------

Status FtdiSerial::write(Bytes data) {
  if (gone_) return Status::io_error;
  const std::size_t n = out_.push(data);
  line_->wake();
  return n == data.size() ? Status::ok : Status::full;
}

Result<std::size_t> FtdiSerial::read(Buffer buffer, Nanoseconds deadline) {
  for (;;) {
    const bool gone = gone_;  // before the ring: what came before the end is still delivered
    if (const std::size_t n = in_.pop(buffer); n > 0) return n;
    if (gone) return Status::io_error;
    if (wait_readable(event_, deadline) <= 0) return std::size_t{0};
    std::uint64_t count = 0;
    (void)!::read(event_, &count, sizeof count);
  }
}

}  // namespace sanso::board
