#define SANSO_ISA baseline
#include "host/mpc/lanes/lanes_unit.h"
