// The accepted part of TOML: what passes, what is refused and on which line.
#include "shared/files/toml_grammar.h"

#include <gtest/gtest.h>

#include <string>

namespace sanso::files {
namespace {

TEST(TomlGrammar, AcceptsWhatSettingsFilesAreWrittenIn) {
  for (const std::string_view text :
       {"", "\n\r\n  \t\n", "\xef\xbb\xbf# mark and comment \xc3\xa9\n", "a = 1",
        "a.b . \"c d\".'e' = -0.5e-3 # note\n", "[a]\n[a.b]\n[[ c ]] # list\n",
        "a = +inf\nb = -nan\nc = 1_000\nd = 0\ne = 1e3\nf = true\n",
        "a = [ # first\n 1,\n\n [2, 3], # second\n]\n",
        "a = []\nb = {}\nc = { x = 1, y = [ {z = 'q'} ] }\n",
        R"(a = "tab \t quote \" slash \\ e \u00e9 \U0001F600")", "a = \"\"\nb = ''\n"}) {
    const auto defect = first_toml_defect(text);
    EXPECT_FALSE(defect) << text << " -> " << (defect ? defect->expected : "");
  }
}

TEST(TomlGrammar, RefusesTheRestWithItsLine) {
  struct Case {
    std::string_view text;
    int line;
  };
  using namespace std::string_view_literals;
  for (const Case& c : {Case{"a", 1},
                        Case{"a =", 1},
                        Case{"a = \n", 1},
                        Case{"\na = 1 b = 2\n", 2},
                        Case{"[", 1},
                        Case{"[]", 1},
                        Case{"[[a]\n", 1},
                        Case{"\n\n[a] x\n", 3},
                        Case{"a = 01\n", 1},
                        Case{"a = 1__0\n", 1},
                        Case{"a = .5\n", 1},
                        Case{"a = 1.\n", 1},
                        Case{"a = 1e\n", 1},
                        Case{"a = 0x10\n", 1},
                        Case{"a = 1979-05-27\n", 1},
                        Case{"a = \"\"\"b\"\"\"\n", 1},
                        Case{"a = \"b\nc\"\n", 1},
                        Case{"a = \"\\q\"\n", 1},
                        Case{"a = \"\\ud800\"\n", 1},
                        Case{"a = \"\\u12\"\n", 1},
                        Case{"a = [1 2]\n", 1},
                        Case{"a = [\n1,\n,]\n", 3},
                        Case{"a = [1,\n}", 2},
                        Case{"a = [", 1},
                        Case{"a = {x = 1,}\n", 1},
                        Case{"a = {x = 1\n}\n", 1},
                        Case{"\xc7\xbd = 1\n", 1},
                        Case{"a = '\xc3'\n", 1},
                        Case{"a = '\xed\xa0\x80'\n", 1},
                        Case{"# \x01\n", 1},
                        Case{"a = '\0'\n"sv, 1},
                        Case{"\0"sv, 1},
                        Case{"a\r= 1\n", 1}}) {
    const auto defect = first_toml_defect(c.text);
    ASSERT_TRUE(defect) << c.text;
    EXPECT_EQ(defect->line, c.line) << c.text;
    EXPECT_FALSE(std::string(defect->expected).empty()) << c.text;
  }
}

TEST(TomlGrammar, BoundsTheDepth) {
  EXPECT_FALSE(first_toml_defect("a = " + std::string(16, '[') + std::string(16, ']')));
  EXPECT_TRUE(first_toml_defect("a = " + std::string(100'000, '[')));
}

}  // namespace
}  // namespace sanso::files
