#define SANSO_ISA avx512
#include "host/mpc/lanes/backward_kernels.h"

namespace sanso::mpc::avx512 {
BackwardSummary backward_pass(const BackwardInput& in, const BackwardOutput& out, Value& value) {
  return run_backward_pass(in, out, value);
}
}  // namespace sanso::mpc::avx512
