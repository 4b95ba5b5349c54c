#define SANSO_ISA avx2
#include "host/mpc/lanes/lanes_unit.h"
