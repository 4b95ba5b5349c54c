#include "host/mpc/backward_pass.h"

namespace sanso::mpc {

namespace baseline {
BackwardSummary backward_pass(const BackwardInput&, const BackwardOutput&, Value&);
}
#if defined(__x86_64__)
namespace avx2 {
BackwardSummary backward_pass(const BackwardInput&, const BackwardOutput&, Value&);
}
namespace avx512 {
BackwardSummary backward_pass(const BackwardInput&, const BackwardOutput&, Value&);
}
#endif

int available_backward_passes(NamedBackwardPass* out, int capacity) {
  int n = 0;
  const auto add = [&](const char* name, BackwardPassFn run) {
    if (n < capacity) out[n++] = {name, run};
  };
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
    add("avx512", &avx512::backward_pass);
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) add("avx2", &avx2::backward_pass);
#endif
  add("baseline", &baseline::backward_pass);
  return n;
}

BackwardPassFn backward_pass() {
  NamedBackwardPass best[3];
  available_backward_passes(best, 3);
  return best[0].run;
}

}  // namespace sanso::mpc
