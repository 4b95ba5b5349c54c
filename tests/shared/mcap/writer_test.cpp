// The MCAP writer: its own bytes against the specification, and files cut at every byte.
#include "shared/mcap/writer.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "shared/base/crc32.h"
#include "shared/files/bytes.h"
#include "shared/files/input_error.h"
#include "shared/mcap/opcodes.h"
#include "shared/mcap/ros_messages.h"
#include "tools/recording/mcap_file.h"

namespace sanso::mcap {
namespace {

constexpr int kMessages = 40;

struct Written {
  std::string bytes;
  std::vector<std::size_t> chunk_ends;  // size of the file when so many chunks were complete
};

/// Two topics, a chunk every ten messages.
Written write_file() {
  Written file;
  Writer out([&](std::string_view bytes) { file.bytes += bytes; });
  out.add_metadata("test", {{"key", "value"}});
  const auto joints =
      out.add_channel("/joint_states", std::string(kJointStateType), joint_state_definition());
  const auto imu = out.add_channel("/imu", std::string(kImuType), imu_definition());
  for (int k = 0; k < kMessages; ++k) {
    const double t = 0.01 * k;
    const auto ns = static_cast<std::uint64_t>(k) * 10'000'000u;
    if (k % 2 == 0)
      out.write(joints, ns, encode(JointState{t, {"knee"}, {0.1 * k}, {}, {}}));
    else
      out.write(imu, ns, encode(Imu{t, {1, 0, 0, 0}, {1, 2, 3}, {0, 0, 9.81}}));
    if (k % 10 != 9) continue;
    out.close_chunk();
    file.chunk_ends.push_back(file.bytes.size());
  }
  out.finish();
  return file;
}

/// Records from `at` to the footer: opcode and place.
std::vector<std::pair<Opcode, std::size_t>> walk(const std::string& bytes, std::size_t at) {
  std::vector<std::pair<Opcode, std::size_t>> found;
  while (at + 9 <= bytes.size()) {
    files::ByteReader in(std::string_view(bytes).substr(at));
    const auto opcode = Opcode{in.number<std::uint8_t>()};
    found.emplace_back(opcode, at);
    at += 9 + in.number<std::uint64_t>();
    if (opcode == Opcode::footer) break;
  }
  return found;
}

class File : public testing::Test {
 protected:
  std::string path_ = (std::filesystem::temp_directory_path() /
                       ("sanso_writer_" + std::to_string(::getpid()) + ".mcap"))
                          .string();
  void TearDown() override { std::filesystem::remove(path_); }
  /// Messages that the reader delivers of these bytes, and whether it found the end.
  std::pair<int, bool> read(const std::string& bytes) {
    std::ofstream(path_, std::ios::binary) << bytes;
    return read();
  }
  std::pair<int, bool> read() {
    int messages = 0;
    const bool whole = recording::read_mcap_messages(
        path_, [&](const recording::McapChannel&, std::uint64_t time, std::string_view) {
          EXPECT_EQ(time, static_cast<std::uint64_t>(messages) * 10'000'000u);
          ++messages;
        });
    return {messages, whole};
  }
};

TEST_F(File, CutAtEveryByteAllCompleteChunksAreRead) {
  const Written file = write_file();
  ASSERT_EQ(read(file.bytes), std::pair(kMessages, true));
  for (std::size_t size = file.bytes.size() - 1; size >= kMagic.size(); --size) {
    std::filesystem::resize_file(path_, size);
    const auto [messages, whole] = read();
    int complete = 0;
    for (const std::size_t end : file.chunk_ends) complete += size >= end ? 1 : 0;
    // a chunk counts from its own last byte on; its index may still be missing
    EXPECT_GE(messages, 10 * complete) << size;
    EXPECT_LE(messages, 10 * (complete + 1)) << size;
    EXPECT_EQ(messages % 10, 0) << size;
    if (messages < kMessages) {
      EXPECT_FALSE(whole) << size;
    }
  }
}

TEST_F(File, ZerosWhereAPowerCutLeftThemEndTheFile) {
  const Written file = write_file();
  const std::string cut = file.bytes.substr(0, file.chunk_ends[1]) + std::string(4096, '\0');
  EXPECT_EQ(read(cut), std::pair(20, false));
}

TEST_F(File, AFlippedByteOfAChunkIsRefused) {
  std::string bytes = write_file().bytes;
  constexpr std::size_t kIntoPacked = 9 + 3 * 8 + 4 + 8 + 8 + 40;
  for (const auto& [opcode, at] : walk(bytes, kMagic.size()))
    if (opcode == Opcode::chunk) bytes[at + kIntoPacked] ^= 1;
  try {
    (void)read(bytes);
    FAIL();
  } catch (const files::InputError& e) {
    EXPECT_EQ(e.defect, "damaged chunk");
  }
}

std::uint32_t crc_of(std::string_view bytes) {
  return crc32({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
}

TEST(Layout, ChecksumsAndOffsetsPointWhereTheSpecificationSays) {
  const std::string bytes = write_file().bytes;
  const auto records = walk(bytes, kMagic.size());
  ASSERT_EQ(records.back().first, Opcode::footer);
  const std::size_t footer_at = records.back().second;
  EXPECT_EQ(bytes.substr(footer_at + 29), kMagic);
  files::ByteReader footer(std::string_view(bytes).substr(footer_at + 9, 20));
  const auto summary_at = footer.number<std::uint64_t>();
  const auto offsets_at = footer.number<std::uint64_t>();
  EXPECT_EQ(footer.number<std::uint32_t>(),
            crc_of(std::string_view(bytes).substr(summary_at, footer_at + 25 - summary_at)));
  EXPECT_EQ(walk(bytes, offsets_at).front().first, Opcode::summary_offset);
  for (std::size_t k = 0; k < records.size(); ++k) {
    const auto [opcode, at] = records[k];
    files::ByteReader in(std::string_view(bytes).substr(at + 9));
    if (opcode == Opcode::data_end) {
      EXPECT_EQ(in.number<std::uint32_t>(), crc_of(std::string_view(bytes).substr(0, at)));
      EXPECT_EQ(records[k + 1].second, summary_at);
    }
    if (opcode == Opcode::summary_offset) {
      const auto group = Opcode{in.number<std::uint8_t>()};
      EXPECT_EQ(walk(bytes, in.number<std::uint64_t>()).front().first, group);
    }
    if (opcode == Opcode::chunk_index) {
      in.number<std::uint64_t>(), in.number<std::uint64_t>();
      const auto chunk_at = in.number<std::uint64_t>();
      EXPECT_EQ(walk(bytes, chunk_at).front().first, Opcode::chunk);
      in.number<std::uint64_t>();
      files::ByteReader offsets(in.string());
      EXPECT_EQ(offsets.left(), 20u) << "both channels are in every chunk";
      offsets.number<std::uint16_t>();
      EXPECT_EQ(walk(bytes, offsets.number<std::uint64_t>()).front().first, Opcode::message_index);
    }
  }
}

}  // namespace
}  // namespace sanso::mcap
