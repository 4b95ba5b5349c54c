// Picks the widest unit that the machine can run; few windows run one by one.
#include "tools/diagnose/sim/lane_simulation.h"

#include <memory>

#include "tools/diagnose/sim/follow_run.h"
#include "tools/diagnose/sim/window_run.h"

namespace sanso::diagnose {

#define SANSO_DECLARE_UNIT(isa)                                                   \
  namespace isa {                                                                 \
  void run_in_lanes(const SimFigures&, const WindowFigures*, std::size_t);        \
  void follow_in_lanes(const FollowFigures*, std::size_t, const FollowedJoints&); \
  void replay_in_lanes(const FollowFigures*, std::size_t, const FollowedJoints&); \
  }
SANSO_DECLARE_UNIT(baseline)
#ifdef SANSO_HAVE_X86_UNITS
SANSO_DECLARE_UNIT(avx2)
SANSO_DECLARE_UNIT(avx512)
#endif
#undef SANSO_DECLARE_UNIT

namespace {

void one_by_one(const SimFigures& figures, const WindowFigures* windows, std::size_t count) {
  const auto run = std::make_unique<portable::WindowRun<double>>(figures);
  for (std::size_t w = 0; w < count; ++w) run->run(windows + w, 1);
}

void follow_one_by_one(const FollowFigures* recordings, std::size_t count,
                       const FollowedJoints& joints) {
  for (std::size_t r = 0; r < count; ++r)
    std::make_unique<portable::FollowRun<double>>(recordings + r, 1, joints)->write_wanted();
}

void replay_one_by_one(const FollowFigures* recordings, std::size_t count,
                       const FollowedJoints& joints) {
  for (std::size_t r = 0; r < count; ++r)
    std::make_unique<portable::FollowRun<double>>(recordings + r, 1, joints)->write_torques();
}

constexpr LaneUnit kUnits[] = {
#ifdef SANSO_HAVE_X86_UNITS
    {"avx512", 8, avx512::run_in_lanes, avx512::follow_in_lanes, avx512::replay_in_lanes,
     [] {
       return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
              __builtin_cpu_supports("avx512vl");
     }},
    {"avx2", 4, avx2::run_in_lanes, avx2::follow_in_lanes, avx2::replay_in_lanes,
     [] { return __builtin_cpu_supports("avx2") != 0; }},
#endif
    {"baseline", 2, baseline::run_in_lanes, baseline::follow_in_lanes, baseline::replay_in_lanes,
     [] { return true; }},
    {"one by one", 1, one_by_one, follow_one_by_one, replay_one_by_one, [] { return true; }},
};

const LaneUnit& widest() {
  static const LaneUnit* const unit = [] {
    const LaneUnit* u = kUnits;
    while (!u->runs_here()) ++u;
    return u;
  }();
  return *unit;
}

}  // namespace

std::span<const LaneUnit> lane_units() { return kUnits; }

void run_windows(const SimFigures& figures, std::span<const WindowFigures> windows,
                 const LaneUnit* unit) {
  if (unit == nullptr) unit = windows.size() == 1 ? &lane_units().back() : &widest();
  unit->run(figures, windows.data(), windows.size());
}

namespace {
/// The narrowest of this machine with a lane for each.
const LaneUnit& narrowest(std::size_t recordings) {
  const LaneUnit* unit = &widest();
  for (const LaneUnit& u : lane_units()) {
    if (u.runs_here() && u.lanes >= recordings) unit = &u;
  }
  return *unit;
}
}  // namespace

void follow_recordings(std::span<const FollowFigures> recordings, const FollowedJoints& joints,
                       const LaneUnit* unit) {
  if (unit == nullptr) unit = &narrowest(recordings.size());
  unit->follow(recordings.data(), recordings.size(), joints);
}

void replay_recordings(std::span<const FollowFigures> recordings, const FollowedJoints& joints,
                       const LaneUnit* unit) {
  if (unit == nullptr) unit = &narrowest(recordings.size());
  unit->replay(recordings.data(), recordings.size(), joints);
}

}  // namespace sanso::diagnose
