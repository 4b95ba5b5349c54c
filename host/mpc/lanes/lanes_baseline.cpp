// The lane kernels (lanes_unit.h) built for every machine: the instruction set is that of the
// build's baseline.
#define SANSO_ISA baseline
#include "host/mpc/lanes/lanes_unit.h"
