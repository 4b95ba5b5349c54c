// What the tick thread asks of Linux: memory that stays, a priority that nobody ordinary
// interrupts.
#pragma once

#include <string>

namespace sanso::board {

/// Locks all memory, now and later, and touches the stack. Empty, or a clear message why it may
/// not.
std::string lock_memory();
/// Makes the calling thread SCHED_FIFO with this priority. Empty, or a clear message why it may
/// not.
std::string set_realtime_priority(int priority);

}  // namespace sanso::board
