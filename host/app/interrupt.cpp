// The signal handler only sets a flag; the second signal finds the default action restored.
#include "host/app/interrupt.h"

#include <unistd.h>

namespace sanso::app {
namespace {

volatile std::sig_atomic_t interrupted = 0;
int alive = 0;

void note_interrupt(int) {
  static constexpr char kText[] =
      "\nfinishing this trial; Ctrl-C again stops at once "
      "(a robot then ends in a hold by itself)\n";
  interrupted = 1;
  (void)!::write(STDERR_FILENO, kText, sizeof kText - 1);
}

}  // namespace

Interrupt::Interrupt() {
  if (alive++ > 0) return;
  interrupted = 0;
  struct sigaction action {};
  action.sa_handler = note_interrupt;
  action.sa_flags = static_cast<int>(SA_RESETHAND);  // the second one does what it always does
  sigemptyset(&action.sa_mask);
  ::sigaction(SIGINT, &action, &before_int_);
  ::sigaction(SIGTERM, &action, &before_term_);
}

Interrupt::~Interrupt() {
  if (--alive > 0) return;
  ::sigaction(SIGINT, &before_int_, nullptr);
  ::sigaction(SIGTERM, &before_term_, nullptr);
}

bool Interrupt::requested() { return interrupted != 0; }

}  // namespace sanso::app
