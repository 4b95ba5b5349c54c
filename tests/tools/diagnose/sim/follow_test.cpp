// Which recordings are followed in step. What they remember there is what they remember alone:
// effects_in_lanes_test.cpp, for every effect.
#include "tools/diagnose/sim/follow.h"

#include <gtest/gtest.h>

#include "tests/support/small_world.h"

namespace sanso::diagnose {
namespace {

/// Indices of recordings of three robots, the second and third changed by `change`, by group.
template <class Change>
std::vector<std::vector<std::size_t>> groups(const Change& change) {
  const ModelFolder model = test::arm("actuator = \"position_pd\"\nkp = 20\nkd = 1\n");
  const Drive drive = test::make_test_drive(model, 1.0, 0.01, [](int, double) { return 0.0; });
  const std::vector<Window> windows{test::whole_from_rest(drive)};
  std::vector<SimParams> robots(3, make_params(model));
  change(robots[1]);
  change(robots[2]);
  const MeasuredMotion motion;
  std::vector<Followed> all;
  for (const SimParams& robot : robots) all.push_back({&robot, &drive, &motion, windows});
  return in_step(all);
}

TEST(Follow, RecordingsAreInStepWhereRobotsAreOneButForGainsAndBodies) {
  using Groups = std::vector<std::vector<std::size_t>>;
  const Groups one{{0, 1, 2}}, two{{0}, {1, 2}};
  EXPECT_EQ(groups([](SimParams&) {}), one);
  EXPECT_EQ(groups([](SimParams& p) { p.joints[1].nominal.kp *= 2.0; }), one);
  EXPECT_EQ(groups([](SimParams& p) { p.joints[1].p_scale = 2.0; }), two);
  EXPECT_EQ(groups([](SimParams& p) { p.joints[1].integral_rate = 0.5; }), two);
  EXPECT_EQ(groups([](SimParams& p) { p.tree.joints[2].body.mass *= 1.1; }), one);
  EXPECT_EQ(groups([](SimParams& p) { p.late_payloads.push_back({2, {}, 0.5}); }), one);
  EXPECT_EQ(groups([](SimParams& p) { p.tree.joints[2].axis = {1, 0, 0}; }), two);
  EXPECT_EQ(groups([](SimParams& p) { p.forces.push_back({1, {1, 0, 0}}); }), two);
  EXPECT_EQ(groups([](SimParams& p) { p.joints[0].derating = 0.01; }), (Groups{{0}, {1}, {2}}))
      << "temperatures are each recording's own";
}

}  // namespace
}  // namespace sanso::diagnose
