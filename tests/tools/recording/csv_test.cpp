// Recordings as CSV: exact both ways, and every broken file is refused by file, line and column.
#include <gtest/gtest.h>

#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "shared/files/input_error.h"
#include "tools/recording/csv_reader.h"
#include "tools/recording/csv_writer.h"

namespace sanso::recording {
namespace {

TEST(CsvReader, ReadsColumnsAndLeavesEmptyCellsUnsampled) {
  const Recording r = parse_csv("t,q:knee,u:knee,volt\n0,0.5,0.25,12\n0.01,,,12.1\n", "a.csv");
  EXPECT_EQ(r.rows(), 2u);
  EXPECT_EQ(r.find("q:knee")[0], 0.5);
  EXPECT_TRUE(std::isnan(r.find("q:knee")[1]));
  EXPECT_TRUE(std::isnan(r.find("u:knee")[1]));
  EXPECT_EQ(r.find("volt")[1], 12.1);
  EXPECT_TRUE(r.find("dq:knee").empty());
  EXPECT_EQ(r.joints(), std::vector<std::string>{"knee"});
}

TEST(CsvReader, AcceptsByteOrderMarkCarriageReturnsAndMissingLastNewline) {
  const Recording r = parse_csv("\xEF\xBB\xBFt, q:a\r\n0, +1e-3\r\n1,2", "a.csv");
  EXPECT_EQ(r.find("q:a")[0], 1e-3);
  EXPECT_EQ(r.rows(), 2u);
}

TEST(CsvReader, KeepsUnknownColumnsOutAndSaysSo) {
  const Recording r = parse_csv("t,q:a,comment,torque:a\n0,1,bad cell,3\n", "a.csv");
  EXPECT_EQ(r.ignored, (std::vector<std::string>{"comment", "torque:a"}));
  EXPECT_EQ(r.channels.size(), 1u);
}

struct BadCase {
  const char* text;
  const char* defect;
  int line;
  const char* channel;
};

class CsvReaderRefuses : public testing::TestWithParam<BadCase> {};

TEST_P(CsvReaderRefuses, NamingFileLineAndColumn) {
  const BadCase& bad = GetParam();
  try {
    parse_csv(bad.text, "bad.csv");
    FAIL() << "accepted: " << bad.text;
  } catch (const files::InputError& e) {
    EXPECT_EQ(e.defect, bad.defect);
    EXPECT_EQ(e.line, bad.line);
    EXPECT_EQ(e.channel, bad.channel);
    EXPECT_EQ(e.file, "bad.csv");
    EXPECT_NE(std::string(e.what()).find("expected"), std::string::npos) << e.what();
  }
}

INSTANTIATE_TEST_SUITE_P(
    Faults, CsvReaderRefuses,
    testing::Values(BadCase{"", "empty file", 0, ""},                               //
                    BadCase{"\n\n", "empty file", 0, ""},                           //
                    BadCase{"t,q:a\n", "header only", 0, ""},                       //
                    BadCase{"t,q:a\n0,nan\n", "NaN or infinity", 2, "q:a"},         //
                    BadCase{"t,q:a\n0,1\n1,-inf\n", "NaN or infinity", 3, "q:a"},   //
                    BadCase{"t,q:a\n0,1e999\n", "number out of range", 2, "q:a"},   //
                    BadCase{"t,q:a\n0,0.1x\n", "not a number", 2, "q:a"},           //
                    BadCase{"t,q:a\n,1\n", "time missing", 2, "t"},                 //
                    BadCase{"t,q:a\n0,1,2\n", "wrong number of cells", 2, ""},      //
                    BadCase{"t,q:a\n0\n", "wrong number of cells", 2, ""},          //
                    BadCase{"t,q:a\n0,1\n\n1,1\n", "blank line", 3, ""},            //
                    BadCase{"t,q:a,q:a\n0,1,1\n", "column given twice", 1, "q:a"},  //
                    BadCase{"t,,q:a\n0,1,1\n", "column without a name", 1, ""},     //
                    BadCase{"q:a\n1\n", "no time column", 1, "t"},                  //
                    BadCase{"0,1\n1,2\n", "no header", 1, ""},                      //
                    BadCase{"t;q:a\n0;1\n", "wrong separator", 1, ""}));

TEST(CsvReader, RefusesWhatIsLargerThanItsMemory) {
  CsvLimits limits;
  limits.max_values = 6;
  EXPECT_EQ(parse_csv("t,q:a\n0,1\n1,1\n2,1\n", "a.csv", limits).rows(), 3u);  // exact fit
  EXPECT_THROW(parse_csv("t,q:a\n0,1\n1,1\n2,1\n3,1\n", "a.csv", limits), files::InputError);
  limits = {};
  limits.max_line_bytes = 100;
  EXPECT_THROW(parse_csv("t,q:a\n" + std::string(101, '1'), "a.csv", limits), files::InputError);
}

TEST(CsvReader, TimeMustIncrease) {
  require_increasing_time(parse_csv("t,q:a\n0,1\n0.1,1\n", "a.csv"));
  for (const char* text : {"t,q:a\n0,1\n0.1,1\n0.05,1\n", "t,q:a\n-1,1\n0,1\n0,1\n"}) {
    try {
      require_increasing_time(parse_csv(text, "a.csv"));
      FAIL();
    } catch (const files::InputError& e) {
      EXPECT_EQ(e.line, 4);
      EXPECT_EQ(e.defect, "time does not increase");
    }
  }
}

class CsvFiles : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("sanso_csv_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string path(const char* name) const { return (folder_ / name).string(); }
  std::filesystem::path folder_;
};

TEST_F(CsvFiles, WhatIsWrittenReadsBackBitForBit) {
  Recording r;
  r.t = {0.0, 0.1 + 0.2, 1e9 / 3};
  r.set("q:a", {1.0 / 3, NAN, -0.0});
  r.set("u:a", {5e-324, 1.7976931348623157e308, 2});
  for (const char* name : {"a.csv", "b.csv.gz"}) {
    write_csv(r, path(name));
    const Recording back = read_csv(path(name));
    EXPECT_EQ(to_csv(back), to_csv(r)) << name;
    EXPECT_EQ(back.t, r.t);
    EXPECT_EQ(back.stem(), std::string(name).substr(0, 1));
  }
  unsigned char magic[2] = {};
  std::ifstream(path("b.csv.gz"), std::ios::binary).read(reinterpret_cast<char*>(magic), 2);
  EXPECT_EQ(magic[0], 0x1f) << "a name ending in .gz is packed";
}

TEST_F(CsvFiles, RefusesTruncatedGzipBinaryAndMissingFiles) {
  Recording r;
  for (int k = 0; k < 5000; ++k) r.t.push_back(k * 0.01);
  r.set("q:a", std::vector<double>(5000, 0.1));
  write_csv(r, path("whole.csv.gz"));
  std::filesystem::resize_file(path("whole.csv.gz"),
                               std::filesystem::file_size(path("whole.csv.gz")) / 2);
  EXPECT_THROW(read_csv(path("whole.csv.gz")), files::InputError);
  std::ofstream(path("zero.csv"), std::ios::binary).write("t,q:a\n0,\0\0\0\n", 13);
  EXPECT_THROW(read_csv(path("zero.csv")), files::InputError);
  EXPECT_THROW(read_csv(path("none.csv")), files::InputError);
  EXPECT_THROW(read_csv(folder_.string()), files::InputError);
}

TEST_F(CsvFiles, StreamsAFileThatIsTooLargeAndStopsAtTheLimit) {
  {
    std::ofstream out(path("large.csv"));
    out << "t,q:a\n";
    for (int k = 0; k < 200000; ++k) out << k << ",1\n";
  }
  CsvLimits limits;
  limits.max_values = 1000;
  try {
    read_csv(path("large.csv"), limits);
    FAIL();
  } catch (const files::InputError& e) {
    EXPECT_EQ(e.defect, "recording too large");
    EXPECT_EQ(e.line, 502);  // header, 500 rows that fit, then this one
  }
}

}  // namespace
}  // namespace sanso::recording
