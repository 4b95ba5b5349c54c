// Authenticated, encrypted datagrams between host and controller, from one pre-shared key
// (libsodium).
//
// Hello      [version | type 1 | role | nonce 24 | XChaCha20-Poly1305 of {own nonce 32, echoed
// nonce 32}]
// Message    [version | type   | counter u64     | ChaCha20-Poly1305 of the message behind version
// and type]
//
// The host's hello carries a nonce fresh for every handshake; the controller answers with a fresh
// nonce of its own and echoes the host's. Both derive one key per direction from the pre-shared key
// and both nonces, so a recorded datagram opens in no other session, nor back at its sender. The
// controller keeps the session in use until the first message of the new one has opened: a replayed
// hello cannot end a running session. Counters never repeat within a session; a window of 1024 lets
// datagrams overtake one another and drops every second copy.
// Not in the real-time library: the link thread opens and seals.
#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <span>

#include "shared/base/status.h"
#include "shared/wire/messages.h"

namespace sanso::wire {

inline constexpr std::size_t kKeyBytes = 32;
using Key = std::array<std::uint8_t, kKeyBytes>;

/// A pre-shared key from 64 hexadecimal digits (white space at the end is ignored).
Result<Key> key_from_hex(std::span<const char> text);
/// A new random pre-shared key.
Key random_key();

enum class Role : std::uint8_t { host = 1, controller = 2 };

/// Which counters have been seen: everything older than the window counts as seen.
class ReplayWindow {
 public:
  static constexpr std::uint64_t kSize = 1024;
  bool seen(std::uint64_t counter) const;
  void mark(std::uint64_t counter);

 private:
  std::uint64_t newest_ = 0;  // counters start at 1
  std::bitset<kSize> seen_;   // bit i: counter with (counter % kSize) == i, within the window
};

class SecureChannel {
 public:
  static constexpr std::size_t kMessageOverhead = 8 + 16;  // counter and tag
  static constexpr std::size_t kHelloBytes = 3 + 24 + 64 + 16;

  SecureChannel(Role role, const Key& preshared);
  ~SecureChannel();  // wipes the keys
  SecureChannel(const SecureChannel&) = delete;
  SecureChannel& operator=(const SecureChannel&) = delete;

  /// Host: the hello to send, again and again until established(). `fresh` starts a new handshake
  /// (new nonce) and forgets the session in use. Returns the number of bytes.
  Result<std::size_t> make_hello(std::span<std::uint8_t> datagram, bool fresh);

  struct Opened {
    // ok: a message; empty: a good hello, nothing to read; else dropped and counted
    Status status = Status::empty;
    std::size_t message_bytes = 0;  // in `message`: version, type, body
    std::size_t reply_bytes = 0;    // in `reply`: to be sent to where the datagram came from
  };
  /// Opens one datagram. `message` and `reply` need kMaxDatagram bytes.
  Opened open(std::span<const std::uint8_t> datagram, std::span<std::uint8_t> message,
              std::span<std::uint8_t> reply);

  /// Seals an encoded message (version and type first). not_ready before a session, full when it
  /// does not fit.
  Result<std::size_t> seal(std::span<const std::uint8_t> message, std::span<std::uint8_t> datagram);

  bool established() const { return active_.valid; }
  /// Datagrams dropped since the start: forged, replayed, malformed or of another version.
  std::uint32_t dropped() const { return dropped_; }
  /// Sessions opened since the start; a change tells the application that the other side is new.
  std::uint32_t sessions() const { return sessions_; }

 private:
  using Nonce = std::array<std::uint8_t, 32>;
  struct Session {
    bool valid = false;
    Nonce host_nonce{}, controller_nonce{};
    Key send_key{}, receive_key{};
    std::uint64_t sent = 0;
    ReplayWindow window;
  };

  Opened open_hello(std::span<const std::uint8_t> datagram, std::span<std::uint8_t> reply);
  Opened open_message(std::span<const std::uint8_t> datagram, std::span<std::uint8_t> message);
  Status try_open(Session& session, std::span<const std::uint8_t> datagram,
                  std::span<std::uint8_t> message) const;
  std::size_t write_hello(std::span<std::uint8_t> datagram, const Nonce& own,
                          const Nonce& echoed) const;
  Session derive(const Nonce& host_nonce, const Nonce& controller_nonce) const;
  Opened drop(Status why);

  Role role_;
  Key preshared_;
  Nonce own_nonce_{};      // host: of the handshake under way
  bool awaiting_ = false;  // host: hello sent, answer not yet here
  Session active_;
  Session pending_;  // controller: answered, not yet proved live
  std::uint32_t dropped_ = 0;
  std::uint32_t sessions_ = 0;
};

}  // namespace sanso::wire
