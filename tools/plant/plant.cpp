// One step: gear trains to joint torques, then MuJoCo's step.
#include "tools/plant/plant.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "tools/plant/body_data.h"
#include "tools/plant/mjcf.h"
#include "tools/plant/mujoco_model.h"
#include "tools/plant/random.h"
#include "tools/plant/world_error.h"

namespace sanso::plant {
namespace {

GearTrainParameters gear_parameters_of(const ServoParameters& s, Random& random) {
  const auto spread = [&] { return std::max(0.2, 1.0 + s.spread * random.normal()); };
  GearTrainParameters p{};
  p.resistance_ohm = s.resistance_ohm;
  p.torque_constant_Nm_A = s.torque_constant_Nm_A * (1.0 + 0.5 * (spread() - 1.0));
  p.back_emf_V_s = s.back_emf_V_s;
  p.motor_inertia_kgm2 = s.motor_inertia_kgm2;
  p.stiffness_Nm_rad = s.gear_stiffness_Nm_rad;
  p.damping_Nms_rad = s.gear_damping_Nms_rad;
  p.backlash_rad = s.backlash_rad * spread();
  const double friction = spread();
  p.coulomb_Nm = s.coulomb_Nm * friction;
  p.stribeck_extra_Nm = s.stribeck_extra_Nm * friction;
  p.stribeck_velocity_rad_s = s.stribeck_velocity_rad_s;
  p.load_friction = s.load_friction * spread();
  p.viscous_Nms_rad = s.viscous_Nms_rad;
  return p;
}

constexpr double kHung_m = 0.1;            // feet above the ground
constexpr double kSupplyFilter_s = 0.002;  // smoothing by the servos' capacitors; chosen

}  // namespace

struct Plant::Impl {
  explicit Impl(const World& world_in)
      : world(world_in),
        model(compile_mjcf(make_mjcf(world), "the emulated robot")),
        data(mj_makeData(model.get())) {
    Random random(world.servo.spread_seed);
    for (const JointData& joint : op3_body().joints) {
      const int id = mj_name2id(model.get(), mjOBJ_JOINT, joint.name.c_str());
      const int servo = joint.servo_id - 1;
      qpos[servo] = model->jnt_qposadr[id];
      dof[servo] = model->jnt_dofadr[id];
    }
    for (auto& p : parameters) p = gear_parameters_of(world.servo, random);
    torso = mj_name2id(model.get(), mjOBJ_BODY, "body_link");
    foot[0] = mj_name2id(model.get(), mjOBJ_BODY, "r_ank_roll_link");
    foot[1] = mj_name2id(model.get(), mjOBJ_BODY, "l_ank_roll_link");
    for (int g = 0; g < model->ngeom; ++g) {
      const char* name = mj_id2name(model.get(), mjOBJ_GEOM, g);
      const bool sole = name && std::strstr(name, "_sole") != nullptr;
      geom_foot.push_back(!sole ? -1 : name[0] == 'r' ? 0 : 1);
      if (model->geom_contype[g] == 1 && model->geom_conaffinity[g] == 0) ground.push_back(g);
    }
    supply = world.supply.voltage_V;
  }

  void step_gears() {
    double battery_current = 0;
    for (int i = 0; i < kNumServos; ++i) {
      GearTrain& gear = gears[i];
      gear.step(parameters[i], kPhysicsStep_s, powered[i], duty[i] * supply, data->qpos[qpos[i]],
                data->qvel[dof[i]]);
      data->qfrc_applied[dof[i]] = gear.gear_torque_Nm;
      // the bridge draws in proportion to its duty
      battery_current += std::max(0.0, duty[i] * gear.current_A);
    }
    const double loaded = supply_override >= 0
                              ? supply_override
                              : open_voltage() - world.supply.internal_ohm * battery_current;
    used_Ah += battery_current * kPhysicsStep_s / 3600.0;
    supply += (loaded - supply) * kPhysicsStep_s / kSupplyFilter_s;
  }

