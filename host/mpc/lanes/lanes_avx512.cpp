#define SANSO_ISA avx512
#include "host/mpc/lanes/lanes_unit.h"
