// Body of one instruction set's copy of the simulation. Include once in a .cpp that defines
// SANSO_ISA and SANSO_LANES, how many windows or recordings it runs in step.
#include "tools/diagnose/sim/follow_run.h"
#include "tools/diagnose/sim/window_run.h"

namespace sanso::diagnose::SANSO_ISA {

void run_in_lanes(const SimFigures& figures, const WindowFigures* windows, std::size_t count);
void run_in_lanes(const SimFigures& figures, const WindowFigures* windows, std::size_t count) {
  constexpr std::size_t kWide = SANSO_LANES;
  WindowRun<Pack<SANSO_LANES>> run(figures);
  for (std::size_t w = 0; w < count; w += kWide)
    run.run(windows + w, count - w < kWide ? count - w : kWide);
}

void follow_in_lanes(const FollowFigures* recordings, std::size_t count,
                     const FollowedJoints& joints);
void follow_in_lanes(const FollowFigures* recordings, std::size_t count,
                     const FollowedJoints& joints) {
  constexpr std::size_t kWide = SANSO_LANES;
  for (std::size_t r = 0; r < count; r += kWide) {
    FollowRun<Pack<SANSO_LANES>> run(recordings + r, count - r < kWide ? count - r : kWide, joints);
    run.write_wanted();
  }
}

void replay_in_lanes(const FollowFigures* recordings, std::size_t count,
                     const FollowedJoints& joints);
void replay_in_lanes(const FollowFigures* recordings, std::size_t count,
                     const FollowedJoints& joints) {
  constexpr std::size_t kWide = SANSO_LANES;
  for (std::size_t r = 0; r < count; r += kWide) {
    FollowRun<Pack<SANSO_LANES>> run(recordings + r, count - r < kWide ? count - r : kWide, joints);
    run.write_torques();
  }
}

}  // namespace sanso::diagnose::SANSO_ISA
