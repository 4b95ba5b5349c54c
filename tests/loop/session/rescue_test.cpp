// A robot that falls before its trial: the session goes on, keeps what it saw and learns from it.
#include <cmath>
#include <functional>

#include "firmware/exchange/faults.h"
#include "host/learn/model/prediction.h"
#include "host/learn/session/bring_up.h"
#include "tests/loop/support/loop_fixture.h"
#include "tests/support/temp_folder.h"

namespace sanso::loop {
namespace {

static_assert(learn::kFaultFallen == static_cast<std::uint16_t>(firmware::Fault::fallen));

/// Throws the robot over its heels while it holds its first pose.
class Pushing : public inprocess::InProcessAccess {
 public:
  Pushing() : InProcessAccess("lab") {}
  link::RobotLink& place(const model::State& x, std::uint64_t seed) override {
    link::RobotLink& link = InProcessAccess::place(x, seed);
    const Nanoseconds begin = robot().now() + from_seconds(2.0);  // of a hold from 1 s to 2.5 s
    robot().robot().push({-40.0, 0.0, 0.0}, {}, begin, begin + 100 * kMillisecond);
    return link;
  }
};

void expect_one_tick_apart(const std::vector<wire::Observation>& seen) {
  for (std::size_t i = 1; i < seen.size(); ++i) EXPECT_EQ(seen[i].tick, seen[i - 1].tick + 1);
}

TEST(Rescue, AFallBeforeTheTrialIsToldWithWhatWasSeen) {
  Loop loop("stand");
  Pushing robot;
  link::RobotLink& link = robot.place(loop.reference.front(), 1);
  try {
    learn::prepare_trial(link, loop.setup, loop.settings);
    FAIL() << "the premise: this robot falls";
  } catch (const learn::FellBefore& fell) {
    ASSERT_GT(fell.preparation.seen.size(), 40u);
    expect_one_tick_apart(fell.preparation.seen);
    EXPECT_LT(learn::tilt_of(fell.preparation.seen.front().x), 0.1);
    EXPECT_GT(learn::tilt_of(fell.preparation.seen.back().x), 0.5);
  }
}

TEST(Rescue, ASessionThatOnlyFallsLearnsAfterThreeTrials) {
  const test::TempFolder temporary;
  const motion::Motion stand = motion::MotionLibrary().load("stand");
  learn::Task task{"stand", stand.primitives, stand.weights, {}};
  Pushing robot;
  mpc::UpperLayer upper(mpc::MpcSettings{}, host::AugmentedModel{});
  learn::SessionSettings settings;
  settings.iterations = 3;
  settings.bring_up.on = false;  // it would be pushed there too
  settings.out = temporary.path() / "session";
  learn::Session session(task, settings, robot, upper);
  std::vector<std::uint32_t> rounds;
  session.run([&](const learn::TrialSummary&) { rounds.push_back(session.state().model_rounds); });
  EXPECT_EQ(rounds, (std::vector<std::uint32_t>{0, 0, 1}));
  for (const learn::TrialSummary& t : session.state().history) {
    EXPECT_EQ(t.end, learn::TrialEnd::fell_before);
    EXPECT_GE(t.cost, settings.trial.cost_limit) << "a fall is never the cheapest trial";
    EXPECT_LT(t.model_loss, 0.0) << "no window of N steps: the loss is not known";
  }
  EXPECT_GT(learn::load_episode(settings.out / "trial_0001.episode").before.size(), 40u);
}

using AfterTrial = std::function<void(const learn::Session&)>;

/// Three trials of a session that stands in `lab` without bring-up and never fails.
std::vector<learn::TrialSummary> stood(
    learn::SessionSettings settings, const AfterTrial& after = [](const learn::Session&) {}) {
  const test::TempFolder temporary;
  const motion::Motion stand = motion::MotionLibrary().load("stand");
  learn::Task task{"stand", stand.primitives, stand.weights, {}};
  inprocess::InProcessAccess robot("lab");
  mpc::UpperLayer upper(mpc::MpcSettings{}, host::AugmentedModel{});
  settings.iterations = 3;
  settings.bring_up.on = false;
  settings.out = temporary.path() / "session";
  learn::Session session(task, settings, robot, upper);
  session.run([&](const learn::TrialSummary&) { after(session); });
  for (const learn::TrialSummary& t : session.state().history) EXPECT_FALSE(t.failed());
  return session.state().history;
}

/// Rounds of model learning after each of them.
std::vector<std::uint32_t> rounds_of_standing(int first_after) {
  learn::SessionSettings settings;
  settings.learn_first_after = first_after;
  settings.model.identify.search.generations = 2;  // whether, not how well
  std::vector<std::uint32_t> rounds;
  stood(settings, [&](const learn::Session& s) { rounds.push_back(s.state().model_rounds); });
  return rounds;
}

/// A robot whose feet do not leave the floor completes its trials: only from outside they fail.
TEST(Rescue, ARobotThatCompletesItsTrialsLearnsAfterTheFirstFew) {
  EXPECT_EQ(rounds_of_standing(2), (std::vector<std::uint32_t>{0, 1, 1}));
  EXPECT_EQ(rounds_of_standing(0), (std::vector<std::uint32_t>{0, 0, 0}));
  EXPECT_EQ(learn::SessionSettings{}.learn_first_after, 3);
}

std::vector<learn::TrialSummary> standing_unlearned(bool sigma_by_trials) {
  learn::SessionSettings settings;
  settings.learn_model_every = 0;
  settings.sigma_by_trials = sigma_by_trials;
  return stood(settings);
}

TEST(Rescue, TheNoiseAmplitudeFollowsWhatTheLastTrialShowed) {
  const std::vector<learn::TrialSummary> follows = standing_unlearned(true),
                                         stays = standing_unlearned(false);
  ASSERT_EQ(follows.size(), 3U);
  ASSERT_EQ(stays.size(), 3U);
  EXPECT_EQ(follows[0].sigma, learn::kSigmaStart);
  for (const std::size_t i : {1, 2}) {
    EXPECT_EQ(follows[i].sigma, learn::sigma_of_loss(follows[i - 1].model_loss));
    EXPECT_EQ(stays[i].sigma, learn::kSigmaStart);
  }
}

learn::TrialSummary ended(learn::TrialEnd end, double lifted_share) {
  learn::TrialSummary trial;
  trial.end = end;
  trial.lifted_share = lifted_share;
  return trial;
}

/// A planner that would rather drag a foot than pay for lifting it stays so at the whole price.
TEST(Rescue, InputsBecomeCheaperWhileFeetHardlyRise) {
  const learn::SessionSettings settings;
  const learn::TrialSummary rose = ended(learn::TrialEnd::completed, 0.9),
                            stands = ended(learn::TrialEnd::completed, -1.0),
                            dragged = ended(learn::TrialEnd::completed, 0.2),
                            fell = ended(learn::TrialEnd::tilt, 0.2);
  double share = learn::next_input_share(1.0, dragged, settings);
  EXPECT_LT(share, 1.0);
  EXPECT_EQ(learn::next_input_share(share, rose, settings), share);
  EXPECT_EQ(learn::next_input_share(share, stands, settings), share) << "no foot is to rise";
  EXPECT_EQ(learn::next_input_share(share, fell, settings), 1.0);
  EXPECT_EQ(learn::next_input_share(1.0, fell, settings), 1.0) << "never dearer than W_u";
  for (int i = 0; i < 20; ++i) share = learn::next_input_share(share, dragged, settings);
  EXPECT_EQ(share, settings.input_share_floor);
}

double inputs_of_standing(double input_share) {
  Loop loop("stand", "back");
  loop.setup.input_share = input_share;
  double squares = 0.0;
  for (const wire::Observation& o : loop.run(1).ticks) squares += o.u_upper.squaredNorm();
  return std::sqrt(squares);
}

TEST(Rescue, APlannerThatInputsCostLessUsesMoreOfThem) {
  EXPECT_GT(inputs_of_standing(0.1), 1.2 * inputs_of_standing(1.0));
}

/// Highest that each sole was above the floor [m].
std::array<float, 2> risen(const learn::Episode& episode) {
  std::array<float, 2> most{};
  for (const learn::TrueSample& truth : episode.truth)
    for (const std::size_t foot : {0, 1})
      most[foot] = std::max(most[foot], truth.foot_clearance_m[foot]);
  return most;
}

/// The planner begins with what bring-up shows, as in a session.
void bring_up(Loop& loop) {
  link::RobotLink& robot = loop.access.place(learn::shifted_stand({}), 1);
  const learn::HeldPoses held = learn::hold_poses(robot, {}, {});
  learn::ModelLearner learner({}, loop.setup.weights.state, {}, 1);
  EXPECT_TRUE(learn::begin_with(held, {}, learner).start.used);
  loop.upper.set_model(learner.current());
}

TEST(Rescue, BothFeetOfASoftRobotLeaveTheFloorInItsFirstTrial) {
  Loop loop("sidestep", "honest:102");  // servos of 0.57 of the stiffness believed, with play
  bring_up(loop);
  const std::array<float, 2> feet = risen(loop.run(1));
  for (const float highest : feet) EXPECT_GT(highest, 0.010F);  // what one_leg calls lifted
}

TEST(Rescue, ARobotStandsInEveryWorldBeforeItHasLearnedAnything) {
  for (const char* world : {"nominal", "lab", "hard", "back", "worst"}) {
    Loop loop("walk_forward", world);
    EXPECT_NO_THROW(loop.stand(1)) << world;
    EXPECT_TRUE(loop.on_its_feet()) << world;
  }
}

TEST(Rescue, ATrialBeginsQuietOrSaysThatItDidNot) {
  Loop loop("stand");
  link::RobotLink& robot = loop.access.place(loop.reference.front(), 1);
  const learn::Preparation calm = learn::prepare_trial(robot, loop.setup, loop.settings);
  EXPECT_TRUE(calm.quiet);
  const double held_s = to_seconds(kTickPeriod) * static_cast<double>(calm.seen.size());
  EXPECT_NEAR(held_s, loop.settings.settle_s - loop.settings.let_go_s, 0.05)
      << "a quiet robot does not wait";

  Loop never("stand");
  never.settings.quiet_rate_rad_s = 0.0;  // nothing is as quiet as that
  link::RobotLink& other = never.access.place(never.reference.front(), 1);
  const learn::Preparation restless = learn::prepare_trial(other, never.setup, never.settings);
  EXPECT_FALSE(restless.quiet);
  EXPECT_NEAR(to_seconds(kTickPeriod) * static_cast<double>(restless.seen.size()),
              never.settings.settle_s - never.settings.let_go_s + never.settings.quiet_patience_s,
              0.1);
}

}  // namespace
}  // namespace sanso::loop
