// The batch step compiled for avx2 (compiler flags in CMakeLists.txt).
#define SANSO_ISA avx2
#define SANSO_LANES 4
#include "shared/model/kernel/batch_unit.h"
