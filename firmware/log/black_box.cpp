// One descriptor, one MCAP writer on top of it; a failure closes both and counts.
#include "firmware/log/black_box.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>
#include <vector>

#include "firmware/log/tick_messages.h"

namespace sanso::firmware {
namespace {

namespace fs = std::filesystem;

constexpr Nanoseconds kChunkTime = kSecond / 5;
constexpr Nanoseconds kFlushTime = kSecond;
constexpr Nanoseconds kRetryTime = 10 * kSecond;
constexpr std::string_view kSuffix = ".mcap";

[[noreturn]] void fail_with(const char* step) {
  throw std::system_error(errno, std::generic_category(), step);
}

/// A file that exists is never touched: O_EXCL.
int create(const fs::path& path) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0640);
  if (descriptor < 0) fail_with("cannot create");
  return descriptor;
}

/// Whether a black box wrote it: eight hexadecimal digits, a dash, a number.
bool is_ours(const fs::path& path) {
  const std::string name = path.filename().string();
  const auto digits = [](std::string_view text, std::string_view of) {
    return !text.empty() && text.find_first_not_of(of) == std::string_view::npos;
  };
  return name.size() > 9 + kSuffix.size() && name[8] == '-' && name.ends_with(kSuffix) &&
         digits(std::string_view(name).substr(0, 8), "0123456789abcdef") &&
         digits(std::string_view(name).substr(9, name.size() - 9 - kSuffix.size()), "0123456789");
}

}  // namespace

struct BlackBox::OpenFile {
  explicit OpenFile(const fs::path& path)
      : descriptor(create(path)), out([this](std::string_view bytes) { put(bytes); }) {}
  ~OpenFile() { ::close(descriptor); }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  void put(std::string_view bytes) const {
    while (!bytes.empty()) {
      const ssize_t n = ::write(descriptor, bytes.data(), bytes.size());
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) fail_with("cannot write");
      bytes.remove_prefix(static_cast<std::size_t>(n));
    }
  }
  void flush() const {
    if (::fdatasync(descriptor) != 0) fail_with("cannot flush to the disk");
  }

  int descriptor;
  mcap::Writer out;
  std::unique_ptr<TickMessages> messages;
  Nanoseconds begun = 0, chunk_begun = 0, flushed = 0;
  std::uint64_t in_chunk = 0;  // ticks that are lost when the next write fails
};

BlackBox::BlackBox(fs::path directory, std::string boot, BlackBoxLimits limits,
                   std::map<std::string, std::string> about)
    : directory_(std::move(directory)),
      boot_(std::move(boot)),
      limits_(limits),
      about_(std::move(about)) {}

BlackBox::~BlackBox() { close(); }

void BlackBox::take(const LogRecord& record) {
  if (directory_.empty()) return;
  const Nanoseconds now = record.observation.time;
  const bool pause = !open_ && !error_.empty() && now < retry_;
  if (pause) ++lost_here_;
  lost_ = lost_here_ + record.dropped;
  if (pause) return;
  try {
    if (!open_) open(now);
    ++open_->in_chunk;
    write_tick(record);
    error_.clear();
  } catch (const std::exception& failure) {
    fail(failure.what(), now);
  }
  lost_ = lost_here_ + record.dropped;
}

void BlackBox::write_tick(const LogRecord& record) {
  const Nanoseconds now = record.observation.time;
  OpenFile& file = *open_;
  file.messages->write(record, lost_);
  const bool news = record.observation.fault != fault_;
  fault_ = record.observation.fault;
  if (news || now - file.chunk_begun >= kChunkTime) {
    file.out.close_chunk();
    file.chunk_begun = now;
    file.in_chunk = 0;
  }
  if (now - file.flushed >= kFlushTime) {
    file.flush();
    file.flushed = now;
  }
  if (file.out.bytes() >= limits_.file_bytes || now - file.begun >= limits_.file_time) finish();
}

/// The number counts on from the largest that this boot has used.
void BlackBox::open(Nanoseconds now) {
  for (const fs::directory_entry& entry : fs::directory_iterator(directory_)) {
    const std::string name = entry.path().filename().string();
    if (is_ours(entry.path()) && name.starts_with(boot_ + "-"))
      number_ = std::max(number_, std::atoi(name.c_str() + boot_.size() + 1));
  }
  prune();
  const std::string digits = std::to_string(++number_);
  path_ =
      directory_ / (boot_ + "-" + std::string(4 - std::min<std::size_t>(4, digits.size()), '0') +
                    digits + std::string(kSuffix));
  open_ = std::make_unique<OpenFile>(path_);
  open_->out.add_metadata("sanso", about_);
  open_->messages = std::make_unique<TickMessages>(open_->out);
  open_->begun = open_->chunk_begun = open_->flushed = now;
}

/// Makes room for one more file by removing the oldest; never fails: a full disk says so itself.
void BlackBox::prune() const {
  struct Found {
    fs::file_time_type time;
    std::uint64_t bytes;
    fs::path path;
  };
  std::vector<Found> files;
  std::error_code ignored;
  std::uint64_t total = limits_.file_bytes;
  for (const fs::directory_entry& entry : fs::directory_iterator(directory_, ignored)) {
    if (!is_ours(entry.path()) || !entry.is_regular_file(ignored)) continue;
    files.push_back({entry.last_write_time(ignored), entry.file_size(ignored), entry.path()});
    total += files.back().bytes;
  }
  std::sort(files.begin(), files.end(),
            [](const Found& a, const Found& b) { return a.time < b.time; });
  for (const Found& file : files) {
    if (total <= limits_.keep_bytes) return;
    if (fs::remove(file.path, ignored)) total -= file.bytes;
  }
}

void BlackBox::finish() {
  open_->out.finish();
  open_->flush();
  open_.reset();
}

void BlackBox::close() {
  if (!open_) return;
  try {
    finish();
  } catch (const std::exception& failure) {
    fail(failure.what(), open_->chunk_begun);
  }
}

void BlackBox::fail(const std::string& why, Nanoseconds now) {
  error_ = (path_.empty() ? directory_ : path_).string() +
           ": the log of ticks cannot be written: " + why +
           "; ticks are lost; look at device.log_directory";
  lost_here_ += open_ ? open_->in_chunk : 1;
  open_.reset();
  retry_ = now + kRetryTime;
}

std::string boot_name() {
  std::string id;
  std::ifstream("/proc/sys/kernel/random/boot_id") >> id;
  return id.size() >= 8 ? id.substr(0, 8) : "00000000";
}

}  // namespace sanso::firmware
