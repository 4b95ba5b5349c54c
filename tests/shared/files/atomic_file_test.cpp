// What is on the disk after a write that went well, and after one that did not.
#include "shared/files/atomic_file.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>

#include "shared/files/input_error.h"
#include "tests/support/temp_folder.h"

namespace sanso::files {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

struct AtomicFile : testing::Test {
  test::TempFolder temporary;
  fs::path folder = temporary.path();
  fs::path file = folder / "result.json";
  /// Names in the folder: nothing unfinished may be left there.
  std::vector<std::string> names() const {
    std::vector<std::string> out;
    for (const auto& entry : fs::directory_iterator(folder)) out.push_back(entry.path().filename());
    return out;
  }
};

/// Files of this process may not grow beyond `bytes`: what a full disk looks like to one write.
struct SmallDisk {
  rlimit before{};
  explicit SmallDisk(rlim_t bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before);
    const rlimit small{bytes, before.rlim_max};
    setrlimit(RLIMIT_FSIZE, &small);
  }
  ~SmallDisk() {
    setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, SIG_DFL);
  }
};

TEST_F(AtomicFile, HoldsWhatWasWrittenAndNothingStandsBeside) {
  write_atomically(file, "old");
  write_atomically(file, std::string_view("new\0with a zero", 15));
  EXPECT_EQ(read_text(file), std::string_view("new\0with a zero", 15));
  EXPECT_EQ(names(), std::vector<std::string>{"result.json"});
  write_atomically(file, "");
  EXPECT_TRUE(read_file(file).empty());
}

TEST_F(AtomicFile, WhatAKilledRunLeftBesideIsWrittenOver) {
  write_atomically(folder / "result.json.new", "half of a longer file");
  write_atomically(file, "whole");
  EXPECT_EQ(read_text(file), "whole");
  EXPECT_EQ(names().size(), 1u);
}

TEST_F(AtomicFile, AFullDiskLeavesTheOldFile) {
  write_atomically(file, "old");
  for (const std::size_t room : {0u, 1u, 4096u, 69999u}) {
    const SmallDisk disk(room);
    EXPECT_THROW(write_atomically(file, std::string(70000, 'x')), WriteError) << room;
  }
  EXPECT_EQ(read_text(file), "old");
  EXPECT_EQ(names().size(), 1u);
}

TEST_F(AtomicFile, AFullDeviceSaysWhatToDo) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  try {
    write_atomically("/dev/full", "text");
    FAIL() << "expected an error";
  } catch (const WriteError& error) {
    EXPECT_THAT(error.what(), HasSubstr("/dev/full: cannot write: No space left"));
    EXPECT_THAT(error.what(), HasSubstr("run the same command again"));
  }
}

TEST_F(AtomicFile, AFolderThatIsMissingIsNamed) {
  try {
    write_atomically(folder / "none" / "x", "text");
    FAIL() << "expected an error";
  } catch (const WriteError& error) {
    EXPECT_THAT(error.what(), HasSubstr("none/x: cannot create"));
    EXPECT_THAT(error.what(), HasSubstr("folder that exists and may be written"));
  }
}

TEST_F(AtomicFile, AFolderThatMayNotBeWrittenLeavesTheOldFile) {
  write_atomically(file, "old");
  fs::permissions(folder, fs::perms::owner_read | fs::perms::owner_exec);
  if (::access(folder.c_str(), W_OK) == 0) {
    fs::permissions(folder, fs::perms::owner_all);
    GTEST_SKIP() << "this user may write everywhere";
  }
  EXPECT_THROW(write_atomically(file, "new"), WriteError);
  fs::permissions(folder, fs::perms::owner_all);
  EXPECT_EQ(read_text(file), "old");
}

TEST_F(AtomicFile, AFolderInThePlaceOfTheFileIsRefusedAndKept) {
  fs::create_directories(file / "inside");
  EXPECT_THROW(write_atomically(file, "text"), WriteError);
  EXPECT_TRUE(fs::exists(file / "inside"));
  EXPECT_EQ(names().size(), 1u);
}

TEST_F(AtomicFile, ALinkStaysALinkAndItsFileIsReplaced) {
  write_atomically(folder / "real", "old");
  fs::create_symlink("real", file);
  write_atomically(file, "new");
  EXPECT_TRUE(fs::is_symlink(file));
  EXPECT_EQ(read_text(folder / "real"), "new");
}

TEST_F(AtomicFile, ADeviceIsWrittenToAndNotReplaced) {
  const fs::path pipe = folder / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const int reader = ::open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  write_atomically(pipe, "text");
  char bytes[8] = {};
  EXPECT_EQ(::read(reader, bytes, sizeof bytes), 4);
  EXPECT_STREQ(bytes, "text");
  ::close(reader);
  EXPECT_TRUE(fs::is_fifo(pipe));
}

TEST_F(AtomicFile, WhatCannotBeReadIsAnInputError) {
  EXPECT_THROW(read_file(folder / "none"), InputError);
  EXPECT_THROW(read_text(folder), InputError) << "a folder";
}

}  // namespace
}  // namespace sanso::files
