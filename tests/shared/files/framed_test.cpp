// Bytes with a name, a version and a checksum: the layout, the same bits back, every damage found.
#include "shared/files/framed.h"

#include <gmock/gmock.h>

#include <Eigen/Core>
#include <array>
#include <limits>

#include "shared/files/atomic_file.h"
#include "shared/files/input_error.h"
#include "tests/support/temp_folder.h"

namespace sanso::files {
namespace {

constexpr char kMagic[] = "SANSOTST";

struct Framed : testing::Test {
  test::TempFolder temporary;
  std::filesystem::path file = temporary.path() / "numbers.bin";
};

TEST(Bytes, AreLittleEndianWithLengthsAndAlignment) {
  ByteWriter out;
  out.number(std::uint16_t{0x0102});
  out.align(4);
  out.string("ab");
  EXPECT_EQ(out.bytes(), std::string("\x02\x01\0\0\x02\0\0\0ab", 10));
}

TEST(Bytes, CutAnywhereFailForGoodAndNeverReadBeyond) {
  ByteWriter out;
  out.number(1.5);
  out.string("abc");
  for (std::size_t size = 0; size < out.size(); ++size) {
    const std::string cut = out.bytes().substr(0, size);
    ByteReader in(cut);
    in.number<double>();
    in.string();
    EXPECT_FALSE(in.ok()) << size;
    EXPECT_TRUE(in.take(1).empty()) << "read on after an error, " << size;
  }
}

TEST_F(Framed, GivesBackTheSameBits) {
  const Eigen::Matrix<double, 2, 3, Eigen::RowMajor> rows =
      (Eigen::Matrix<double, 2, 3>() << 0.1, -0.0, 3, 1e-310, 5, 1.0 / 3).finished();
  const std::array<Eigen::Vector2f, 2> pair{Eigen::Vector2f(1, 2), Eigen::Vector2f(3, 4)};
  FramedWriter out;
  out.put(std::numeric_limits<double>::quiet_NaN());
  out.put(rows);
  out.put(pair);
  out.put(std::string("a\0b", 3));
  save_framed(file, kMagic, 7, out.bytes());

  FramedReader in = load_framed(file, kMagic, 7);
  EXPECT_TRUE(std::isnan(in.read<double>()));
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> rows_back;
  std::array<Eigen::Vector2f, 2> pair_back;
  std::string text;
  in.get(rows_back);
  in.get(pair_back);
  in.get(text);
  EXPECT_EQ(rows_back, rows);
  EXPECT_TRUE(std::signbit(rows_back(0, 1)));
  EXPECT_EQ(pair_back, pair);
  EXPECT_EQ(text, std::string("a\0b", 3));
  EXPECT_EQ(in.left(), 0u);
  EXPECT_THROW(in.read<std::uint8_t>(), InputError);
}

TEST_F(Framed, HasTheDocumentedLayout) {
  FramedWriter out;
  out.put(std::uint8_t{0x2a});
  save_framed(file, kMagic, 3, out.bytes());
  // checksum: CRC-32 of the 21 bytes before it
  EXPECT_EQ(read_text(file).substr(0, 21),
            std::string("SANSOTST\x03\0\0\0\x01\0\0\0\0\0\0\0\x2a", 21));
  EXPECT_EQ(read_file(file).size(), 25u);
}

TEST_F(Framed, EveryCutAndEveryFlippedBitIsRefused) {
  FramedWriter out;
  for (int i = 0; i < 5; ++i) out.put(0.1 * i);
  save_framed(file, kMagic, 1, out.bytes());
  const std::vector<std::uint8_t> good = read_file(file);
  const std::filesystem::path bad_file = temporary.path() / "bad.bin";
  for (std::size_t size = 0; size < good.size(); ++size) {
    write_atomically(bad_file, std::span(good).first(size));
    EXPECT_THROW(load_framed(bad_file, kMagic, 1), InputError) << size << " bytes";
  }
  for (std::size_t i = 0; i < good.size(); ++i) {
    std::vector<std::uint8_t> bad = good;
    bad[i] ^= static_cast<std::uint8_t>(1u << (i % 8));
    write_atomically(bad_file, bad);
    EXPECT_THROW(load_framed(bad_file, kMagic, 1), InputError) << "byte " << i;
  }
}

TEST_F(Framed, AnotherKindAndAnotherVersionAreNamed) {
  save_framed(file, kMagic, 2, {});
  EXPECT_THAT([&] { load_framed(file, kMagic, 1); },
              testing::ThrowsMessage<InputError>(testing::HasSubstr("found '2'; expected 1")));
  EXPECT_THAT([&] { load_framed(file, "SANSOOTH", 2); },
              testing::ThrowsMessage<InputError>(testing::HasSubstr("SANSOOTH")));
}

}  // namespace
}  // namespace sanso::files
