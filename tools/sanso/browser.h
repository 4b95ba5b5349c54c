// A browser that nobody sees: chromium without a display and without a graphics card, in a folder
// of its own that goes with it.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "tools/sanso/child_process.h"

namespace sanso::cli {

/// `asked`, or the chromium that is installed. Throws std::runtime_error that names `option`.
std::filesystem::path find_browser(const std::filesystem::path& asked, const std::string& option);

class HeadlessBrowser {
 public:
  /// Opens `address`. Throws std::runtime_error when it does not start.
  HeadlessBrowser(const std::filesystem::path& program, const std::string& address);
  ~HeadlessBrowser();
  HeadlessBrowser(const HeadlessBrowser&) = delete;
  HeadlessBrowser& operator=(const HeadlessBrowser&) = delete;

  bool running() { return child_->running(); }
  /// The end of what it wrote.
  std::string last_words() const;

 private:
  std::filesystem::path folder_;
  std::unique_ptr<ChildProcess> child_;
};

}  // namespace sanso::cli
