// Which figures have a part in what a robot remembers. That those said to have none change no bit:
// effects_in_lanes_test.cpp, for every pair of effects.
#include "tools/diagnose/sim/memory.h"

#include <gtest/gtest.h>

#include "tests/support/small_world.h"

namespace sanso::diagnose {
namespace {

using Change = void (*)(SimParams&);

/// An arm of servos that remembers by `memory` is the same to its memory after `change`.
bool alike(Change memory, Change change) {
  const ModelFolder model = test::arm("actuator = \"position_pd\"\nkp = 20\nkd = 1\n");
  SimParams a = make_params(model);
  memory(a);
  SimParams b = a;
  change(b);
  return remember_alike(a, b);
}

void slips(SimParams& p) { p.joints[0].slip_torque = 0.1, p.joints[0].slip_stiffness = 50.0; }
void bends(SimParams& p) { p.joints[0].presliding_compliance = 0.2; }
void has_play(SimParams& p) { p.joints[0].backlash = 0.01; }
void integrates(SimParams& p) { p.joints[0].integral_rate = 0.5; }

void mass(SimParams& p) { p.tree.joints[2].body.mass *= 1.1; }
void viscous(SimParams& p) { p.joints[0].viscous = 0.1; }
void coulomb(SimParams& p) { p.joints[0].coulomb = 0.1; }
void load_friction(SimParams& p) { p.joints[0].load_friction = 0.1; }
void spring(SimParams& p) { p.joints[0].spring = 0.3; }
void gain(SimParams& p) { p.joints[0].p_scale = 1.2; }
void encoder(SimParams& p) { p.joints[0].encoder_offset = 0.01; }
void record(SimParams& p) { p.joints[0].record_offset = 0.01; }

TEST(Memory, SlipAndRestFollowTheMotionAlone) {
  for (const Change c : {mass, viscous, coulomb, load_friction, spring})
    EXPECT_TRUE(alike(slips, c));
  for (const Change c : {encoder, record})
    EXPECT_FALSE(alike(slips, c)) << "the motion is what the encoder shows";
}

TEST(Memory, BristlesBendToDryFriction) {
  for (const Change c : {mass, viscous, spring}) EXPECT_TRUE(alike(bends, c));
  for (const Change c : {coulomb, load_friction, encoder}) EXPECT_FALSE(alike(bends, c));
}

TEST(Memory, PlayMovesWithEverythingButWhatActsOnTheLink) {
  EXPECT_TRUE(alike(has_play, spring));
  for (const Change c : {mass, viscous, coulomb, gain}) EXPECT_FALSE(alike(has_play, c));
}

TEST(Memory, AnIntegralBeginsWithWhatHoldsThePosture) {
  for (const Change c : {viscous, coulomb, spring}) EXPECT_TRUE(alike(integrates, c));
  for (const Change c : {mass, gain, encoder}) EXPECT_FALSE(alike(integrates, c));
}

TEST(Memory, IsNotComparedWhereCurrentsHaveAPart) {
  const auto nothing = [](SimParams&) {};
  EXPECT_FALSE(alike([](SimParams& p) { p.supply_resistance = 0.2; }, nothing));
  EXPECT_FALSE(alike([](SimParams& p) { p.joints[1].derating = 0.01; }, nothing));
}

}  // namespace
}  // namespace sanso::diagnose
