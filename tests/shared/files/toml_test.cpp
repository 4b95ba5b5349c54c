// Reading settings by key: what stands there, what is wrong with it and on which line.
#include "shared/files/toml.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "shared/files/atomic_file.h"
#include "shared/files/input_error.h"
#include "tests/support/temp_folder.h"

namespace sanso::files {
namespace {

const std::string kText = R"(name = "lab"
mass = 2.5
count = 3
on = true
com = [0, 1.5, -2]
tags = ["a", "b"]
[servo]
gain = 0.5
[[part]]
id = 1
[[part]]
id = 2
)";

TomlTable table() { return TomlTable::parse(kText, "a.toml"); }

std::string refusal(const std::function<void(const TomlTable&)>& read,
                    const std::string& text = kText) {
  try {
    read(TomlTable::parse(text, "a.toml"));
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing refused";
}

TEST(Toml, ReadsEveryKindOfValue) {
  const TomlTable t = table();
  EXPECT_EQ(t.string("name"), "lab");
  EXPECT_EQ(t.number("mass", 0, 10), 2.5);
  EXPECT_EQ(t.number("count", 0, 10), 3.0) << "a whole number is a number";
  EXPECT_EQ(t.integer("count"), 3);
  EXPECT_EQ(t.boolean("on"), true);
  EXPECT_EQ(t.numbers("com", 3), (std::vector<double>{0, 1.5, -2}));
  EXPECT_EQ(t.strings("tags"), (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(t.table("servo")->number("gain", 0, 1), 0.5);
  ASSERT_EQ(t.tables("part").size(), 2u);
  EXPECT_EQ(t.tables("part")[1].integer("id", 0, 2), 2);
  EXPECT_EQ(t.choice("name", {"nominal", "lab"}), 1u);
  EXPECT_NO_THROW(t.finish());
}

TEST(Toml, AMissingKeyIsEmptyAndLeavesTheDefault) {
  const TomlTable t = table();
  EXPECT_FALSE(t.number("none", 0, 1) || t.integer("none") || t.boolean("none") ||
               t.string("none") || t.numbers("none", 2) || t.strings("none") || t.table("none") ||
               t.choice("none", {"a"}));
  EXPECT_TRUE(t.tables("none").empty());
  double value = 7;
  TomlTable::into(value, t.number("none", 0, 1));
  EXPECT_EQ(value, 7);
  EXPECT_EQ(refusal([](const TomlTable& r) { r.need("none", r.number("none", 0, 1), "kg"); }),
            "a.toml:1: missing key in 'none'; expected kg");
}

TEST(Toml, AValueOutsideItsRangeIsNamedWithItsLine) {
  EXPECT_EQ(refusal([](const TomlTable& t) { t.number("mass", 0, 2); }),
            "a.toml:2: out of range in 'mass': found '2.5'; expected a number from 0.0 to 2.0");
  EXPECT_EQ(refusal([](const TomlTable& t) { t.table("servo")->number("gain", 1, 2); }),
            "a.toml:8: out of range in 'servo.gain': found '0.5'; expected a number from 1.0 to "
            "2.0");
  EXPECT_EQ(refusal([](const TomlTable& t) { t.integer("count", 4, 9); }),
            "a.toml:3: out of range in 'count': found '3'; expected a whole number from 4 to 9");
  EXPECT_NO_THROW(table().number("mass", 2.5, 2.5)) << "a range holds its ends";
  constexpr double kInf = std::numeric_limits<double>::infinity();
  EXPECT_NE(refusal([](const TomlTable& t) { t.number("x", -kInf, kInf); }, "x = nan"),
            "nothing refused");
}

TEST(Toml, AnotherTypeIsNamedWithItsLine) {
  using Read = std::function<void(const TomlTable&)>;
  const std::pair<Read, const char*> wrong[] = {
      {[](const TomlTable& t) { t.number("name", 0, 1); }, "a.toml:1: not a number"},
      {[](const TomlTable& t) { t.number("on", 0, 1); }, "a.toml:4: not a number"},
      {[](const TomlTable& t) { t.integer("mass"); }, "a.toml:2: not an integer"},
      {[](const TomlTable& t) { t.integer("mass", 0, 9); }, "a.toml:2: not an integer"},
      {[](const TomlTable& t) { t.boolean("count"); }, "a.toml:3: neither true nor false"},
      {[](const TomlTable& t) { t.string("mass"); }, "a.toml:2: not a string"},
      {[](const TomlTable& t) { t.numbers("com", 2); }, "a.toml:5: wrong list"},
      {[](const TomlTable& t) { t.numbers("tags", 2); }, "a.toml:6: wrong list"},
      {[](const TomlTable& t) { t.strings("com"); }, "a.toml:5: wrong list"},
      {[](const TomlTable& t) { t.table("mass"); }, "a.toml:2: not a table"},
      {[](const TomlTable& t) { t.tables("servo"); }, "a.toml:7: not a list of tables"},
      {[](const TomlTable& t) {
         t.choice("name", {"x", "y"});
       },
       "a.toml:1: unknown name"}};
  for (const auto& [read, expected] : wrong)
    EXPECT_EQ(refusal(read).substr(0, std::string(expected).size()), expected);
}

TEST(Toml, AKeyThatNobodyAskedForIsNamed) {
  const std::string text = "mass = 1\n\nmas = 2\n";
  const auto read = [](const TomlTable& t) {
    t.number("mass", 0, 9);
    t.finish("one of the keys");
  };
  EXPECT_EQ(refusal(read, text),
            "a.toml:3: unknown key in 'mas': found '2'; expected one of the keys");
  EXPECT_EQ(refusal(
                [](const TomlTable& t) {
                  t.allow_only({"mass", "com"});
                },
                text),
            "a.toml:3: unknown key in 'mas': found 'mas'; expected one of: mass, com");
}

TEST(Toml, CutAnywhereItIsRefusedOrReadNeverWorse) {
  for (std::size_t size = 0; size < kText.size(); ++size) {
    try {
      const TomlTable t = TomlTable::parse(kText.substr(0, size), "a.toml");
      EXPECT_LE(t.keys().size(), 8u);
    } catch (const InputError& error) {
      EXPECT_EQ(error.defect, "not valid TOML");
      EXPECT_GE(error.line, 1);
    }
  }
}

TEST(Toml, AFileThatIsMissingOrFarTooLargeIsNamed) {
  const test::TempFolder folder;
  const std::string path = (folder.path() / "big.toml").string();
  EXPECT_THROW(TomlTable::read(path), InputError);
  write_atomically(path, std::string(1'000'001, '\n'));
  EXPECT_THROW(TomlTable::read(path), InputError);
  write_atomically(path, "x = 1\n");
  EXPECT_EQ(TomlTable::read(path).integer("x"), 1);
}

TEST(Toml, WhatIsWrittenReadsBack) {
  const std::string name = "a \"b\" \\ c\n\x7f";
  const std::string text =
      toml_key("two words") + " = " + toml_quoted(name) + "\nn = " + toml_number(0.1) + "\n";
  const TomlTable t = TomlTable::parse(text, "a.toml");
  EXPECT_EQ(t.string("two words"), name);
  EXPECT_EQ(t.number("n", 0, 1), 0.1);
  EXPECT_EQ(toml_number(12), "12.0");
}

}  // namespace
}  // namespace sanso::files
