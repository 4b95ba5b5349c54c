// Every process shows the files that it has open as links in /proc/PID/fd.
#include "firmware/board/holders.h"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>

namespace sanso::board {
namespace {

namespace fs = std::filesystem;

bool is_number(const std::string& text) {
  return !text.empty() && std::all_of(text.begin(), text.end(),
                                      [](unsigned char c) { return std::isdigit(c) != 0; });
}

bool has_open(const fs::path& process, const fs::path& device) {
  std::error_code denied;
  for (const auto& fd : fs::directory_iterator(process / "fd", denied))
    if (fs::read_symlink(fd.path(), denied) == device) return true;
  return false;
}

std::string name_of(const fs::path& process) {
  std::ifstream in(process / "comm");
  std::string name;
  std::getline(in, name);
  return name;
}

}  // namespace

std::string holders_of(const std::string& device) {
  std::error_code error;
  const fs::path real = fs::canonical(device, error);
  if (error) return {};
  std::string holders;
  for (const auto& entry : fs::directory_iterator("/proc", error)) {
    const std::string number = entry.path().filename().string();
    if (!is_number(number) || number == std::to_string(::getpid())) continue;
    if (!has_open(entry.path(), real)) continue;
    holders += (holders.empty() ? "" : ", ") + number + " (" + name_of(entry.path()) + ")";
  }
  return holders;
}

}  // namespace sanso::board
