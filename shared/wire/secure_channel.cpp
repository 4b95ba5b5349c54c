// Handshake and message counters around libsodium: a datagram counts when it opens under the
// session key and is newer than the last one.
#include "shared/wire/secure_channel.h"

#include <sodium.h>

#include <algorithm>
#include <cassert>
#include <cstring>

namespace sanso::wire {
namespace {

constexpr std::size_t kTag = crypto_aead_chacha20poly1305_ietf_ABYTES;
constexpr std::size_t kHeader = 2 + 8;  // version, type, counter
static_assert(kKeyBytes == crypto_aead_chacha20poly1305_ietf_KEYBYTES);
static_assert(crypto_aead_xchacha20poly1305_ietf_NPUBBYTES == 24 && kTag == 16);

void require_sodium() {
  // idempotent, picks the fastest code for this processor
  [[maybe_unused]] static const int ready = sodium_init();
  assert(ready >= 0);
}

void put_counter(std::uint8_t* out, std::uint64_t value) {
  for (int i = 0; i < 8; ++i) out[i] = static_cast<std::uint8_t>(value >> (8 * i));
}
std::uint64_t get_counter(const std::uint8_t* in) {
  std::uint64_t value = 0;
  for (int i = 7; i >= 0; --i) value = (value << 8) | in[i];
  return value;
}

using AeadNonce = std::array<std::uint8_t, crypto_aead_chacha20poly1305_ietf_NPUBBYTES>;
AeadNonce nonce_of(std::uint64_t counter) {
  AeadNonce nonce{};  // keys differ by session and direction, so the counter alone makes it unique
  put_counter(nonce.data() + 4, counter);
  return nonce;
}

/// BLAKE2b keyed with the pre-shared key over a label and the parts: one key for one purpose.
template <class... Parts>
Key derive_key(const Key& preshared, const char* label, const Parts&... parts) {
  Key key{};
  crypto_generichash_state state;
  crypto_generichash_init(&state, preshared.data(), preshared.size(), key.size());
  crypto_generichash_update(&state, reinterpret_cast<const unsigned char*>(label),
                            std::strlen(label));
  (crypto_generichash_update(&state, parts.data(), parts.size()), ...);
  crypto_generichash_final(&state, key.data(), key.size());
  return key;
}

Key hello_key(const Key& preshared, Role sender) {
  return derive_key(preshared,
                    sender == Role::host ? "sanso hello host" : "sanso hello controller");
}

}  // namespace

Result<Key> key_from_hex(std::span<const char> text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r' || text.back() == ' '))
    text = text.first(text.size() - 1);
  Key key{};
  std::size_t written = 0;
  const char* end = nullptr;
  if (text.size() != 2 * kKeyBytes ||
      sodium_hex2bin(key.data(), key.size(), text.data(), text.size(), nullptr, &written, &end) !=
          0 ||
      written != kKeyBytes || end != text.data() + text.size())
    return Status::malformed;
  return key;
}

Key random_key() {
  require_sodium();
  Key key{};
  randombytes_buf(key.data(), key.size());
  return key;
}

// --- replay window -------------------------------------------------------------------------------

bool ReplayWindow::seen(std::uint64_t counter) const {
  if (counter == 0) return true;
  if (counter > newest_) return false;
  if (newest_ - counter >= kSize) return true;
  return seen_[counter % kSize];
}

void ReplayWindow::mark(std::uint64_t counter) {
  if (counter > newest_) {
    if (counter - newest_ >= kSize)
      seen_.reset();
    else
      for (std::uint64_t c = newest_ + 1; c < counter; ++c) seen_[c % kSize] = false;
    newest_ = counter;
  }
  seen_[counter % kSize] = true;
}

// --- handshake -----------------------------------------------------------------------------------

SecureChannel::SecureChannel(Role role, const Key& preshared) : role_(role), preshared_(preshared) {
  require_sodium();
}

SecureChannel::~SecureChannel() {
  sodium_memzero(preshared_.data(), preshared_.size());
  const auto wipe = [](Session& session) {
    sodium_memzero(session.send_key.data(), session.send_key.size());
    sodium_memzero(session.receive_key.data(), session.receive_key.size());
  };
  for (Session& session : active_) wipe(session);
  for (Session& session : pending_) wipe(session);
}

SecureChannel::Session SecureChannel::derive(const Nonce& host_nonce,
                                             const Nonce& controller_nonce) const {
  Session session;
  session.valid = true;
  session.host_nonce = host_nonce;
  session.controller_nonce = controller_nonce;
  const Key down = derive_key(preshared_, "sanso host to controller", host_nonce, controller_nonce);
  const Key up = derive_key(preshared_, "sanso controller to host", host_nonce, controller_nonce);
  session.send_key = role_ == Role::host ? down : up;
  session.receive_key = role_ == Role::host ? up : down;
  return session;
}

std::size_t SecureChannel::write_hello(std::span<std::uint8_t> datagram, const Nonce& own,
                                       const Nonce& echoed) const {
  std::uint8_t* out = datagram.data();
  out[0] = kProtocolVersion;
  out[1] = static_cast<std::uint8_t>(MessageType::hello);
  out[2] = static_cast<std::uint8_t>(role_);
  randombytes_buf(out + 3, 24);
  std::array<std::uint8_t, 64> plain{};
  std::copy(own.begin(), own.end(), plain.begin());
  std::copy(echoed.begin(), echoed.end(), plain.begin() + 32);
  const Key key = hello_key(preshared_, role_);
  crypto_aead_xchacha20poly1305_ietf_encrypt(out + 27, nullptr, plain.data(), plain.size(), out, 3,
                                             nullptr, out + 3, key.data());
  return kHelloBytes;
}

Result<std::size_t> SecureChannel::make_hello(std::span<std::uint8_t> datagram, bool fresh) {
  if (role_ != Role::host) return Status::unsupported;
  if (datagram.size() < kHelloBytes) return Status::full;
  if (fresh || !awaiting_) {
    randombytes_buf(own_nonce_.data(), own_nonce_.size());
    active_[0] = Session{};
    awaiting_ = true;
  }
  return write_hello(datagram, own_nonce_, Nonce{});
}

SecureChannel::Opened SecureChannel::drop(Status why) {
  switch (why) {
    case Status::unsupported:
      ++drops_.version;
      break;
    case Status::rejected:
      ++drops_.forged;
      break;
    case Status::stale:
      ++drops_.replayed;
      break;
    default:
      ++drops_.malformed;
  }
  return {.status = why};
}

SecureChannel::Opened SecureChannel::open_hello(std::span<const std::uint8_t> datagram,
                                                std::span<std::uint8_t> reply) {
  const Role sender = role_ == Role::host ? Role::controller : Role::host;
  if (datagram.size() != kHelloBytes || datagram[2] != static_cast<std::uint8_t>(sender))
    return drop(Status::malformed);
  std::array<std::uint8_t, 64> plain{};
  const Key key = hello_key(preshared_, sender);
  if (crypto_aead_xchacha20poly1305_ietf_decrypt(
          plain.data(), nullptr, nullptr, datagram.data() + 27, datagram.size() - 27,
          datagram.data(), 3, datagram.data() + 3, key.data()) != 0)
    return drop(Status::rejected);
  Nonce theirs{}, echoed{};
  std::copy_n(plain.begin(), 32, theirs.begin());
  std::copy_n(plain.begin() + 32, 32, echoed.begin());

  if (role_ == Role::host) {
    if (!awaiting_ || echoed != own_nonce_) return drop(Status::stale);
    active_[0] = derive(own_nonce_, theirs);
    awaiting_ = false;
    ++sessions_;
    return {};
  }

  // Controller: the same hello again gets the same answer; a new one gets a session that has to
  // prove itself first.
  if (reply.size() < kHelloBytes) return drop(Status::full);
  for (const Session& session : active_)
    if (session.valid && session.host_nonce == theirs)
      return {.reply_bytes = write_hello(reply, session.controller_nonce, theirs)};
  return {.reply_bytes = write_hello(reply, pending_for(theirs).controller_nonce, theirs)};
}

/// The handshake with this nonce: the one under way, or a new one in the oldest place.
SecureChannel::Session& SecureChannel::pending_for(const Nonce& host_nonce) {
  for (Session& session : pending_)
    if (session.valid && session.host_nonce == host_nonce) return session;
  Nonce fresh{};
  randombytes_buf(fresh.data(), fresh.size());
  Session& place = pending_[static_cast<std::size_t>(next_pending_)];
  next_pending_ = (next_pending_ + 1) % kMaxPending;
  place = derive(host_nonce, fresh);
  return place;
}

int SecureChannel::free_session() const {
  for (int i = 0; i < kMaxSessions; ++i)
    if (!active_[static_cast<std::size_t>(i)].valid) return i;
  return offered_;
}

// --- messages ------------------------------------------------------------------------------------

Status SecureChannel::try_open(Session& session, std::span<const std::uint8_t> datagram,
                               std::span<std::uint8_t> message) const {
  if (!session.valid) return Status::not_ready;
  const std::uint64_t counter = get_counter(datagram.data() + 2);
  const AeadNonce nonce = nonce_of(counter);
  if (crypto_aead_chacha20poly1305_ietf_decrypt(message.data() + 2, nullptr, nullptr,
                                                datagram.data() + kHeader,
                                                datagram.size() - kHeader, datagram.data(), kHeader,
                                                nonce.data(), session.receive_key.data()) != 0)
    return Status::rejected;
  if (session.window.seen(counter)) return Status::stale;
  session.window.mark(counter);
  return Status::ok;
}

SecureChannel::Opened SecureChannel::open_message(std::span<const std::uint8_t> datagram,
                                                  std::span<std::uint8_t> message) {
  if (datagram.size() < kHeader + kTag) return drop(Status::malformed);
  const std::size_t plain_bytes = datagram.size() - kHeader - kTag + 2;
  if (message.size() < plain_bytes) return drop(Status::full);
  Status status = Status::rejected;
  int in = -1;
  for (int i = 0; i < kMaxSessions && in < 0 && status != Status::stale; ++i) {
    Session& session = active_[static_cast<std::size_t>(i)];
    if (!session.valid) continue;
    status = try_open(session, datagram, message);
    if (status == Status::ok) in = i;
  }
  for (std::size_t i = 0; i < pending_.size() && in < 0 && status != Status::stale; ++i) {
    if (!pending_[i].valid) continue;
    status = try_open(pending_[i], datagram, message);
    if (status != Status::ok) continue;
    // the host holds the new keys: it is alive
    in = free_session();
    if (in < 0) return drop(Status::rejected);
    active_[static_cast<std::size_t>(in)] = pending_[i];
    pending_[i] = Session{};
    newest_ = in;
    ++sessions_;
  }
  if (in < 0) return drop(status);
  message[0] = datagram[0];
  message[1] = datagram[1];
  return {.status = Status::ok, .message_bytes = plain_bytes, .session = in};
}

SecureChannel::Opened SecureChannel::open(std::span<const std::uint8_t> datagram,
                                          std::span<std::uint8_t> message,
                                          std::span<std::uint8_t> reply) {
  if (datagram.size() < 3 || datagram.size() > kMaxDatagram) return drop(Status::malformed);
  if (datagram[0] != kProtocolVersion) return drop(Status::unsupported);
  if (datagram[1] == static_cast<std::uint8_t>(MessageType::hello))
    return open_hello(datagram, reply);
  return open_message(datagram, message);
}

Result<std::size_t> SecureChannel::seal(std::span<const std::uint8_t> message,
                                        std::span<std::uint8_t> datagram, int session) {
  Session& active = active_[static_cast<std::size_t>(session)];
  if (!active.valid) return Status::not_ready;
  if (message.size() < 2) return Status::malformed;
  const std::size_t total = message.size() + kMessageOverhead;
  if (total > datagram.size() || total > kMaxDatagram) return Status::full;
  datagram[0] = message[0];
  datagram[1] = message[1];
  put_counter(datagram.data() + 2, ++active.sent);
  const AeadNonce nonce = nonce_of(active.sent);
  crypto_aead_chacha20poly1305_ietf_encrypt(datagram.data() + kHeader, nullptr, message.data() + 2,
                                            message.size() - 2, datagram.data(), kHeader, nullptr,
                                            nonce.data(), active.send_key.data());
  return total;
}

}  // namespace sanso::wire
