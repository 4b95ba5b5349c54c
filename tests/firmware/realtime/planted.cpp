// Must not pass: a tick that allocates, four calls below. Shows that the check of function effects
// looks that deep.
#include "shared/base/realtime.h"

namespace {

struct Log {
  int* last = nullptr;
  void add(int value) { last = new int(value); }
};
void note(Log& log, int value) { log.add(value); }
void publish(Log& log) { note(log, 1); }

}  // namespace

void tick(Log& log) SANSO_REALTIME;
void tick(Log& log) SANSO_REALTIME { publish(log); }
