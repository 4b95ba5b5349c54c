// Recordings as MCAP: exact both ways, plain and packed chunks, broken files refused by name.
#include <gtest/gtest.h>
#include <lz4frame.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "shared/files/bytes.h"
#include "shared/files/input_error.h"
#include "shared/mcap/ros_messages.h"
#include "tests/support/write_mcap.h"
#include "tools/recording/csv_writer.h"
#include "tools/recording/mcap_file.h"
#include "tools/recording/mcap_recording.h"

namespace sanso::recording {
namespace {

using namespace sanso::mcap;

class Mcap : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("sanso_mcap_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string path(const char* name) const { return (folder_ / name).string(); }
  void write(const char* name, const std::string& bytes) const {
    std::ofstream(path(name), std::ios::binary) << bytes;
  }
  std::filesystem::path folder_;
};

Recording servo_recording() {
  Recording r;
  for (int k = 0; k < 3000; ++k) r.t.push_back(0.005 * k);
  std::vector<double> q, u, pwm;
  for (double t : r.t) {
    q.push_back(std::sin(t));
    u.push_back(t > 10 ? NAN : std::sin(t + 0.1));
    pwm.push_back(0.1 * std::cos(t));
  }
  r.set("q:knee", q);
  r.set("dq:knee", std::vector<double>(3000, 0.25));
  r.set("u:knee", u);
  r.set("pwm:knee", pwm);
  r.set("volt", std::vector<double>(3000, 11.9));
  r.set("imu_acc:z", std::vector<double>(3000, 9.8));
  return r;
}

TEST_F(Mcap, WhatIsWrittenReadsBack) {
  const Recording r = servo_recording();
  write_mcap(r, path("a.mcap"));
  const Recording back = read_recording(path("a.mcap"));
  ASSERT_EQ(back.rows(), r.rows());
  for (std::size_t k = 0; k < r.rows(); ++k) EXPECT_NEAR(back.t[k], r.t[k], 1e-9);
  for (const Channel& c : r.channels) {
    const auto values = back.find(c.name);
    ASSERT_EQ(values.size(), c.values.size()) << c.name;
    for (std::size_t k = 0; k < values.size(); ++k) {
      if (std::isnan(c.values[k]))
        EXPECT_TRUE(std::isnan(values[k])) << c.name << " row " << k;
      else
        ASSERT_EQ(values[k], c.values[k]) << c.name << " row " << k;
    }
  }
}

/// One joint state at 1.5 s, as a record of the data section.
std::string records(std::string_view schema = kJointStateType, std::string_view encoding = "cdr") {
  const auto record = [](std::uint8_t opcode, const files::ByteWriter& content) {
    files::ByteWriter out;
    out.number(opcode);
    out.number(static_cast<std::uint64_t>(content.size()));
    out.raw(content.bytes());
    return out.bytes();
  };
  files::ByteWriter s, c, m;
  s.number(std::uint16_t{1}), s.string(schema), s.string("ros2msg"), s.string("");
  c.number(std::uint16_t{7}), c.number(std::uint16_t{1}), c.string("/joint_states"),
      c.string(encoding), c.number(std::uint32_t{0});
  m.number(std::uint16_t{7}), m.number(std::uint32_t{0}), m.number(std::uint64_t{5}),
      m.number(std::uint64_t{5});
  m.raw(encode(JointState{1.5, {"a", "elbow"}, {0.25, -1}, {}, {3, 4}}));
  return record(3, s) + record(4, c) + record(5, m);
}

std::string file_of(const std::string& data_section) {
  const std::string magic("\x89MCAP0\r\n", 8);
  files::ByteWriter out;
  out.raw(magic);
  out.number(std::uint8_t{1}), out.number(std::uint64_t{8}), out.number(std::uint32_t{0}),
      out.number(std::uint32_t{0});
  out.raw(data_section);
  out.number(std::uint8_t{15}), out.number(std::uint64_t{4}), out.number(std::uint32_t{0});
  return out.bytes();
}

std::string chunk_of(const std::string& packed, std::uint64_t size, std::string_view compression) {
  files::ByteWriter c;
  c.number(std::uint64_t{5}), c.number(std::uint64_t{5}), c.number(size),
      c.number(std::uint32_t{0});
  c.string(compression);
  c.number(static_cast<std::uint64_t>(packed.size()));
  c.raw(packed);
  files::ByteWriter out;
  out.number(std::uint8_t{6});
  out.number(static_cast<std::uint64_t>(c.size()));
  out.raw(c.bytes());
  return out.bytes();
}

TEST_F(Mcap, ReadsPlainAndPackedChunks) {
  const std::string plain = records();
  std::string packed(LZ4F_compressFrameBound(plain.size(), nullptr), '\0');
  packed.resize(
      LZ4F_compressFrame(packed.data(), packed.size(), plain.data(), plain.size(), nullptr));
  write("none.mcap", file_of(plain));
  write("chunk.mcap", file_of(chunk_of(plain, plain.size(), "")));
  write("lz4.mcap", file_of(chunk_of(packed, plain.size(), "lz4")));
  for (const char* name : {"none.mcap", "chunk.mcap", "lz4.mcap"}) {
    const Recording r = read_mcap(path(name));
    EXPECT_EQ(r.t, std::vector<double>{1.5}) << name;
    EXPECT_EQ(r.find("q:elbow")[0], -1) << name;
    EXPECT_EQ(r.find("tau:a")[0], 3) << name;
    EXPECT_FALSE(r.has("dq:a")) << name;
  }
}

TEST_F(Mcap, RefusesByName) {
  const std::string plain = records();
  struct Case {
    std::string bytes;
    const char* defect;
  };
  for (const Case& c :
       {Case{"t,q:a\n", "not an MCAP file"}, Case{file_of(plain).substr(0, 60), "no joint states"},
        Case{file_of(chunk_of(plain, plain.size(), "brotli")), "unknown compression"},
        Case{file_of(chunk_of(plain, plain.size(), "zstd")), "damaged chunk"},
        Case{file_of(chunk_of(plain, std::uint64_t{1} << 40, "")), "chunk too large"},
        Case{file_of(records("std_msgs/msg/String")), "no joint states"},
        Case{file_of(records(kJointStateType, "ros1")), "unknown message encoding"},
        Case{file_of(records(kImuType)), "damaged message"},
        Case{file_of(""), "no joint states"}}) {
    write("bad.mcap", c.bytes);
    try {
      read_mcap(path("bad.mcap"));
      FAIL() << c.defect;
    } catch (const files::InputError& e) {
      EXPECT_EQ(e.defect, c.defect);
    }
  }
}

TEST(Cdr, ImuKeepsItsOrderOfQuaternion) {
  const auto back = decode_imu(encode(Imu{2.25, {0.5, 0.1, 0.2, 0.3}, {1, 2, 3}, {4, 5, 6}}));
  ASSERT_TRUE(back.has_value());
  EXPECT_EQ(back->orientation, (std::array<double, 4>{0.5, 0.1, 0.2, 0.3}));
  EXPECT_EQ(back->linear_acceleration[2], 6);
  EXPECT_EQ(back->stamp_s, 2.25);
  EXPECT_EQ(encode(*back).size(), 4u + 8 + 8 + 37 * 8)
      << "stamp, empty frame with its zero and padding, 37 doubles";
}

}  // namespace
}  // namespace sanso::recording
