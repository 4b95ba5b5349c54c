// Joins plant, servos, board and sensors: advance() runs them in steps of the physics and feeds
// each what the others show.
#include "tools/emulator/emulated_robot.h"

#include <algorithm>
#include <cmath>

#include "tools/emulator/bus_slave.h"
#include "tools/emulator/hid_imu.h"
#include "tools/emulator/open_cr.h"
#include "tools/emulator/pose_source.h"
#include "tools/emulator/servo.h"
#include "tools/plant/mjcf.h"
#include "tools/plant/plant.h"
#include "tools/plant/servo_birth.h"
#include "tools/plant/world_error.h"

namespace sanso::emulator {

using plant::operator*;
using plant::operator+;
using plant::operator-;

namespace {

static_assert(kNumServos == plant::kNumServos);

constexpr Nanoseconds kStep = from_seconds(plant::kPhysicsStep_s);
// the person lets go this long after the legs hold torque
constexpr Nanoseconds kHelperDelay = 1 * kSecond;
constexpr double kCopper_C = 25.0;  // at which the data sheet's resistance holds
constexpr std::array<int, 12> kLegServoIds{7, 9, 11, 13, 15, 17, 8, 10, 12, 14, 16, 18};
constexpr double kDeg = plant::kPi / 180.0;
constexpr plant::Vec3 kGravity{0, 0, -9.81};

}  // namespace

std::array<double, 37> Truth::leg_state() const {
  std::array<double, 37> x{};
  std::copy(p_world_base.begin(), p_world_base.end(), x.begin());
  std::copy(quat_world_base.begin(), quat_world_base.end(), x.begin() + 3);
  std::copy(v_base_in_world.begin(), v_base_in_world.end(), x.begin() + 19);
  std::copy(w_base_in_base.begin(), w_base_in_base.end(), x.begin() + 22);
  for (std::size_t j = 0; j < kLegServoIds.size(); ++j) {
    x[7 + j] = q[kLegServoIds[j] - 1];
    x[25 + j] = dq[kLegServoIds[j] - 1];
  }
  return x;
}

Placement walkready() {
  // page 9 of the maker's action file, degrees
  Placement p;
  const double arms_and_legs[18] = {4.92,   -5.01, -45.62, 45.35, 45.18, -45.35,
                                    0,      0,     2.55,   -2.20, 31.82, -31.82,
                                    -60.64, 61.00, -36.65, 36.56, 2.29,  -2.37};
  for (int i = 0; i < 18; ++i) p.q[i] = arms_and_legs[i] * kDeg;
  return p;
}

Placement crouch() {
  // the maker's ini_pose, degrees
  Placement p;
  const double arms_and_legs[18] = {15, -15, -45, 45,   45,  -45, 0,  0, 0,
                                    0,  70,  -70, -142, 142, -70, 70, 0, 0};
  for (int i = 0; i < 18; ++i) p.q[i] = arms_and_legs[i] * kDeg;
  p.q[19] = -10 * kDeg;
  return p;
}

Placement with_legs(const std::array<double, 12>& leg_angles_rad) {
  Placement p = walkready();
  for (std::size_t j = 0; j < leg_angles_rad.size(); ++j)
    p.q[kLegServoIds[j] - 1] = leg_angles_rad[j];
  return p;
}

struct EmulatedRobot::Impl {
  Impl(const plant::World& world_in, std::uint64_t seed, std::int64_t baud)
      : world(world_in),
        body(world),
        board(seed * 3 + 4),
        imu(world.imu, seed * 3 + 1),
        pose(world.pose, seed * 3 + 2) {
    std::vector<BusDevice*> devices;
    for (int id = 1; id <= kNumServos; ++id) {
      const plant::ServoBirth birth = plant::birth_of(world.servo, id);
      plant::ServoParameters own = world.servo;
      own.p_divisor /= birth.gain_scale;
      zero_offset[static_cast<std::size_t>(id - 1)] = birth.zero_offset_rad;
      servos.push_back(std::make_unique<Servo>(static_cast<std::uint8_t>(id), own, baud));
      devices.push_back(servos.back().get());
    }
    devices.push_back(&board);
    bus = std::make_unique<BusSlave>(std::move(devices), faults, baud, seed * 3 + 3);
    loop_steps =
        std::max<std::int64_t>(1, std::llround(world.servo.loop_period_s / plant::kPhysicsStep_s));
  }

  void advance(Nanoseconds time) {
    while (true) {
      const Nanoseconds step_at = (body.steps() + 1) * kStep;
      const Nanoseconds next = std::min(step_at, bus->next_event());
      if (next > time) break;
      now = std::max(now, next);
      bus->run(now);
      if (step_at <= now) step();
    }
    now = std::max(now, time);
  }

