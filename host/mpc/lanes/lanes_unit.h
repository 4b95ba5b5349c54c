// Body of one instruction set's copy of all lane kernels. Include once in a .cpp that defines
// SANSO_ISA.
#include "host/mpc/lanes/backward_kernels.h"
#include "host/mpc/lanes/derivative_kernels.h"

#define SANSO_TEXT_OF(x) #x
#define SANSO_TEXT(x) SANSO_TEXT_OF(x)

namespace sanso::mpc::SANSO_ISA {

extern const LaneKernels kKernels;
const LaneKernels kKernels = {
    SANSO_TEXT(SANSO_ISA), &run_backward_pass, &line_inputs, &layer_inputs,
    &add_residual,         &add_cost,          &spread,      &finish_stage};

}  // namespace sanso::mpc::SANSO_ISA
