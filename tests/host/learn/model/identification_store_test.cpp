// A stored search reads back exactly; another search's file and every cut one are refused.
#include "host/learn/model/identification_store.h"

#include <gtest/gtest.h>

#include "shared/files/atomic_file.h"
#include "tests/support/temp_folder.h"

namespace sanso::learn {
namespace {

constexpr std::uint64_t kFingerprint = 42;

struct SearchFile : testing::Test {
  test::TempFolder folder;
  std::filesystem::path path = folder.path() / "search.state";
  CrossEntropyState state{7, Eigen::Vector3d(0.1, -0.2, 0.3), Eigen::Vector3d(1.0, 0.5, 0.02),
                          Eigen::Vector3d(0.4, 0.0, -1.0), 0.125};

  SearchFile() { save_search(path, state, kFingerprint); }
};

TEST_F(SearchFile, RoundTripIsExact) {
  const CrossEntropyState back = load_search(path, kFingerprint);
  EXPECT_EQ(back.generation, state.generation);
  EXPECT_EQ(back.mean, state.mean);
  EXPECT_EQ(back.deviation, state.deviation);
  EXPECT_EQ(back.best, state.best);
  EXPECT_EQ(back.best_loss, state.best_loss);
}

TEST_F(SearchFile, OfAnotherSearchIsRefused) {
  EXPECT_THROW(load_search(path, kFingerprint + 1), std::runtime_error);
}

TEST_F(SearchFile, CutAnywhereIsRefused) {
  const std::vector<std::uint8_t> whole = files::read_file(path);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    files::write_atomically(path, std::span(whole).first(size));
    EXPECT_THROW(load_search(path, kFingerprint), std::runtime_error)
        << size << " of " << whole.size() << " bytes";
  }
}

}  // namespace
}  // namespace sanso::learn