  double open_voltage() const {
    const SupplyParameters& s = world.supply;
    if (s.charge_Ah <= 0.0) return s.voltage_V;
    return s.voltage_V - (s.voltage_V - s.empty_V) * std::min(1.0, used_Ah / s.charge_Ah);
  }

  /// Of a robot on a stand: every link by itself, as a mass on its gear.
  void swing_links() {
    constexpr double kLink_kgm2 = 0.01;  // about a shank with its foot
    for (int i = 0; i < kNumServos; ++i) {
      double& rate = data->qvel[dof[i]];
      rate += kPhysicsStep_s * data->qfrc_applied[dof[i]] / kLink_kgm2;
      double& angle = data->qpos[qpos[i]];
      angle += kPhysicsStep_s * rate;
      if (std::abs(angle) <= kPi) continue;
      angle = std::copysign(kPi, angle);  // its stop
      rate = 0;
    }
  }

  /// The highest ground at (x, y): a ray from above that sees nothing else.
  Plant::Surface surface(double x, double y) const {
    constexpr double kFrom_m = 20.0;
    const mjtNum from[3] = {x, y, kFrom_m}, down[3] = {0, 0, -1};
    const mjtByte ground_only[mjNGROUP] = {0, 1};
    int geom = -1;
    const double way = mj_ray(model.get(), data.get(), from, down, ground_only, 1, -1, &geom);
    if (geom < 0) return {};
    const double* R = data->geom_xmat + 9 * geom;
    return {kFrom_m - way, {R[2], R[5], R[8]}};
  }

  void clamp_base() {
    std::copy(held_pose.begin(), held_pose.end(), data->qpos);
    std::fill(data->qvel, data->qvel + 6, 0.0);
  }

  /// Turns and lifts the base until the two soles' mean normal is up and the lowest sole point
  /// touches the ground.
  void stand_on_ground(double x, double y, double yaw) {
    mjModel* m = model.get();
    mjData* d = data.get();
    const Quat level{1, 0, 0, 0};
    std::copy(level.begin(), level.end(), d->qpos + 3);
    mj_kinematics(m, d);
    Vec3 normal{};
    for (const int body : foot)
      normal = normal + Vec3{d->xmat[9 * body + 2], d->xmat[9 * body + 5], d->xmat[9 * body + 8]};
    normal = (1.0 / norm(normal)) * normal;
    const Vec3 axis = cross(normal, {0, 0, 1});
    const double sine = norm(axis);
    const Quat upright =
        sine < 1e-12 ? level : from_rotation_vector((std::atan2(sine, normal[2]) / sine) * axis);
    const bool level_ground = world.ground.profile == "plane";
    const Plant::Surface below = level_ground ? Plant::Surface{} : surface(x, y);
    const double downhill = std::asin(below.normal[0]);  // a profile turns about y alone
    const Quat turned = multiply(from_rotation_vector({0, downhill, 0}),
                                 multiply(from_rotation_vector({0, 0, yaw}), upright));
    std::copy(turned.begin(), turned.end(), d->qpos + 3);
    d->qpos[0] = x;
    d->qpos[1] = y;
    d->qpos[2] = 0;
    mj_kinematics(m, d);
    double lowest = 1e9;
    for (int g = 0; g < m->ngeom; ++g) {
      if (geom_foot[g] < 0) continue;
      const double* p = d->geom_xpos + 3 * g;
      const double above = level_ground ? 0.0 : surface(p[0], p[1]).z;
      lowest = std::min(lowest, p[2] - above - m->geom_size[3 * g] / below.normal[2]);
    }
    d->qpos[2] = -lowest - 2e-4;  // the soft contact carries the weight at about this depth
  }

