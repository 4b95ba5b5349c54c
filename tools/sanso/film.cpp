// The browser gets the page from a server of this program on loopback and brings the film back
// there; it ends with the film.
#include "tools/sanso/film.h"

#include <fmt/format.h>

#include <chrono>
#include <condition_variable>
#include <mutex>

#include "shared/files/atomic_file.h"
#include "tools/page/embedded/bundle.h"
#include "tools/page/server.h"
#include "tools/sanso/browser.h"

namespace sanso::cli {
namespace {

namespace fs = std::filesystem;
constexpr auto kSilence = std::chrono::minutes(5);  // drawing by software on a crowded machine
constexpr auto kLook = std::chrono::milliseconds(200);

/// What the page has sent so far.
class Delivery {
 public:
  void take(const std::string& name, std::string body) {
    const std::lock_guard lock(mutex_);
    heard_ = std::chrono::steady_clock::now();
    if (name == "progress") progress_ = body;
    if (name == "failed") failure_ = std::move(body);
    if (name == "done") film_ = std::move(body), done_ = true;
    news_.notify_all();
  }
  /// The film. Throws when it fails, `alive` says no, or nothing has come for long.
  template <class Alive>
  std::string wait(Alive alive) {
    std::unique_lock lock(mutex_);
    std::string shown;
    while (!done_ && failure_.empty()) {
      news_.wait_for(lock, kLook);
      if (progress_ != shown) fmt::print(stderr, "\rdrawing: {} %", shown = progress_);
      if (!done_ && !alive()) throw std::runtime_error("the browser ended");
      if (std::chrono::steady_clock::now() - heard_ > kSilence)
        throw std::runtime_error("the browser has drawn nothing for five minutes");
    }
    if (!shown.empty()) fmt::print(stderr, "\n");
    if (!failure_.empty()) throw std::runtime_error("the page could not draw: " + failure_);
    return std::move(film_);
  }

 private:
  std::mutex mutex_;
  std::condition_variable news_;
  std::chrono::steady_clock::time_point heard_ = std::chrono::steady_clock::now();
  std::string progress_, failure_, film_;
  bool done_ = false;
};

}  // namespace

std::string film_kind(const fs::path& out) {
  for (const char* kind : {"png", "gif", "webm"})
    if (out.extension() == std::string(".") + kind) return kind;
  throw std::runtime_error("--film " + out.string() +
                           ": expected a name that ends in .webm, .gif or .png");
}

void make_film(const fs::path& folder, const report::FilmOptions& options, const fs::path& browser,
               const fs::path& out) {
  if (page::bundle().empty()) throw std::runtime_error(page::kNoBundle);
  const fs::path program = find_browser(browser, "--film");
  Delivery delivery;
  page::ServerContents contents;
  contents.greeting = [] { return std::vector<std::string>(); };
  contents.page = report::film_page_of(folder, options);
  contents.take = [&](const std::string& name, std::string body) {
    delivery.take(name, std::move(body));
  };
  const page::Server server(0, std::move(contents));
  HeadlessBrowser drawing(program, server.address());
  try {
    files::write_atomically(out, delivery.wait([&] { return drawing.running(); }));
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(
        fmt::format("{}: {}\n{}", program.string(), error.what(), drawing.last_words()));
  }
}

}  // namespace sanso::cli
