// The corpus of the fuzzers as an ordinary test: every file, and damaged copies of it, go through
// their target, which aborts when a law is broken.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include "tests/fuzz/seeds/seeds.h"

extern "C" {
int fuzz_servo_bus(const std::uint8_t* bytes, std::size_t size);
int fuzz_wire_codec(const std::uint8_t* bytes, std::size_t size);
int fuzz_secure_channel(const std::uint8_t* bytes, std::size_t size);
int fuzz_policy_bytes(const std::uint8_t* bytes, std::size_t size);
int fuzz_hid_descriptor(const std::uint8_t* bytes, std::size_t size);
int fuzz_program_config(const std::uint8_t* bytes, std::size_t size);
int fuzz_behind_seal(const std::uint8_t* bytes, std::size_t size);
}

namespace sanso::fuzz {
namespace {

struct Target {
  const char* name;
  int (*run)(const std::uint8_t*, std::size_t);
};
constexpr Target kTargets[] = {
    {"fuzz_servo_bus", fuzz_servo_bus},           {"fuzz_wire_codec", fuzz_wire_codec},
    {"fuzz_secure_channel", fuzz_secure_channel}, {"fuzz_policy_bytes", fuzz_policy_bytes},
    {"fuzz_hid_descriptor", fuzz_hid_descriptor}, {"fuzz_program_config", fuzz_program_config},
    {"fuzz_behind_seal", fuzz_behind_seal}};
constexpr int kDamagedCopies = 12;

std::map<std::string, Bytes> files_of(const std::string& target) {
  std::map<std::string, Bytes> files;
  for (const auto& entry : std::filesystem::directory_iterator("tests/fuzz/corpus/" + target)) {
    std::ifstream file(entry.path(), std::ios::binary);
    files[entry.path().filename().string()] =
        Bytes(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }
  return files;
}

/// A few bits flipped, perhaps cut short.
Bytes damaged(Bytes bytes, std::mt19937_64& random) {
  for (std::uint64_t n = 1 + random() % 4; n > 0 && !bytes.empty(); --n)
    bytes[random() % bytes.size()] ^= static_cast<std::uint8_t>(1u << random() % 8);
  if (random() % 4 == 0) bytes.resize(random() % (bytes.size() + 1));
  return bytes;
}

class Corpus : public testing::TestWithParam<Target> {};

TEST_P(Corpus, EveryFileAndDamagedCopiesOfItKeepTheLaws) {
  const std::map<std::string, Bytes> files = files_of(GetParam().name);
  ASSERT_FALSE(files.empty());
  std::mt19937_64 random(1);
  for (const auto& [name, bytes] : files) {
    SCOPED_TRACE(name);
    EXPECT_EQ(GetParam().run(bytes.data(), bytes.size()), 0);
    for (int copy = 0; copy < kDamagedCopies; ++copy) {
      const Bytes other = damaged(bytes, random);
      EXPECT_EQ(GetParam().run(other.data(), other.size()), 0);
    }
  }
}

TEST_P(Corpus, HoldsWhatOurEncodersMakeNow) {
  const std::map<std::string, Bytes> files = files_of(GetParam().name);
  const auto all = seeds();
  for (const auto& [name, bytes] : all.at(GetParam().name)) {
    ASSERT_TRUE(files.contains(name)) << "sanso-fuzz-seeds tests/fuzz/corpus writes it";
    EXPECT_EQ(files.at(name), bytes) << name << ": sanso-fuzz-seeds tests/fuzz/corpus renews it";
  }
}

INSTANTIATE_TEST_SUITE_P(Targets, Corpus, testing::ValuesIn(kTargets),
                         [](const auto& p) { return std::string(p.param.name); });

}  // namespace
}  // namespace sanso::fuzz
