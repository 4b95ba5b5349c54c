// The host of a scenario is the host of a session: uploads, arm, a trial with the planner in the
// loop, and then waiting until nothing more can happen.
#include "tools/campaign/run_scenario.h"

#include <fmt/format.h>

#include <algorithm>

#include "host/learn/session/session.h"
#include "host/motion/motion.h"
#include "tools/campaign/bounds.h"
#include "tools/inprocess/inprocess_access.h"

namespace sanso::campaign {
namespace {

constexpr Nanoseconds kSignOfLife = 50 * kMillisecond;

/// When trouble begins, in ticks of the trial: standing, on the way down, in mid-step.
std::int32_t trouble_tick(Motion motion) {
  constexpr std::array<std::int32_t, 3> kTicks{100, 250, 310};
  return kTicks[static_cast<std::size_t>(motion)];
}

/// Brings the trouble when its tick has come.
class Troublemaker {
 public:
  Troublemaker(const Scenario& scenario, inprocess::InProcessRobot& robot, Witness& witness)
      : scenario_(scenario), robot_(robot), witness_(witness) {}
  void look() {
    if (begun_ || robot_.controller().observation().trial_tick < trouble_tick(scenario_.motion))
      return;
    begun_ = true;
    const Nanoseconds now = robot_.now();
    witness_.trouble_at(now);
    if (scenario_.trouble.fault) {
      emulator::Fault fault = *scenario_.trouble.fault;
      fault.start += now;
      fault.stop += now;
      robot_.robot().faults().add(fault);
    }
    if (scenario_.trouble.act == Act::pull_bus) robot_.bus().pull(true);
    if (scenario_.trouble.act == Act::lose_host) robot_.lose_host_at(0);
    if (scenario_.trouble.act == Act::emergency_stop) robot_.handover().emergency_stop = true;
  }

