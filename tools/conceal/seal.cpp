// Salt and nonce are hashes of the answer, so the same answer gives the same bytes; a changed
// byte does not open.
#include "tools/conceal/seal.h"

#include <sodium.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "tools/plant/world_error.h"

namespace sanso::conceal {
namespace {

// file: magic | salt | nonce | ciphertext with its tag
constexpr char kMagic[] = "SANSOSEAL1";
constexpr std::size_t kMagicBytes = sizeof kMagic - 1;
constexpr std::size_t kSaltBytes = 16;
constexpr std::size_t kHeadBytes = kMagicBytes + kSaltBytes + crypto_secretbox_NONCEBYTES;
constexpr char kPurpose[] = "sanso: the key that opens a concealed case for reveal";

using Key = std::array<std::uint8_t, crypto_secretbox_KEYBYTES>;

void require_sodium() {
  if (sodium_init() < 0) throw plant::WorldError("libsodium cannot be initialised");
}

Key derive_key(std::span<const std::uint8_t> salt) {
  Key key{};
  crypto_generichash(key.data(), key.size(), salt.data(), salt.size(),
                     reinterpret_cast<const unsigned char*>(kPurpose),
                     std::min<std::size_t>(sizeof kPurpose - 1, crypto_generichash_KEYBYTES_MAX));
  return key;
}

}  // namespace

std::vector<std::uint8_t> make_seal(const std::string& answer) {
  require_sodium();
  const auto* text = reinterpret_cast<const unsigned char*>(answer.data());
  std::vector<std::uint8_t> out(kHeadBytes + crypto_secretbox_MACBYTES + answer.size());
  std::copy_n(kMagic, kMagicBytes, out.begin());
  // salt and nonce come from the answer itself: the same case gives the same bytes, and its hash
  // can be checked again
  crypto_generichash(out.data() + kMagicBytes, kSaltBytes, text, answer.size(), nullptr, 0);
  crypto_generichash(out.data() + kMagicBytes + kSaltBytes, crypto_secretbox_NONCEBYTES, text,
                     answer.size(), nullptr, 0);
  const Key key = derive_key({out.data() + kMagicBytes, kSaltBytes});
  crypto_secretbox_easy(out.data() + kHeadBytes, text, answer.size(),
                        out.data() + kMagicBytes + kSaltBytes, key.data());
  return out;
}

std::string open_seal(std::span<const std::uint8_t> sealed) {
  require_sodium();
  if (sealed.size() < kHeadBytes + crypto_secretbox_MACBYTES ||
      std::memcmp(sealed.data(), kMagic, kMagicBytes) != 0) {
    throw plant::WorldError("answer.sealed: this is no sealed answer");
  }
  const Key key = derive_key(sealed.subspan(kMagicBytes, kSaltBytes));
  const auto body = sealed.subspan(kHeadBytes);
  std::string answer(body.size() - crypto_secretbox_MACBYTES, '\0');
  if (crypto_secretbox_open_easy(reinterpret_cast<unsigned char*>(answer.data()), body.data(),
                                 body.size(), sealed.data() + kMagicBytes + kSaltBytes,
                                 key.data()) != 0) {
    throw plant::WorldError("answer.sealed: the bytes were changed after the case was made");
  }
  return answer;
}

std::string seal_hash(std::span<const std::uint8_t> sealed) {
  require_sodium();
  std::array<std::uint8_t, 32> hash{};
  crypto_generichash(hash.data(), hash.size(), sealed.data(), sealed.size(), nullptr, 0);
  std::string text(2 * hash.size() + 1, '\0');
  sodium_bin2hex(text.data(), text.size(), hash.data(), hash.size());
  text.pop_back();
  return text;
}

}  // namespace sanso::conceal