  World world;
  ModelPtr model;
  DataPtr data;
  std::array<int, kNumServos> qpos{}, dof{};
  std::array<GearTrainParameters, kNumServos> parameters{};
  std::array<GearTrain, kNumServos> gears{};
  std::array<double, kNumServos> duty{};
  std::array<bool, kNumServos> powered{};
  std::vector<int> geom_foot;  // by geom: 0 right sole, 1 left sole, -1 else
  std::vector<int> ground;     // geoms that one can stand on
  std::array<int, 2> foot{};
  int torso = 0;
  double supply = 12;
  double used_Ah = 0.0;
  double supply_override = -1;
  bool held = false;
  std::array<double, 7> held_pose{};
  std::int64_t steps = 0;
};

Plant::Plant(const World& world) : impl_(std::make_unique<Impl>(world)) { place({}, 0, 0, 0); }
Plant::~Plant() = default;
Plant::Plant(Plant&&) noexcept = default;
Plant& Plant::operator=(Plant&&) noexcept = default;

void Plant::set_duty(int servo, double duty) {
  impl_->duty[servo] = std::clamp(duty, -1.0, 1.0);
  impl_->powered[servo] = true;
}

void Plant::set_coast(int servo) {
  impl_->duty[servo] = 0;
  impl_->powered[servo] = false;
}

void Plant::set_winding(int servo, double resistance_share) {
  impl_->parameters[servo].resistance_ohm = impl_->world.servo.resistance_ohm * resistance_share;
}

void Plant::set_used_charge(double used_Ah) {
  impl_->used_Ah = used_Ah;
  impl_->supply = impl_->open_voltage();
}
double Plant::used_charge() const { return impl_->used_Ah; }

void Plant::override_supply(double volt) { impl_->supply_override = volt; }

void Plant::step() {
  impl_->step_gears();
  if (impl_->world.body.hung)
    impl_->swing_links();
  else
    mj_step(impl_->model.get(), impl_->data.get());
  if (impl_->held) impl_->clamp_base();
  ++impl_->steps;
}

std::int64_t Plant::steps() const { return impl_->steps; }

Plant::Surface Plant::ground(double x_m, double y_m) const { return impl_->surface(x_m, y_m); }

void Plant::place(const std::array<double, kNumServos>& q, double x_m, double y_m, double yaw_rad) {
  mjModel* m = impl_->model.get();
  mjData* d = impl_->data.get();
  mj_resetData(m, d);
  for (int i = 0; i < kNumServos; ++i) {
    d->qpos[impl_->qpos[i]] = q[i];
    impl_->gears[i].place(q[i]);
  }
  impl_->stand_on_ground(x_m, y_m, yaw_rad);
  if (impl_->world.body.hung) d->qpos[2] += kHung_m;
  mj_forward(m, d);
  std::copy(d->qpos, d->qpos + 7, impl_->held_pose.begin());
}

void Plant::hold(bool held) {
  impl_->held = held;
  std::copy(impl_->data->qpos, impl_->data->qpos + 7, impl_->held_pose.begin());
}
bool Plant::held() const { return impl_->held; }

void Plant::set_push(const Vec3& force_in_world, const Vec3& torque_in_world) {
  // xfrc_applied acts at the body's centre of mass; the push is meant at its origin
  mjData* d = impl_->data.get();
  const int b = impl_->torso;
  const Vec3 p_com_origin{d->xpos[3 * b] - d->xipos[3 * b],
                          d->xpos[3 * b + 1] - d->xipos[3 * b + 1],
                          d->xpos[3 * b + 2] - d->xipos[3 * b + 2]};
  const Vec3 torque = torque_in_world + cross(p_com_origin, force_in_world);
  for (int i = 0; i < 3; ++i) {
    d->xfrc_applied[6 * b + i] = force_in_world[i];
    d->xfrc_applied[6 * b + 3 + i] = torque[i];
  }
}

BaseMotion Plant::base() const {
  const mjData* d = impl_->data.get();
  return {{d->qpos[0], d->qpos[1], d->qpos[2]},
          {d->qpos[3], d->qpos[4], d->qpos[5], d->qpos[6]},
          {d->qvel[0], d->qvel[1], d->qvel[2]},
          {d->qvel[3], d->qvel[4], d->qvel[5]}};
}

double Plant::link_angle(int servo) const { return impl_->data->qpos[impl_->qpos[servo]]; }
double Plant::link_rate(int servo) const { return impl_->data->qvel[impl_->dof[servo]]; }
const GearTrain& Plant::gear(int servo) const { return impl_->gears[servo]; }
double Plant::supply_V() const { return impl_->supply; }

namespace {

/// Between a ball and the top of a ground geom [m]; infinite where the ball is not above it.
double gap_above(const mjModel& m, const mjData& d, int ground, int ball) {
  const double* R = d.geom_xmat + 9 * ground;
  const double* size = m.geom_size + 3 * ground;
  const double radius = m.geom_size[3 * ball];
  Vec3 local{};
  for (int axis = 0; axis < 3; ++axis)
    for (int i = 0; i < 3; ++i)
      local[axis] += R[3 * i + axis] * (d.geom_xpos[3 * ball + i] - d.geom_xpos[3 * ground + i]);
  if (m.geom_type[ground] == mjGEOM_PLANE) return local[2] - radius;
  const bool above = std::abs(local[0]) < size[0] + radius && std::abs(local[1]) < size[1] + radius;
  return above ? local[2] - size[2] - radius : std::numeric_limits<double>::infinity();
}

}  // namespace

std::array<FootLoad, 2> Plant::feet() const {
  const mjModel* m = impl_->model.get();
  const mjData* d = impl_->data.get();
  std::array<FootLoad, 2> loads;
  for (int c = 0; c < d->ncon; ++c) {
    const mjContact& contact = d->contact[c];
    const int side = impl_->geom_foot[contact.geom1] >= 0 ? impl_->geom_foot[contact.geom1]
                                                          : impl_->geom_foot[contact.geom2];
    if (side < 0) continue;
    double force[6];
    mj_contactForce(m, d, c, force);
    // contact frame: rows of `frame` are its axes in world; the force acts from geom1 on geom2
    const double sign = impl_->geom_foot[contact.geom2] >= 0 ? 1.0 : -1.0;
    for (int axis = 0; axis < 3; ++axis) {
      for (int i = 0; i < 3; ++i)
        loads[side].force_in_world[i] += sign * force[axis] * contact.frame[3 * axis + i];
    }
    ++loads[side].contacts;
  }
  for (FootLoad& load : loads) load.clearance_m = std::numeric_limits<double>::infinity();
  for (int ball = 0; ball < m->ngeom; ++ball) {
    const int side = impl_->geom_foot[ball];
    if (side < 0) continue;
    double& lowest = loads[side].clearance_m;
    for (const int ground : impl_->ground)
      lowest = std::min(lowest, gap_above(*m, *d, ground, ball));
  }
  return loads;
}

int Plant::other_contacts() const {
  const mjData* d = impl_->data.get();
  int count = 0;
  for (int c = 0; c < d->ncon; ++c) {
    count += impl_->geom_foot[d->contact[c].geom1] < 0 && impl_->geom_foot[d->contact[c].geom2] < 0;
  }
  return count;
}

double Plant::mass_kg() const { return mj_getTotalmass(impl_->model.get()); }

Vec3 Plant::center_of_mass() const {
  const double* com = impl_->data->subtree_com + 3 * impl_->torso;
  return {com[0], com[1], com[2]};
}

Vec3 Plant::linear_momentum() const {
  mj_subtreeVel(impl_->model.get(), impl_->data.get());
  const double* v = impl_->data->subtree_linvel + 3 * impl_->torso;
  return mass_kg() * Vec3{v[0], v[1], v[2]};
}

Vec3 Plant::angular_momentum() const {
  mj_subtreeVel(impl_->model.get(), impl_->data.get());
  const double* h = impl_->data->subtree_angmom + 3 * impl_->torso;
  return {h[0], h[1], h[2]};
}

double Plant::mechanical_energy_J() const {
  mjModel* m = impl_->model.get();
  mjData* d = impl_->data.get();
  const int flags = m->opt.enableflags;
  m->opt.enableflags |= mjENBL_ENERGY;
  mj_energyPos(m, d);
  mj_energyVel(m, d);
  m->opt.enableflags = flags;
  return d->energy[0] + d->energy[1];
}

}  // namespace sanso::plant
