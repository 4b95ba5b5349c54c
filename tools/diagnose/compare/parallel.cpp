// The one stop request of a diagnosis, and the loop that listens to it.
#include "tools/diagnose/compare/parallel.h"

namespace sanso::diagnose {
namespace {

files::StopRequest stop;

}  // namespace

void request_stop() { stop.request(); }
bool stop_requested() { return stop.requested(); }

void parallel_for(int count, const std::function<void(int)>& task) {
  const auto pieces = static_cast<std::size_t>(count < 0 ? 0 : count);
  const auto work = [&](std::size_t i) { task(static_cast<int>(i)); };
  files::parallel_for(pieces, files::all_cores(), work, &stop);
}

}  // namespace sanso::diagnose
