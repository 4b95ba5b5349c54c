// Rounds: a robot is put on its feet, armed and moved by a host that may do anything at any time,
// while faults drawn by chance come and pass; then everything is whole again, and the controller
// has to come back to idle.
#include "tools/campaign/soak.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

#include "host/learn/session/session.h"
#include "host/motion/motion.h"
#include "shared/policy/policy_bytes.h"
#include "tools/campaign/soak_laws.h"
#include "tools/inprocess/inprocess_access.h"

namespace sanso::campaign {
namespace {

using wire::CommandKind;
using wire::SupervisorState;

class Soak {
 public:
  explicit Soak(const SoakOptions& options)
      : options_(options), random_(options.seed), access_(options.world) {
    for (const char* name : {"stand", "squat"}) {
      motion::Motion motion = motion::MotionLibrary().load(name);
      motion.primitives = learn::from_origin(motion.primitives);
      motions_.push_back(std::move(motion));
    }
    access_.on_new_robot([this](inprocess::InProcessRobot& robot) {
      laws_.forget_robot();
      robot.after_tick([this, &robot] { laws_.look(robot, faults_active(robot)); });
    });
  }
  int run();

 private:
  double uniform(double low, double high) {
    const double share = static_cast<double>(random_() >> 11) * 0x1p-53;
    return low + (high - low) * share;
  }
  int pick(int n) { return static_cast<int>(random_() % static_cast<std::uint64_t>(n)); }
  bool chance(double share) { return uniform(0, 1) < share; }

  static bool faults_active(inprocess::InProcessRobot& robot) {
    return !robot.robot().faults().all().empty();
  }
  void new_robot();
  void draw_faults();
  void wait(double seconds);
  bool comes_to(SupervisorState state, double seconds);
  void put_on_feet();
  void be_a_host();
  void make_whole();
  int report() const;

