// Body of one instruction set's copy of the simulation. Include once in a .cpp that defines
// SANSO_ISA and SANSO_LANES, how many windows it runs in step.
#include "tools/diagnose/sim/window_run.h"

namespace sanso::diagnose::SANSO_ISA {

void run_in_lanes(const SimFigures& figures, const WindowFigures* windows, std::size_t count);
void run_in_lanes(const SimFigures& figures, const WindowFigures* windows, std::size_t count) {
  constexpr std::size_t kWide = SANSO_LANES;
  WindowRun<Pack<SANSO_LANES>> run(figures);
  for (std::size_t w = 0; w < count; w += kWide)
    run.run(windows + w, count - w < kWide ? count - w : kWide);
}

}  // namespace sanso::diagnose::SANSO_ISA
