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
// controller keeps several sessions: one counts from its first message on, so a replayed hello ends
// nothing, and answered handshakes that wait for that message have places of their own, so that it
// starves nobody. Counters never repeat within a session; a window of 1024 lets datagrams overtake
// one another and drops every second copy.
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

/// Datagrams dropped, by reason.
struct DropCounts {
  std::uint32_t malformed = 0;  // too short, too long, no such type
  std::uint32_t version = 0;    // of another protocol version
  std::uint32_t forged = 0;     // does not open: another key, damaged, of a session that is over
  std::uint32_t replayed = 0;   // seen before, or an answer to nothing
  std::uint32_t total() const { return malformed + version + forged + replayed; }
};

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
    int session = 0;                // in which it opened
  };
  static constexpr int kMaxSessions = 4;  // controller: that count
  static constexpr int kMaxPending = 16;  // controller: answered, not yet proved live
  /// Opens one datagram. `message` and `reply` need kMaxDatagram bytes.
  Opened open(std::span<const std::uint8_t> datagram, std::span<std::uint8_t> message,
              std::span<std::uint8_t> reply);

  /// Seals an encoded message (version and type first) for the newest session, or for the one that
  /// is named. not_ready before it exists, full when it does not fit.
  Result<std::size_t> seal(std::span<const std::uint8_t> message,
                           std::span<std::uint8_t> datagram) {
    return seal(message, datagram, newest_);
  }
  Result<std::size_t> seal(std::span<const std::uint8_t> message, std::span<std::uint8_t> datagram,
                           int session);
  /// Controller: forgets a session, which makes room for another.
  void close(int session) { active_[static_cast<std::size_t>(session)] = Session{}; }
  /// Controller: the session that gives way when a new one needs its place; -1: none may.
  void offer(int session) { offered_ = session; }

  bool established() const { return active_[static_cast<std::size_t>(newest_)].valid; }
  /// Datagrams dropped since the start: forged, replayed, malformed or of another version.
  std::uint32_t dropped() const { return drops_.total(); }
  const DropCounts& drops() const { return drops_; }
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

  int free_session() const;
  Session& pending_for(const Nonce& host_nonce);
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
  Nonce own_nonce_{};                         // host: of the handshake under way
  bool awaiting_ = false;                     // host: hello sent, answer not yet here
  std::array<Session, kMaxSessions> active_;  // host: the first
  std::array<Session, kMaxPending> pending_;
  int next_pending_ = 0;  // the place that has waited longest
  int newest_ = 0, offered_ = -1;
  DropCounts drops_;
  std::uint32_t sessions_ = 0;
};

}  // namespace sanso::wire
