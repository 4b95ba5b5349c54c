// The simulation in lanes (lanes_unit.h), built with AVX-512.
#define SANSO_ISA avx512
#define SANSO_LANES 8
#include "tools/diagnose/sim/lanes_unit.h"
