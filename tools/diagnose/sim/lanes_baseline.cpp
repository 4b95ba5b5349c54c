// The simulation in lanes (lanes_unit.h), built with what every processor of its kind has.
#define SANSO_ISA baseline
#define SANSO_LANES 2
#include "tools/diagnose/sim/lanes_unit.h"
