// fork and exec with a death signal from the kernel; stopping is a polite signal first, then a
// hard one.
#include "tools/sanso/child_process.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "shared/files/atomic_file.h"
#include "shared/files/input_error.h"

namespace sanso::cli {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void become(const fs::path& program, std::vector<char*>& argv, int log, pid_t parent) {
  // Ctrl-C is for the host: robot and controller go on until it ends them
  ::setpgid(0, 0);
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);  // even when this program is killed
  if (::getppid() != parent) ::_exit(127);
  // nor is what is typed there: Enter is the controller's emergency stop
  const int nothing = ::open("/dev/null", O_RDONLY);
  ::dup2(nothing, STDIN_FILENO);
  ::dup2(log, STDOUT_FILENO);
  ::dup2(log, STDERR_FILENO);
  ::execv(program.c_str(), argv.data());
  const char* reason = std::strerror(errno);
  (void)!::write(STDERR_FILENO, reason, std::strlen(reason));
  ::_exit(127);
}

}  // namespace

ChildProcess::ChildProcess(const fs::path& program, const std::vector<std::string>& arguments,
                           const fs::path& log)
    : log_(log) {
  const int descriptor = ::open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (descriptor < 0)
    throw std::runtime_error(log.string() + ": cannot create: " + std::strerror(errno));
  std::vector<std::string> words{program.string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const pid_t parent = ::getpid();
  pid_ = ::fork();
  if (pid_ == 0) become(program, argv, descriptor, parent);
  const int error = errno;
  ::close(descriptor);
  if (pid_ < 0)
    throw std::runtime_error(program.string() + ": cannot start: " + std::strerror(error));
}

std::string ChildProcess::last_words() const {
  constexpr std::size_t kShown = 600;
  try {
    const std::string all = files::read_text(log_);
    return all.size() > kShown ? all.substr(all.size() - kShown) : all;
  } catch (const files::InputError&) {
    return "";
  }
}

bool ChildProcess::running() {
  if (pid_ > 0 && ::waitpid(pid_, nullptr, WNOHANG) == pid_) pid_ = -1;
  return pid_ > 0;
}

ChildProcess::~ChildProcess() {
  using namespace std::chrono_literals;
  if (!running()) return;
  ::kill(pid_, SIGTERM);
  for (int i = 0; i < 200 && running(); ++i) std::this_thread::sleep_for(10ms);
  if (!running()) return;
  ::kill(pid_, SIGKILL);
  ::waitpid(pid_, nullptr, 0);
}

fs::path find_program(const std::string& name) {
  const fs::path here = fs::read_symlink("/proc/self/exe").parent_path();
  if (fs::exists(here / name)) return here / name;
  // up to the top of a build tree
  for (fs::path up = here; up != up.parent_path(); up = up.parent_path())
    for (const fs::path& folder : {up / "firmware", up / "tools" / "emulator"})
      if (fs::is_regular_file(folder / name)) return folder / name;
  std::istringstream path(std::getenv("PATH") ? std::getenv("PATH") : "");
  for (std::string folder; std::getline(path, folder, ':');)
    if (!folder.empty() && fs::exists(fs::path(folder) / name)) return fs::path(folder) / name;
  throw std::runtime_error(name + ": not beside " + here.string() +
                           ", not in the build tree and not on the PATH; build or install it");
}

}  // namespace sanso::cli
