// A session that is killed continues with the same bits.
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <functional>

#include "host/app/interrupt.h"
#include "shared/files/atomic_file.h"
#include "tests/loop/support/loop_fixture.h"
#include "tests/support/temp_folder.h"

namespace sanso::loop {
namespace {

namespace fs = std::filesystem;

struct Resume : testing::Test {
  test::TempFolder temporary;
  fs::path folder = temporary.path();
};

/// A session of short standing trials in `out`; returns the digests of its trials and of what it
/// learned.
std::vector<std::uint64_t> run_session(
    const fs::path& out, int iterations, bool resume, std::uint64_t seed = 3,
    const std::function<bool()>& stop = [] { return false; }) {
  const motion::Motion stand = motion::MotionLibrary().load("stand");
  learn::Task task{"stand", stand.primitives, stand.weights, {}};
  inprocess::InProcessAccess robot("tired");  // heat and charge have to be stored too
  mpc::UpperLayer upper(mpc::MpcSettings{}, host::AugmentedModel{});
  learn::SessionSettings settings;
  settings.iterations = iterations;
  settings.seed = seed;
  settings.out = out;
  settings.resume = resume;
  settings.trial.settle_s = 0.2;
  settings.bring_up.hold_s = 0.2;  // its model belongs to what is resumed
  settings.bring_up.measure_s = 0.1;
  learn::Session session(task, settings, robot, upper);
  session.run([](const learn::TrialSummary&) {}, stop);
  std::vector<std::uint64_t> digests{learn::learned_digest(session.state())};
  for (const learn::TrialSummary& t : session.state().history) digests.push_back(t.digest);
  return digests;
}

TEST_F(Resume, KilledInTheMiddleEqualsUninterrupted) {
  const pid_t child = fork();
  if (child == 0) {
    int asked = 0;
    run_session(folder / "killed", 4, false, 3, [&] {
      // before the last trial: however long the killer takes, it comes in time
      while (++asked == 4) pause();
      return false;
    });
    _exit(0);
  }
  // killed somewhere in the second trial: after the first is stored, before the last
  while (!fs::exists(folder / "killed" / "summary.json") && waitpid(child, nullptr, WNOHANG) == 0)
    usleep(2000);
  usleep(150'000);
  kill(child, SIGKILL);
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status)) << "the session ended before it could be killed";

  EXPECT_EQ(run_session(folder / "killed", 4, true), run_session(folder / "whole", 4, false));
}

TEST_F(Resume, CtrlCLetsTheTrialEndAndNothingIsLost) {
  {
    const app::Interrupt interrupt;
    EXPECT_FALSE(app::Interrupt::requested());
    int asked = 0;
    const auto digests = run_session(folder / "stopped", 3, false, 3, [&] {
      if (++asked == 2) raise(SIGINT);  // while the first trial is being stored
      return app::Interrupt::requested();
    });
    EXPECT_EQ(digests.size(), 2u) << "what was learned, and one trial";
  }
  EXPECT_EQ(run_session(folder / "stopped", 3, true), run_session(folder / "whole", 3, false));
}

TEST_F(Resume, AnotherSessionIsNotContinued) {
  run_session(folder / "s", 1, false);
  EXPECT_THROW(run_session(folder / "s", 2, false), std::runtime_error);    // without --resume
  EXPECT_THROW(run_session(folder / "s", 2, true, 4), std::runtime_error);  // another seed
}

TEST_F(Resume, ADamagedStateIsRefused) {
  run_session(folder / "s", 1, false);
  std::vector<std::uint8_t> bytes = files::read_file(folder / "s" / "state.bin");
  bytes[bytes.size() / 2] ^= 1;
  files::write_atomically(folder / "s" / "state.bin", bytes);
  EXPECT_THROW(run_session(folder / "s", 2, true), std::runtime_error);
}

}  // namespace
}  // namespace sanso::loop