  void step() {
    if (body.steps() % loop_steps == 0) run_servos();
    plant::Vec3 force = now >= push_start && now < push_stop ? push_force : plant::Vec3{};
    if (hand.there()) force = force + hand.force(now, body.base(), !body.held());
    plant::Vec3 torque = now >= push_start && now < push_stop ? push_torque : plant::Vec3{};
    if (support.strength > 0.0 && !body.held()) {
      const SupportWrench wrench = wrench_of(support, body.base());
      force = force + wrench.force_in_world;
      torque = torque + wrench.torque_in_world;
    }
    body.set_push(force, torque);
    body.step();
    if (body.steps() % 2 == 0) run_sensors();
  }

  void run_servos() {
    apply_faults();
    const double period = static_cast<double>(loop_steps) * plant::kPhysicsStep_s;
    bool legs_hold = true;
    for (int i = 0; i < kNumServos; ++i) {
      Servo& servo = *servos[i];
      servo.set_power(board.servo_power(), now);
      if (world.servo.copper_per_K > 0.0)
        body.set_winding(i, 1.0 + world.servo.copper_per_K * (servo.temperature_C() - kCopper_C));
      const ServoSense sense{body.link_angle(i) + horn_error[i] + zero_offset[i], body.link_rate(i),
                             body.gear(i).current_A, body.supply_V()};
      const ServoDrive drive = servo.update(now, period, sense);
      if (drive.powered) {
        body.set_duty(i, drive.duty);
      } else {
        body.set_coast(i);
      }
    }
    for (const int id : kLegServoIds) legs_hold = legs_hold && servos[id - 1]->torque_on();
    if (!legs_hold || !helper_waits) {
      legs_hold_since = now;
    } else if (now - legs_hold_since >= kHelperDelay) {
      body.hold(false);
      helper_waits = false;
    }
  }

  void apply_faults() {
    const Fault* brown_out = faults.active(FaultKind::brown_out, 0, now);
    body.override_supply(brown_out ? (brown_out->amount > 0 ? brown_out->amount : 6.0) : -1.0);
    for (int i = 0; i < kNumServos; ++i) {
      const int id = i + 1;
      servos[i]->set_cable(!faults.active(FaultKind::servo_silent, id, now));
      if (faults.active(FaultKind::servo_overload, id, now))
        servos[i]->raise(servo_bus::xm430::kErrorOverload);
      if (const Fault* hot = faults.active(FaultKind::servo_hot, id, now)) {
        servos[i]->set_temperature(hot->amount > 0 ? hot->amount : 85.0);
      }
    }
  }

  /// Every millisecond: acceleration averaged over it, as the sensor's own filter does.
  void run_sensors() {
    const plant::BaseMotion base = body.base();
    const plant::Vec3 acceleration = 1000.0 * (base.v_base_in_world - last_velocity);
    last_velocity = base.v_base_in_world;
    const plant::Vec3 force =
        plant::rotate(plant::conjugate(base.quat_world_base), acceleration - kGravity);
    imu.update(now, {force, base.w_base_in_base, base.quat_world_base},
               faults.active(FaultKind::imu_silent, 0, now),
               faults.active(FaultKind::imu_frozen, 0, now));
    pose.update(now, base, faults.active(FaultKind::pose_lost, 0, now));
    board.set_voltage(body.supply_V());
    board.set_imu(force, base.w_base_in_base);
  }

