// Lists the tables of kernels that this processor can run, widest first.
#include "host/mpc/lane_kernels.h"

#include <cstring>

#include "shared/model/step_batch.h"

namespace sanso::mpc {

namespace baseline {
extern const LaneKernels kKernels;
}
#ifdef SANSO_HAVE_X86_UNITS
namespace avx2 {
extern const LaneKernels kKernels;
}
namespace avx512 {
extern const LaneKernels kKernels;
}
#endif

int available_lane_kernels(const LaneKernels** out, int capacity) {
  int n = 0;
  const auto add = [&](const LaneKernels& kernels) {
    if (n < capacity) out[n++] = &kernels;
  };
#ifdef SANSO_HAVE_X86_UNITS
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw"))
    add(avx512::kKernels);
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) add(avx2::kKernels);
#endif
  add(baseline::kKernels);
  return n;
}

const LaneKernels& lane_kernels() {
  const LaneKernels* list[3];
  const int count = available_lane_kernels(list, 3);
  for (int i = 0; i < count; ++i)
    if (std::strcmp(list[i]->name, model::batch_isa()) == 0) return *list[i];
  return *list[count - 1];
}

}  // namespace sanso::mpc
