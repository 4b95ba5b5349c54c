// A pty whose far end is reachable under a name; pulled out, it comes back under another number.
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <string>

namespace sanso::board::testing {

class Pty {
 public:
  explicit Pty(std::string link) : link_(std::move(link)) {}
  ~Pty() { pull(); }
  Pty(const Pty&) = delete;
  Pty& operator=(const Pty&) = delete;
  void plug() {
    pull();
    master_ = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK);
    ASSERT_GE(master_, 0);
    ASSERT_EQ(grantpt(master_), 0);
    ASSERT_EQ(unlockpt(master_), 0);
    char name[64];
    ASSERT_EQ(ptsname_r(master_, name, sizeof name), 0);
    ::unlink(link_.c_str());
    ASSERT_EQ(::symlink(name, link_.c_str()), 0);
  }
  void pull() {
    if (master_ >= 0) ::close(master_);
    master_ = -1;
    ::unlink(link_.c_str());
  }
  int master() const { return master_; }

 private:
  std::string link_;
  int master_ = -1;
};

}  // namespace sanso::board::testing
