// A program started by this one: its output goes to a file, and it ends with this program at the
// latest.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace sanso::cli {

class ChildProcess {
 public:
  /// Starts `program` with `arguments`; its standard output and error go to `log`. Throws
  /// std::runtime_error.
  ChildProcess(const std::filesystem::path& program, const std::vector<std::string>& arguments,
               const std::filesystem::path& log);
  /// Asks it to end (SIGTERM), kills it after two seconds.
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  pid_t pid() const { return pid_; }
  /// False once it has ended by itself.
  bool running();
  /// The end of what it printed, for an error message; empty before it printed anything.
  std::string last_words() const;

 private:
  pid_t pid_ = -1;
  std::filesystem::path log_;
};

/// The program `name` beside this executable, in a sibling folder of the build tree, or on the
/// PATH. Throws std::runtime_error naming where it looked.
std::filesystem::path find_program(const std::string& name);

}  // namespace sanso::cli
