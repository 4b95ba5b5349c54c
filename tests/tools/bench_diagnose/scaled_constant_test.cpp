// Every constant of the diagnosis can be scaled for the table in docs/results/diagnose.md, and only
// by a proper factor.
#include "tools/bench/diagnose/scaled_constant.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <regex>
#include <stdexcept>

#include "tools/diagnose/constants.h"

namespace sanso::bench {
namespace {

TEST(ScaledConstant, ScalesRealAndWholeNumbers) {
  const double level = diagnose::constants::kFamilyWise;
  scale_constant("kFamilyWise=0.5");
  EXPECT_EQ(diagnose::constants::kFamilyWise, 0.5 * level);
  scale_constant("kFamilyWise=2");
  EXPECT_EQ(diagnose::constants::kFamilyWise, level);
  const int rivals = diagnose::constants::kRivals;
  scale_constant("kRivals=0.01");
  EXPECT_EQ(diagnose::constants::kRivals, 1) << "a count stays at least one";
  diagnose::constants::kRivals = rivals;
}

TEST(ScaledConstant, RefusesUnknownNamesAndBadFactors) {
  for (const char* bad : {"kNothing=2", "kFamilyWise", "kFamilyWise=", "kFamilyWise=0",
                          "kFamilyWise=-1", "kFamilyWise=inf", "=2", ""}) {
    EXPECT_THROW(scale_constant(bad), std::invalid_argument) << bad;
  }
}

TEST(ScaledConstant, KnowsEveryConstantOfTheHeader) {
  std::ifstream header("tools/diagnose/constants.h");
  ASSERT_TRUE(header) << "tests run from the top of the repository";
  const std::vector<std::string> known = constant_names();
  const std::regex definition("^inline (?:double|int) (k[A-Za-z]+) =.*");
  std::smatch match;
  std::size_t found = 0;
  for (std::string line; std::getline(header, line);) {
    if (!std::regex_match(line, match, definition)) continue;
    ++found;
    EXPECT_NE(std::find(known.begin(), known.end(), match[1].str()), known.end()) << match[1];
  }
  EXPECT_EQ(found, known.size());
  EXPECT_GT(found, 30u);
}

}  // namespace
}  // namespace sanso::bench
