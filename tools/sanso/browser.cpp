// How chromium is called; what it keeps lies in a folder that is removed with it.
#include "tools/sanso/browser.h"

#include <unistd.h>

#include <stdexcept>
#include <vector>

namespace sanso::cli {
namespace {

namespace fs = std::filesystem;

fs::path temporary_folder() {
  std::string name = (fs::temp_directory_path() / "sanso_browser_XXXXXX").string();
  if (!mkdtemp(name.data())) throw std::runtime_error(name + ": cannot create");
  return name;
}

}  // namespace

fs::path find_browser(const fs::path& asked, const std::string& option) {
  if (!asked.empty()) {
    if (!fs::exists(asked)) throw std::runtime_error("--browser " + asked.string() + ": not there");
    return asked;
  }
  for (const char* name : {"chromium", "chromium-browser", "google-chrome", "google-chrome-stable"})
    try {
      return find_program(name);
    } catch (const std::runtime_error&) {  // the next one
    }
  throw std::runtime_error(option +
                           " needs chromium, which draws without a display: install the package "
                           "chromium, or name another with --browser");
}

HeadlessBrowser::HeadlessBrowser(const fs::path& program, const std::string& address)
    : folder_(temporary_folder()) {
  std::vector<std::string> arguments{
      "--headless=new",         "--user-data-dir=" + folder_.string(),
      "--no-first-run",         "--disable-extensions",
      "--use-gl=angle",         "--use-angle=swiftshader",
      "--ignore-gpu-blocklist", "--enable-unsafe-swiftshader",
      "--mute-audio",           "--disable-dev-shm-usage",
      "--disable-gpu-vsync",    "--force-device-scale-factor=1"};
  // its sandbox refuses to be root's; it shows nothing but the page that it is given
  if (::geteuid() == 0) arguments.emplace_back("--no-sandbox");
  arguments.push_back(address);
  child_ = std::make_unique<ChildProcess>(program, arguments, folder_ / "browser.log");
}

HeadlessBrowser::~HeadlessBrowser() {
  child_.reset();
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

std::string HeadlessBrowser::last_words() const { return child_->last_words(); }

}  // namespace sanso::cli
