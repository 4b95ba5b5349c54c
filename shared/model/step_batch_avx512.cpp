// The batch step compiled for avx512 (compiler flags in CMakeLists.txt).
#define SANSO_ISA avx512
#define SANSO_LANES 8
#include "shared/model/kernel/batch_unit.h"
