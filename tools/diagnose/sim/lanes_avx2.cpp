// The simulation in lanes (lanes_unit.h), built with AVX2.
#define SANSO_ISA avx2
#define SANSO_LANES 4
#include "tools/diagnose/sim/lanes_unit.h"
