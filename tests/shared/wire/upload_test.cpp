// Uploads: pieces in any order make the blob; policies and tables keep their (rounded) numbers.
#include "shared/wire/upload.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <numeric>
#include <random>
#include <vector>

#include "shared/policy/policy_bytes.h"

namespace sanso::wire {
namespace {

std::vector<std::uint8_t> blob_of(std::size_t bytes, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::uint8_t> blob(bytes);
  for (auto& b : blob) b = static_cast<std::uint8_t>(random());
  return blob;
}

UploadChunk piece(const std::vector<std::uint8_t>& blob, std::size_t index, std::uint32_t id = 1) {
  return make_chunk(UploadKind::middle_table, id, blob, crc32(blob), index);
}

using Assembler = FixedUploadAssembler<10 * kChunkPayload>;

TEST(Crc32, CheckValue) {
  const char* text = "123456789";
  EXPECT_EQ(crc32({reinterpret_cast<const std::uint8_t*>(text), 9}), 0xCBF43926u);
}

TEST(Upload, AnyOrderAndRepeatsMakeTheBlob) {
  for (const std::size_t bytes :
       {std::size_t{1}, kChunkPayload - 1, kChunkPayload, kChunkPayload + 1, 10 * kChunkPayload}) {
    const auto blob = blob_of(bytes, 1);
    std::vector<std::size_t> order(chunk_count(bytes));
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::shuffle(order.begin(), order.end(), std::mt19937(2));
    Assembler assembler;
    for (const std::size_t i : order) {
      EXPECT_FALSE(assembler->complete());
      EXPECT_EQ(assembler->accept(piece(blob, i)), Status::ok);
      EXPECT_EQ(assembler->accept(piece(blob, i)), Status::ok);
    }
    ASSERT_TRUE(assembler->complete());
    EXPECT_TRUE(std::ranges::equal(assembler->blob(), blob));
    EXPECT_EQ(assembler->first_missing(), order.size());
  }
}

TEST(Upload, OneByteTooLarge_ReportsFull) {
  const auto blob = blob_of(10 * kChunkPayload + 1, 1);
  Assembler assembler;
  EXPECT_EQ(assembler->accept(piece(blob, 0)), Status::full);
}

TEST(Upload, FirstMissingNamesTheGap) {
  const auto blob = blob_of(3 * kChunkPayload, 1);
  Assembler assembler;
  (void)assembler->accept(piece(blob, 0));
  (void)assembler->accept(piece(blob, 2));
  EXPECT_EQ(assembler->first_missing(), 1);
  EXPECT_FALSE(assembler->complete());
}

TEST(Upload, AWrongChecksumForgetsEverything) {
  const auto blob = blob_of(2 * kChunkPayload, 1);
  Assembler assembler;
  auto first = make_chunk(UploadKind::primitives, 1, blob, crc32(blob) ^ 1u, 0);
  auto second = make_chunk(UploadKind::primitives, 1, blob, crc32(blob) ^ 1u, 1);
  EXPECT_EQ(assembler->accept(first), Status::ok);
  EXPECT_EQ(assembler->accept(second), Status::rejected);
  EXPECT_FALSE(assembler->complete());
  EXPECT_EQ(assembler->first_missing(), 0);
}

TEST(Upload, ANewIdStartsOverAndPiecesDoNotMix) {
  const auto one = blob_of(2 * kChunkPayload, 1), two = blob_of(2 * kChunkPayload, 2);
  Assembler assembler;
  (void)assembler->accept(piece(one, 0, 1));
  (void)assembler->accept(piece(two, 1, 2));
  EXPECT_FALSE(assembler->complete());
  (void)assembler->accept(piece(two, 0, 2));
  ASSERT_TRUE(assembler->complete());
  EXPECT_TRUE(std::ranges::equal(assembler->blob(), two));
}

TEST(Upload, APieceThatContradictsTheFirstIsMalformed) {
  const auto blob = blob_of(3 * kChunkPayload, 1);
  Assembler assembler;
  (void)assembler->accept(piece(blob, 0));
  auto liar = piece(blob, 1);
  liar.checksum ^= 1u;
  EXPECT_EQ(assembler->accept(liar), Status::malformed);
}

// --- policies ------------------------------------------------------------------------------------

policy::Knot random_knot(std::mt19937& random) {
  std::normal_distribution<double> normal;
  policy::Knot knot;
  for (int i = 0; i < knot.u.size(); ++i) knot.u[i] = normal(random);
  for (int i = 0; i < knot.x.size(); ++i) knot.x[i] = normal(random);
  knot.x.segment<4>(model::kXQuat).normalize();
  for (int i = 0; i < knot.K.size(); ++i) knot.K.data()[i] = normal(random);
  return knot;
}

TEST(PolicyBytes, ControllerReadsExactlyWhatTheHostRounded) {
  std::mt19937 random(5);
  policy::UpperPolicy sent;
  sent.sequence = 8;
  sent.trial_id = 3;
  sent.first_tick = 126;
  for (int i = 0; i < 4; ++i) sent.knots.try_push(random_knot(random));
  policy::round_to_wire(sent);
  std::vector<std::uint8_t> bytes(policy::kMaxUpperBytes);
  ASSERT_EQ(*policy::to_bytes(sent, bytes), bytes.size());
  policy::UpperPolicy read;
  ASSERT_EQ(policy::from_bytes(bytes, read), Status::ok);
  EXPECT_EQ(read.first_tick, 126);
  ASSERT_EQ(read.knots.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(read.knots[i].u, sent.knots[i].u);
    EXPECT_EQ(read.knots[i].x, sent.knots[i].x);
    EXPECT_EQ(read.knots[i].K, sent.knots[i].K);
  }
}

TEST(PolicyBytes, OtherLengthsAndBadQuaternionsAreMalformed) {
  std::mt19937 random(5);
  policy::UpperPolicy sent;
  sent.knots.try_push(random_knot(random));
  std::vector<std::uint8_t> bytes(policy::kMaxUpperBytes);
  bytes.resize(*policy::to_bytes(sent, bytes));
  policy::UpperPolicy out;
  for (std::size_t n = 0; n < bytes.size(); n += 7)
    EXPECT_EQ(policy::from_bytes(std::span(bytes).first(n), out), Status::malformed);
  auto longer = bytes;
  longer.push_back(0);
  EXPECT_EQ(policy::from_bytes(longer, out), Status::malformed);
  sent.knots[0].x[model::kXQuat] += 2;
  ASSERT_TRUE(policy::to_bytes(sent, bytes).ok());
  EXPECT_EQ(policy::from_bytes(bytes, out), Status::malformed);
  EXPECT_TRUE(out.knots.empty());
}

TEST(PolicyBytes, AFullMiddleTableMakesTheRoundTrip) {
  std::mt19937 random(6);
  const auto table = std::make_unique<policy::MiddleTable>();
  table->trial_id = 12;
  const policy::Knot knot = random_knot(random);
  while (table->knots.try_push(knot)) {
  }
  policy::round_to_wire(*table);
  std::vector<std::uint8_t> bytes(policy::kMaxMiddleBytes);
  ASSERT_EQ(*policy::to_bytes(*table, bytes), bytes.size());
  const auto read = std::make_unique<policy::MiddleTable>();
  ASSERT_EQ(policy::from_bytes(bytes, *read), Status::ok);
  EXPECT_EQ(read->trial_id, 12u);
  EXPECT_EQ(read->knots.size(), policy::kMaxMiddleKnots);
  EXPECT_EQ(read->knots.back().K, table->knots.back().K);
  bytes.pop_back();
  EXPECT_EQ(policy::from_bytes(bytes, *read), Status::malformed);
}

}  // namespace
}  // namespace sanso::wire
