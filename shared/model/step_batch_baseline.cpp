// The batch step compiled for baseline (compiler flags in CMakeLists.txt).
#define SANSO_ISA baseline
#define SANSO_LANES 2
#include "shared/model/kernel/batch_unit.h"
