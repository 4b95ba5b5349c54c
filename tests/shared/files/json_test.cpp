// Stored JSON: whole, cut at any byte, missing.
#include "shared/files/json.h"

#include <gmock/gmock.h>

#include "tests/support/temp_folder.h"

namespace sanso::files {
namespace {

using testing::HasSubstr;

struct StoredJson : testing::Test {
  test::TempFolder temporary;
  std::filesystem::path file = temporary.path() / "summary.json";
  const std::string whole = R"({"motion": "squat", "trials": [1, 2.5, null]})";
};

TEST_F(StoredJson, ComesBackAsItWas) {
  write_atomically(file, whole);
  EXPECT_EQ(read_json(file), nlohmann::json::parse(whole));
  EXPECT_EQ(json_or_null(file), nlohmann::json::parse(whole));
}

TEST_F(StoredJson, KeepsTheOrderOfAnOrderedKind) {
  write_atomically(file, R"({"b": 1, "a": 2})");
  EXPECT_EQ(read_json<nlohmann::ordered_json>(file).dump(), R"({"b":1,"a":2})");
}

TEST_F(StoredJson, CutAnywhereIsNothingOrAnErrorThatNamesTheFile) {
  for (std::size_t kept = 0; kept < whole.size(); ++kept) {
    write_atomically(file, whole.substr(0, kept));
    EXPECT_TRUE(json_or_null(file).is_null()) << kept;
    try {
      read_json(file);
      FAIL() << kept;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(file.string()));
      EXPECT_EQ(error.defect, "not JSON");
    }
  }
}

TEST_F(StoredJson, MissingIsNothingOrAnErrorThatSaysSo) {
  EXPECT_TRUE(json_or_null(file).is_null());
  try {
    read_json(file);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.defect, "cannot open");
  }
}

}  // namespace
}  // namespace sanso::files
