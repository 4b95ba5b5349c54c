// Plugs a USB function into the running kernel: its virtual host controller vhci_hcd takes one end
// of a socket pair, on which the USB/IP protocol is spoken. No network, no usbip tools; needs the
// module and root. Source: Linux Documentation/usb/usbip_protocol.rst.
#pragma once

#include <deque>

#include "tools/emulator/sockets.h"
#include "tools/emulator/usb/usb_function.h"

namespace sanso::emulator {

class UsbipPlug {
 public:
  /// `function` outlives the plug.
  explicit UsbipPlug(UsbFunction& function) : function_(function) {}

  /// Throws plant::WorldError when this kernel has no virtual host controller that is free.
  void plug();
  /// As if the cable were pulled out.
  void unplug();
  /// For poll(); -1 while unplugged.
  int fd() const { return line_.get(); }

  /// Answers what the kernel has asked for and what can be answered by now. Never blocks.
  void serve(Nanoseconds now);
  /// When serve() may have something to do without being asked.
  Nanoseconds next() const;

  /// The protocol, for tests: what the kernel sends to `socket` is answered there.
  void serve_on(FileDescriptor socket) { line_ = std::move(socket); }

 private:
  struct Request;
  bool read_request();
  bool handle(const Request& request, std::span<const std::uint8_t> data);
  bool submit(const Request& request, std::span<const std::uint8_t> data);
  bool unlink(const Request& request);
  void answer_waiting(Nanoseconds now);
  bool reply(std::uint32_t sequence, std::int32_t status, std::span<const std::uint8_t> data,
             std::size_t actual);
  bool send(const UsbBytes& message);

  struct Waiting {
    std::uint32_t sequence;
    std::size_t capacity;
  };
  UsbFunction& function_;
  FileDescriptor line_;
  UsbBytes received_;
  std::deque<Waiting> waiting_;  // transfers that the host has asked for
};

}  // namespace sanso::emulator
