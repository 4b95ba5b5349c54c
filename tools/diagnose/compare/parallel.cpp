// The one stop request of a diagnosis, and the loop that listens to it.
#include "tools/diagnose/compare/parallel.h"

namespace sanso::diagnose {
namespace {

files::StopRequest stop;

}  // namespace

void request_stop() { stop.request(); }
bool stop_requested() { return stop.requested(); }

void parallel_for(std::size_t count, const std::function<void(std::size_t)>& task) {
  files::parallel_for(count, files::all_cores(), task, &stop);
}

}  // namespace sanso::diagnose
