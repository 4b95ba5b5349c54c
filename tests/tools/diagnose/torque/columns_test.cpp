// Torques know which column is which: a flipped sign, exchanged joints and a late clock are told
// from every robot that is only not the nominal one.
#include "tools/diagnose/torque/columns.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/noisy_world.h"

namespace sanso::diagnose {
namespace {

using namespace test;

constexpr const char* kTorque =
    "actuator = \"torque\"\ntorque_limit = 0.0\nviscous = 0.05\ncoulomb = 0.04\n"
    "armature = 0.005\nposition_noise = 0.0003\n";

/// What the check says of a recording of `world`, after `spoil`, with the nominal `model`.
template <class Spoil>
std::vector<Defect> checked(const ModelFolder& model, const ModelFolder& world, Spoil&& spoil) {
  std::vector<recording::Recording> all = recordings_of(world, 2, 12.0, 7);
  for (recording::Recording& r : all) spoil(r);
  const Settings settings;
  return check_columns(make_sources(model, all, noise_of(model), settings), settings);
}

const auto kAsItIs = [](recording::Recording&) {};

std::vector<double> values(const recording::Recording& r, const std::string& column) {
  const auto x = r.find(column);
  return {x.begin(), x.end()};
}

void expect_all(const std::vector<Defect>& found, const std::string& kind,
                const std::string& channel) {
  ASSERT_EQ(found.size(), 2u);
  for (const Defect& d : found) {
    EXPECT_EQ(d.defect, kind) << d.message;
    EXPECT_EQ(d.channel, channel) << d.message;
  }
}

TEST(Columns, SoundRecordingsPassWhateverTheRobotLacks) {
  for (const ModelFolder& model : {pendulum(kTorque), two_links(kTorque), arm(kTorque)}) {
    const std::string first = model.tree.joints.front().name;
    EXPECT_TRUE(checked(model, model, kAsItIs).empty());
    for (const EffectEntry& missing : {hidden("viscous_friction", first, {{"viscous", 0.3}}),
                                       hidden("coulomb_friction", first, {{"coulomb", 0.3}}),
                                       hidden("command_delay", first, {{"delay", 0.05}}),
                                       hidden("cable_spring", first, {{"stiffness", 0.8}})})
      EXPECT_TRUE(checked(model, hiding(model, {missing}), kAsItIs).empty()) << missing.id;
  }
}

TEST(Columns, FlippedSign) {
  const ModelFolder model = two_links(kTorque);
  for (const std::string joint : {"a", "b"}) {
    expect_all(checked(model, model,
                       [&](recording::Recording& r) {
                         std::vector<double> q = values(r, "q:" + joint);
                         for (double& x : q) x = -x;
                         r.set("q:" + joint, q);
                       }),
               defect::kWrongSign, "q:" + joint);
  }
}

TEST(Columns, ExchangedJoints) {
  const ModelFolder model = two_links(kTorque);
  expect_all(checked(model, model,
                     [](recording::Recording& r) {
                       const std::vector<double> a = values(r, "q:a"), b = values(r, "q:b");
                       r.set("q:a", b);
                       r.set("q:b", a);
                     }),
             defect::kSwapped, "q:a");
}

TEST(Columns, PositionsOfAnotherTime) {
  const ModelFolder model = pendulum(kTorque);
  for (const long rows : {25L, -30L}) {
    expect_all(checked(model, model,
                       [&](recording::Recording& r) {
                         std::vector<double> q = values(r, "q:a");
                         std::rotate(q.begin(), rows > 0 ? q.end() - rows : q.begin() - rows,
                                     q.end());
                         r.set("q:a", q);
                       }),
               defect::kShiftedClock, "q:a");
  }
}

}  // namespace
}  // namespace sanso::diagnose
