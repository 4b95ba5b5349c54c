// What may run in the tick: no heap, no lock, no exception, nothing that waits. Written behind a
// function's declaration, the word makes a compiler that knows it (clang from 20 on) look: when it
// compiles with -Wfunction-effects, and at run time under -fsanitize=realtime
// (tests/firmware/realtime). Everything that such a function calls is looked at with it.
#pragma once

#if defined(__clang__) && defined(__has_cpp_attribute)
#if __has_cpp_attribute(clang::nonblocking)
#define SANSO_REALTIME [[clang::nonblocking]]
#endif
#endif
#ifndef SANSO_REALTIME
#define SANSO_REALTIME
#endif