  SoakOptions options_;
  std::mt19937_64 random_;
  std::vector<motion::Motion> motions_;
  inprocess::InProcessAccess access_;
  link::RobotLink* link_ = nullptr;
  SoakLaws laws_;
  std::uint32_t trial_ = 0;
  std::int64_t rounds_ = 0, robots_ = 0;
};

void Soak::new_robot() {
  const model::State pose = learn::reference_of(motions_.front().primitives).front();
  link_ = &access_.place(pose, options_.seed + static_cast<std::uint64_t>(robots_++));
}

void Soak::draw_faults() {
  const std::vector<emulator::FaultKind>& kinds = emulator::all_fault_kinds();
  const Nanoseconds now = access_.robot().now();
  for (int n = pick(4); n > 0; --n) {
    emulator::Fault fault;
    fault.kind = kinds[static_cast<std::size_t>(pick(static_cast<int>(kinds.size())))];
    fault.id = chance(0.5) ? 0 : 1 + pick(emulator::kNumServos);
    fault.start = now + from_seconds(uniform(0, 12));
    fault.stop = fault.start + from_seconds(0.01 * std::pow(500.0, uniform(0, 1)));
    fault.probability = std::pow(0.1, pick(3));
    if (fault.kind == emulator::FaultKind::bus_delay) fault.amount = uniform(0, 0.03);
    if (fault.kind == emulator::FaultKind::brown_out) fault.amount = uniform(5, 12);
    if (fault.kind == emulator::FaultKind::servo_hot) fault.amount = uniform(60, 90);
    access_.robot().robot().faults().add(fault);
  }
}

/// Lives on, with a sign of life every now and then.
void Soak::wait(double seconds) {
  inprocess::InProcessRobot& robot = access_.robot();
  for (const Nanoseconds end = robot.now() + from_seconds(seconds); robot.now() < end;) {
    link_->wait_observation(std::min(end, robot.now() + 50 * kMillisecond));
    link_->send_sign_of_life();
    (void)link_->take_observations();
  }
}

bool Soak::comes_to(SupervisorState state, double seconds) {
  const Nanoseconds end = access_.robot().now() + from_seconds(seconds);
  while (link_->latest().state != state && access_.robot().now() < end) wait(0.02);
  return link_->latest().state == state;
}

void Soak::put_on_feet() {
  const model::State pose = learn::reference_of(motions_.front().primitives).front();
  std::array<double, model::kNumJoints> legs{};
  for (int j = 0; j < model::kNumJoints; ++j)
    legs[static_cast<std::size_t>(j)] = pose[model::kXJoint + j];
  access_.robot().robot().place(emulator::with_legs(legs));
  access_.robot().robot().hold_until_standing();
  wait(0.3);
}

void Soak::be_a_host() {
  const motion::Motion& motion = motions_[static_cast<std::size_t>(pick(2))];
  std::vector<std::uint8_t> bytes(policy::kMaxPrimitiveBytes);
  bytes.resize(policy::to_bytes(motion.primitives, bytes));
  (void)link_->upload(wire::UploadKind::primitives, bytes);
  (void)link_->command({.kind = CommandKind::arm});
  (void)comes_to(SupervisorState::hold, 6);
  wire::Command start{.kind = CommandKind::start_trial,
                      .trial_id = ++trial_,
                      .layers = policy::LayerSwitches::kLower};
  start.duration_ticks = motion.primitives.duration_ticks();
  (void)link_->command(start);
  wait(uniform(0.1, 10));
  constexpr std::array kWhims{CommandKind::none,        CommandKind::stop,
                              CommandKind::disarm,      CommandKind::lower,
                              CommandKind::clear_fault, CommandKind::emergency_stop,
                              CommandKind::arm,         CommandKind::start_trial};
  for (int n = pick(4); n > 0; --n) {
    const CommandKind whim = kWhims[static_cast<std::size_t>(pick(kWhims.size()))];
    if (whim != CommandKind::none) (void)link_->command({.kind = whim, .trial_id = trial_});
    wait(uniform(0, 3));
  }
}

/// The devices are whole again: the controller has to come back to idle.
void Soak::make_whole() {
  access_.robot().robot().faults().clear();
  wait(7);  // who lies there has to lie there without torque
  for (int look = 0; look < 4; ++look) {
    if (link_->latest().state == SupervisorState::fault)
      (void)link::lower_and_clear(*link_);
    else if (link_->latest().state != SupervisorState::idle)
      (void)link_->command({.kind = CommandKind::disarm});
    if (comes_to(SupervisorState::idle, 8)) return;
  }
  laws_.broken(fmt::format("not back to idle: F{}", link_->latest().fault));
  new_robot();
}

int Soak::run() {
  new_robot();
  while (laws_.ticks() < options_.ticks) {
    ++rounds_;
    put_on_feet();
    draw_faults();
    be_a_host();
    make_whole();
    access_.robot().forget_trials();
    if (rounds_ % 100 == 0) fmt::print(stderr, "{} ticks, {} rounds\n", laws_.ticks(), rounds_);
  }
  return report();
}

int Soak::report() const {
  nlohmann::ordered_json faults, broken;
  for (const auto& [number, times] : laws_.faults()) faults[fmt::format("F{}", number)] = times;
  for (const auto& [law, times] : laws_.all_broken()) broken[law] = times;
  if (options_.json) {
    const nlohmann::ordered_json all{
        {"seed", options_.seed},  {"world", options_.world},
        {"ticks", laws_.ticks()}, {"rounds", rounds_},
        {"falls", laws_.falls()}, {"largest_step_rad", laws_.largest_step_rad()},
        {"faults", faults},       {"broken", broken}};
    fmt::print("{}\n", all.dump(2));
  } else {
    fmt::print("{} ticks in {} rounds, {} falls, largest step {:.3f} rad\nfaults latched: {}\n",
               laws_.ticks(), rounds_, laws_.falls(), laws_.largest_step_rad(), faults.dump());
    fmt::print("laws broken: {}\n", broken.empty() ? "none" : broken.dump());
  }
  return laws_.all_broken().empty() ? 0 : 1;
}

}  // namespace

int bench_soak(const SoakOptions& options) { return Soak(options).run(); }

}  // namespace sanso::campaign
