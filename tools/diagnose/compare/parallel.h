// Independent tasks on all cores, ended by Ctrl-C. The result never depends on the number of
// threads: every task writes its own slot.
#pragma once

#include <cstddef>
#include <functional>

#include "shared/files/parallel.h"

namespace sanso::diagnose {

/// Raised between tasks when the user interrupted (Ctrl-C); see request_stop().
using Interrupted = files::Stopped;

/// Runs task(0) .. task(count - 1) on all cores and waits. The first exception is rethrown. Throws
/// Interrupted.
void parallel_for(std::size_t count, const std::function<void(std::size_t)>& task);

/// Asks running searches to end at the next task. Safe inside a signal handler.
void request_stop();
/// Whether request_stop was called.
bool stop_requested();

}  // namespace sanso::diagnose
