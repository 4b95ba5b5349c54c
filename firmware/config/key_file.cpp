// One open, the mode of exactly what was opened, then the digits.
#include "firmware/config/key_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>

namespace sanso::firmware {
namespace {

constexpr const char* kRecipe = "; make one with: (umask 077; openssl rand -hex 32 > FILE)";

std::string octal(mode_t mode) {
  std::array<char, 8> text{};
  std::snprintf(text.data(), text.size(), "%04o", static_cast<unsigned>(mode & 07777));
  return text.data();
}

/// What is wrong with the open file; empty: nothing, and `key` is filled.
std::string read_open_key(int file, wire::Key& key) {
  struct stat status {};
  if (::fstat(file, &status) != 0) return std::strerror(errno);
  if ((status.st_mode & 077) != 0)
    return "mode " + octal(status.st_mode) +
           ": others may read the key of the robot; expected 0600 (chmod 600), and a new key if "
           "anyone could have read this one";
  std::array<char, 256> text{};
  const ssize_t n = ::read(file, text.data(), text.size());
  const auto digits = std::span(text).first(n > 0 ? static_cast<std::size_t>(n) : 0);
  const Result<wire::Key> read = wire::key_from_hex(digits);
  if (!read.ok()) return std::string("expected 64 hexadecimal digits") + kRecipe;
  key = *read;
  if (std::ranges::all_of(key, [](std::uint8_t byte) { return byte == 0; }))
    return std::string("a key of zeros protects nothing") + kRecipe;
  return {};
}

}  // namespace

bool read_key_file(const std::string& path, wire::Key& key, std::string& error) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  std::string wrong = file < 0 ? std::strerror(errno) + std::string(kRecipe) : "";
  if (file >= 0) {
    wrong = read_open_key(file, key);
    ::close(file);
  }
  error = wrong.empty() ? "" : "device.key_file = '" + path + "': " + wrong;
  return wrong.empty();
}

}  // namespace sanso::firmware
