// Independent tasks on all cores. The result never depends on the number of threads: every task
// writes its own slot.
#pragma once

#include <functional>

namespace sanso::diagnose {

/// Runs task(0) .. task(count - 1) on up to hardware_concurrency threads and waits. The first
/// exception is rethrown.
void parallel_for(int count, const std::function<void(int)>& task);

/// Raised between tasks when the user interrupted (Ctrl-C); see request_stop().
struct Interrupted {};

/// Asks running searches to end at the next task. Safe inside a signal handler.
void request_stop();
bool stop_requested();

}  // namespace sanso::diagnose