  plant::World world;
  plant::Plant body;
  std::vector<std::unique_ptr<Servo>> servos;
  std::array<double, kNumServos> horn_error{};   // as set up by the client
  std::array<double, kNumServos> zero_offset{};  // as born
  OpenCr board;
  HidImu imu;
  PoseSource pose;
  FaultPlan faults;
  std::unique_ptr<BusSlave> bus;
  Nanoseconds now = 0;
  std::int64_t loop_steps = 2;
  bool helper_waits = true;  // a person holds the robot until it stands by itself
  Nanoseconds legs_hold_since = 0;
  plant::Vec3 last_velocity{};
  Hand hand;
  Support support;
  plant::Vec3 push_force{}, push_torque{};
  Nanoseconds push_start = 0, push_stop = 0;
};

EmulatedRobot::EmulatedRobot(const plant::World& world, std::uint64_t seed, std::int64_t baud)
    : impl_(std::make_unique<Impl>(world, seed, baud)) {
  place(walkready());
  impl_->body.hold(true);
}
EmulatedRobot::~EmulatedRobot() = default;
EmulatedRobot::EmulatedRobot(EmulatedRobot&&) noexcept = default;
EmulatedRobot& EmulatedRobot::operator=(EmulatedRobot&&) noexcept = default;

Nanoseconds EmulatedRobot::now() const { return impl_->now; }
void EmulatedRobot::advance(Nanoseconds time) { impl_->advance(time); }

void EmulatedRobot::bus_write(std::span<const std::uint8_t> bytes) {
  impl_->bus->receive(bytes, impl_->now);
}
std::size_t EmulatedRobot::bus_read(std::span<std::uint8_t> out) {
  return impl_->bus->transmit(out, impl_->now);
}
Nanoseconds EmulatedRobot::next_bus_byte() const {
  // a reply can only follow once the instruction has arrived
  return std::min(impl_->bus->next_byte(), impl_->bus->next_event());
}

std::size_t EmulatedRobot::imu_read(std::span<std::uint8_t> out) { return impl_->imu.read(out); }
bool EmulatedRobot::imu_set_feature(std::span<const std::uint8_t> report) {
  return impl_->imu.set_feature(report);
}
std::size_t EmulatedRobot::imu_get_feature(std::uint8_t report_id,
                                           std::span<std::uint8_t> out) const {
  return impl_->imu.get_feature(report_id, out);
}
std::span<const std::uint8_t> EmulatedRobot::imu_descriptor() { return HidImu::descriptor(); }
std::size_t EmulatedRobot::pose_read(std::span<std::uint8_t> out) {
  return impl_->pose.read(out, impl_->now);
}

void EmulatedRobot::place(const Placement& p) {
  impl_->body.place(p.q, p.x_m, p.y_m, p.yaw_rad);
  impl_->last_velocity = {};
}

void EmulatedRobot::hold(bool held) {
  impl_->helper_waits = false;
  impl_->body.hold(held);
}
void EmulatedRobot::hold_until_standing() {
  impl_->helper_waits = true;
  impl_->legs_hold_since = impl_->now;
  impl_->body.hold(true);
}
bool EmulatedRobot::held() const { return impl_->body.held(); }

void EmulatedRobot::push(const plant::Vec3& force_in_world, const plant::Vec3& torque_in_world,
                         Nanoseconds start, Nanoseconds stop) {
  impl_->push_force = force_in_world;
  impl_->push_torque = torque_in_world;
  impl_->push_start = start;
  impl_->push_stop = stop;
}

void EmulatedRobot::lend_hand(const Push& push) { impl_->hand.lend(push); }
void EmulatedRobot::support(const Support& support) { impl_->support = support; }
void EmulatedRobot::push_off() { impl_->hand.push_off(impl_->now); }

void EmulatedRobot::set_up(const ServoSetup& setup) {
  namespace xm = servo_bus::xm430;
  if (setup.id < 1 || setup.id > kNumServos)
    throw plant::WorldError("servo " + std::to_string(setup.id) + ": expected an id from 1 to 20");
  Servo& servo = *impl_->servos[static_cast<std::size_t>(setup.id - 1)];
  if (setup.baud != 0) {
    const auto rate = std::find(xm::kBaudRates.begin(), xm::kBaudRates.end(), setup.baud);
    if (rate == xm::kBaudRates.end())
      throw plant::WorldError("servo " + std::to_string(setup.id) + ": no servo talks at " +
                              std::to_string(setup.baud) + " baud");
    servo.set_factory_register(xm::kBaudRate, rate - xm::kBaudRates.begin());
  }
  servo.set_factory_register(xm::kReturnDelayTime, setup.return_delay_raw);
  servo.set_firmware(static_cast<std::uint8_t>(setup.firmware));
  if (setup.shut_down) servo.shut_down_once();
  impl_->horn_error[static_cast<std::size_t>(setup.id - 1)] = setup.horn_error_rad;
}

void EmulatedRobot::set_line_baud(std::int64_t baud) {
  impl_->bus->set_baud(baud);
  for (const auto& servo : impl_->servos) servo->set_line_baud(baud);
}

plant::Condition EmulatedRobot::condition() const {
  plant::Condition now;
  for (std::size_t i = 0; i < now.temperature_C.size(); ++i)
    now.temperature_C[i] = impl_->servos[i]->temperature_C();
  now.used_Ah = impl_->body.used_charge();
  return now;
}

void EmulatedRobot::begin_rested(const plant::Condition& before) {
  for (std::size_t i = 0; i < before.temperature_C.size(); ++i)
    impl_->servos[i]->set_temperature(Servo::cooled(before.temperature_C[i], impl_->world.rest_s));
  impl_->body.set_used_charge(before.used_Ah);
}

void EmulatedRobot::press(std::uint8_t buttons) { impl_->board.press(buttons); }
FaultPlan& EmulatedRobot::faults() { return impl_->faults; }

Truth EmulatedRobot::truth() const {
  const plant::Plant& body = impl_->body;
  const plant::BaseMotion base = body.base();
  Truth t;
  t.time = impl_->now;
  t.p_world_base = base.p_world_base;
  t.quat_world_base = base.quat_world_base;
  t.v_base_in_world = base.v_base_in_world;
  t.w_base_in_base = base.w_base_in_base;
  for (int i = 0; i < kNumServos; ++i) {
    t.q[i] = body.link_angle(i);
    t.dq[i] = body.link_rate(i);
    t.torque[i] = body.gear(i).motor_torque_Nm;
    t.torque_on[i] = impl_->servos[i]->torque_on();
  }
  const auto feet = body.feet();
  for (std::size_t side = 0; side < 2; ++side) {
    t.foot_force_in_world[side] = feet[side].force_in_world;
    t.foot_contacts[side] = feet[side].contacts;
    t.foot_clearance_m[side] = feet[side].clearance_m;
  }
  t.other_contacts = body.other_contacts();
  t.supply_V = body.supply_V();
  return t;
}

}  // namespace sanso::emulator
