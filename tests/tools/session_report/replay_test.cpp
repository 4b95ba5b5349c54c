// What a report's replay holds, read back as the page reads it.
#include "tools/session_report/replay.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "tools/page/embedded/packing.h"

namespace sanso::report {
namespace {

using nlohmann::json;

/// A trial in which everything moves, with an instant that the host did not hear of.
learn::Episode moving(int ticks, int lost = -1) {
  learn::Episode episode;
  for (int k = 0; k < ticks; ++k) {
    if (k == lost) continue;
    wire::Observation o;
    o.trial_tick = k;
    o.x[model::kXPos] = 0.001 * k;
    o.x[model::kXJoint + 3] = std::sin(0.05 * k);
    o.u_upper[0] = 0.02;
    episode.ticks.push_back(o);
    episode.reference.emplace_back();
    episode.reference.back()[2] = 0.27F;
  }
  return episode;
}

struct Unpacked {
  json head;
  std::vector<std::vector<std::vector<double>>> trials;  // [trial][row][column]
};

/// As tools/page/web/src/replay.js does it.
Unpacked unpack(const std::string& bytes) {
  Unpacked out;
  std::uint32_t size = 0;
  std::memcpy(&size, bytes.data(), sizeof size);
  out.head = json::parse(bytes.substr(4, size));
  std::size_t at = 4 + size;
  for (const json& trial : out.head.at("trials")) {
    const auto count = trial.at("count").get<std::size_t>();
    std::vector<std::vector<double>> rows(count, std::vector<double>(kReplayColumns));
    for (std::size_t c = 0; c < kReplayColumns; ++c) {
      std::int16_t sum = 0;
      for (std::size_t k = 0; k < count; ++k, at += 2) {
        std::int16_t word = 0;
        std::memcpy(&word, &bytes.at(at), 2);
        sum = static_cast<std::int16_t>(sum + word);
        rows[k][c] = trial.at("low").at(c).get<double>() +
                     (sum + 32768.0) * trial.at("step").at(c).get<double>();
      }
    }
    out.trials.push_back(rows);
  }
  EXPECT_EQ(at, bytes.size());
  return out;
}

TEST(Replay, EveryNumberComesBackWithinHalfAStepOfItsColumn) {
  learn::TrialSummary summary;
  for (const int ticks : {1, 2, 400}) {
    const learn::Episode episode = moving(ticks);
    const std::vector<ReplayRow> rows = replay_rows(episode, 3);
    ReplayData data("{}", 3);
    data.add(summary, episode);
    data.add(summary, episode);  // a second one begins where the first ends
    const Unpacked read = unpack(data.pack(0, 1));
    ASSERT_EQ(read.trials.size(), 2u);
    for (const auto& trial : read.trials) {
      ASSERT_EQ(trial.size(), rows.size());
      for (std::size_t k = 0; k < rows.size(); ++k)
        for (std::size_t c = 0; c < kReplayColumns; ++c) {
          const double step = read.head.at("trials").at(0).at("step").at(c).get<double>();
          EXPECT_NEAR(trial[k][c], rows[k][c], 0.501 * step) << k << " " << c;
        }
    }
  }
}

TEST(Replay, ALostTickShowsTheOneBeforeItAndTimeGoesOn) {
  const std::vector<ReplayRow> whole = replay_rows(moving(31), 3),
                               lost = replay_rows(moving(31, 15), 3);
  ASSERT_EQ(whole.size(), 11u);
  ASSERT_EQ(lost.size(), whole.size());
  EXPECT_DOUBLE_EQ(lost[5][0], 0.014);
  EXPECT_DOUBLE_EQ(whole[5][0], 0.015);
  EXPECT_DOUBLE_EQ(lost[6][0], whole[6][0]);
}

TEST(Replay, WhatReallyWasIsShownWhereItIsKnown) {
  learn::Episode episode = moving(10);
  EXPECT_DOUBLE_EQ(replay_rows(episode, 3)[1][38], 0.0) << "nobody measured the feet";
  for (const wire::Observation& o : episode.ticks) {
    learn::TrueSample truth;
    truth.x = o.x;
    truth.x[model::kXPos] += 0.5;
    truth.foot_load_N = {10.0F, 20.0F};
    episode.truth.push_back(truth);
  }
  const std::vector<ReplayRow> rows = replay_rows(episode, 3);
  EXPECT_DOUBLE_EQ(rows[1][0], 0.503);
  EXPECT_DOUBLE_EQ(rows[1][38], 10.0);
  EXPECT_DOUBLE_EQ(rows[1][39], 20.0);
}

TEST(Replay, AnUpdateHoldsUntilTheNext) {
  learn::Episode episode = moving(30);
  for (const int tick : {6, 18}) {
    learn::PlanRecord plan;
    plan.observed_tick = tick;
    plan.update_ms = tick;
    episode.plans.push_back(plan);
  }
  const std::vector<ReplayRow> rows = replay_rows(episode, 3);
  for (std::size_t k = 0; k < rows.size(); ++k)
    EXPECT_EQ(rows[k].back(), k < 2 ? 0.0 : k < 6 ? 6.0 : 18.0) << k;
}

TEST(Packing, Base64IsThatOfTheStandard) {  // RFC 4648, section 10
  const std::pair<const char*, const char*> kVectors[] = {{"", ""},
                                                          {"f", "Zg=="},
                                                          {"fo", "Zm8="},
                                                          {"foo", "Zm9v"},
                                                          {"foob", "Zm9vYg=="},
                                                          {"fooba", "Zm9vYmE="},
                                                          {"foobar", "Zm9vYmFy"}};
  for (const auto& [plain, coded] : kVectors) EXPECT_EQ(page::base64(plain), coded);
  EXPECT_EQ(page::base64(std::string("\xff\xef\xbe", 3)), "/+++");
}

TEST(Packing, GzipIsWhatZlibUnpacks) {
  std::string text;
  for (int i = 0; i < 20000; ++i) text += std::to_string(i % 97);
  const std::string zipped = page::gzip(text);
  EXPECT_LT(zipped.size(), text.size() / 4);
  z_stream z{};
  ASSERT_EQ(inflateInit2(&z, 16 + 15), Z_OK);  // gzip, nothing else
  std::string back(text.size() + 1, '\0');
  z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(zipped.data()));
  z.avail_in = static_cast<uInt>(zipped.size());
  z.next_out = reinterpret_cast<Bytef*>(back.data());
  z.avail_out = static_cast<uInt>(back.size());
  EXPECT_EQ(inflate(&z, Z_FINISH), Z_STREAM_END);
  back.resize(z.total_out);
  inflateEnd(&z);
  EXPECT_EQ(back, text);
}

}  // namespace
}  // namespace sanso::report
