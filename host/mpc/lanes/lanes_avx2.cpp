// The lane kernels (lanes_unit.h) built with AVX2 and FMA; called only where the processor has
// them.
#define SANSO_ISA avx2
#include "host/mpc/lanes/lanes_unit.h"
