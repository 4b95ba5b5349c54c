// The lane kernels (lanes_unit.h) built with AVX-512; called only where the processor has it.
#define SANSO_ISA avx512
#include "host/mpc/lanes/lanes_unit.h"