 private:
  const Scenario& scenario_;
  inprocess::InProcessRobot& robot_;
  Witness& witness_;
  bool begun_ = false;
};

/// Observations missing between those that came.
int gaps(const std::vector<wire::Observation>& seen, std::uint64_t& last) {
  std::uint64_t missing = 0;
  for (const wire::Observation& o : seen) {
    if (last != 0 && o.tick > last + 1) missing += o.tick - last - 1;
    last = o.tick;
  }
  return static_cast<int>(missing);
}

firmware::Settings settings_of(const Scenario& scenario) {
  const std::array<double, 4>& quat = scenario.trouble.quat_base_sensor;
  firmware::Settings settings;
  settings.imu.quat_base_sensor_w = quat[0];
  settings.imu.quat_base_sensor_x = quat[1];
  settings.imu.quat_base_sensor_y = quat[2];
  settings.imu.quat_base_sensor_z = quat[3];
  return settings;
}

struct TrialOutcome {
  std::string end;            // why the trial ended; empty: as it should
  std::uint16_t refusal = 0;  // of the command that was refused
  std::vector<wire::Observation> ticks;
};

/// Stands up, runs the trial with the planner in the loop. A turned IMU may be found before it.
TrialOutcome run_trial_of(const Scenario& scenario, const learn::TrialSetup& setup,
                          link::RobotLink& link) {
  learn::TrialSettings settings;
  settings.settle_s = 0.3;
  mpc::MpcSettings planner;
  planner.threads = 1;
  mpc::UpperLayer upper(planner, host::AugmentedModel{});
  TrialOutcome outcome;
  try {
    learn::prepare_trial(link, setup, settings);
    const learn::Episode episode = learn::run_trial(link, upper, setup, settings);
    const bool by_host = scenario.trouble.act == Act::lose_host;  // ends early by design
    if (episode.end != learn::TrialEnd::completed && !by_host)
      outcome.end = learn::to_string(episode.end);
    outcome.ticks = episode.ticks;
  } catch (const std::runtime_error& error) {
    if (scenario.trouble.act != Act::turn_imu) throw;
    outcome.end = error.what();
    outcome.refusal = link.refusal();
  }
  return outcome;
}

}  // namespace

std::vector<std::string> broken_of(const Expected& expected, const Found& found,
                                   const std::string& trial_end) {
  std::vector<std::string> broken;
  const bool refused =
      std::count(expected.endings.begin(), expected.endings.end(), Ending::refused) > 0;
  const bool turned_down = refused &&
                           (found.ending == Ending::refused || found.ending == Ending::limp) &&
                           found.refusal != 0;
  const bool right_fault = expected.faults.empty()
                               ? found.fault == firmware::Fault::none
                               : turned_down || std::count(expected.faults.begin(),
                                                           expected.faults.end(), found.fault) > 0;
  if (refused && found.ending == Ending::refused && found.refusal == 0)
    broken.push_back("refused without a number");
  if (!right_fault) broken.push_back(fmt::format("fault {}", name_of(found.fault)));
  if (!expected.faults.empty() && right_fault && found.reaction_s > expected.within_s)
    broken.push_back(fmt::format("after {:.3f} s", found.reaction_s));
  if (std::count(expected.endings.begin(), expected.endings.end(), found.ending) == 0)
    broken.push_back(fmt::format("ends {}", name_of(found.ending)));
  if (found.fell && !expected.fall_allowed) broken.push_back("falls");
  const bool can_be_told =
      std::count(expected.endings.begin(), expected.endings.end(), Ending::fell) == 0;
  if (found.fell && can_be_told && found.torque_Nm != 0.0)
    broken.push_back(fmt::format("{:.1f} N m after the fall", found.torque_Nm));
  if (found.step_rad > kMaxStep_rad)
    broken.push_back(fmt::format("a step of {:.2f} rad", found.step_rad));
  if (expected.max_speed_rad_s > 0 && found.speed_rad_s > expected.max_speed_rad_s)
    broken.push_back(fmt::format("a joint at {:.1f} rad/s", found.speed_rad_s));
  if (expected.faults.empty() && !trial_end.empty()) broken.push_back("trial: " + trial_end);
  return broken;
}

Found run_scenario(const Scenario& scenario, std::uint64_t seed) {
  if (scenario.trouble.act == Act::arm_early) return run_arming(scenario, seed);
  motion::Motion motion = motion::MotionLibrary().load(name_of(scenario.motion));
  motion.primitives = learn::from_origin(motion.primitives);
  const std::vector<model::State> reference = learn::reference_of(motion.primitives);
  learn::TrialSetup setup;
  setup.primitives = &motion.primitives;
  setup.reference = reference;
  setup.weights = motion.weights;
  setup.layers.middle = false;
  setup.duration_ticks = motion.primitives.duration_ticks();

  inprocess::InProcessAccess access("lab", settings_of(scenario));
  link::RobotLink& link = access.place(reference.front(), seed);
  inprocess::InProcessRobot& robot = access.robot();
  Witness witness(robot);
  Troublemaker troublemaker(scenario, robot, witness);
  robot.after_tick([&] {
    witness.look();
    troublemaker.look();
  });
  const TrialOutcome outcome = run_trial_of(scenario, setup, link);
  if (scenario.trouble.act == Act::turn_imu) witness.trouble_at(robot.now());
  std::uint64_t last_tick = 0;
  int lost = gaps(outcome.ticks, last_tick);
  last_tick = 0;  // an episode keeps none of those after its trial
  while (!witness.settled()) {
    link.wait_observation(robot.now() + kSignOfLife);
    link.send_sign_of_life();
    lost += gaps(link.take_observations(), last_tick);
  }
  Found found = witness.found();
  found.ticks_lost = lost;
  found.refusal = outcome.refusal;
  found.broken = broken_of(scenario.expected, found, outcome.end);
  return found;
}

}  // namespace sanso::campaign
