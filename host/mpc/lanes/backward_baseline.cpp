#define SANSO_ISA baseline
#include "host/mpc/lanes/backward_kernels.h"

namespace sanso::mpc::baseline {
BackwardSummary backward_pass(const BackwardInput& in, const BackwardOutput& out, Value& value) {
  return run_backward_pass(in, out, value);
}
}  // namespace sanso::mpc::baseline
