// A position drive a joint, implicit contacts, steps of half a millisecond; sensors are read from
// MuJoCo's own and spoiled afterwards.
#include "tools/conceal/floor_world.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "tools/plant/body_data.h"
#include "tools/plant/mujoco_model.h"

namespace sanso::conceal {

using plant::operator+;
using plant::operator*;
using plant::Quat;

namespace {

constexpr double kFloorStep_s = 0.0005, kRow_s = 0.01, kFloorSettle_s = 3.0, kLength_s = 12.0;
// box under each ankle, m: about the maker's sole
constexpr Vec3 kSoleHalf{0.063, 0.038, 0.004};
constexpr double kAnkle_m = 0.0317;  // above the ground

std::string inertial(double mass, const Vec3& com, const double* i) {
  return fmt::format(R"(<inertial pos="{}" mass="{:.9g}" fullinertia="{:.9g} {:.9g} )"
                     R"({:.9g} {:.9g} {:.9g} {:.9g}"/>)",
                     text(com), mass, i[0], i[1], i[2], i[3], i[4], i[5]);
}

/// Centre of the sole's box in the frame of the ankle's roll joint.
Vec3 sole_at(bool left) { return {0.02, left ? 0.01 : -0.01, -kAnkle_m + kSoleHalf[2]}; }

bool is_foot(const LinkSpec& l) { return l.joint.ends_with("ank_roll"); }

void write_link(std::string& out, const FloorTruth& w, int index) {
  const LinkSpec& l = w.legs.links[static_cast<std::size_t>(index)];
  const FloorDrive& drive = w.drives[static_cast<std::size_t>(index)];
  out += fmt::format(
      R"(<body name="{}" pos="{}"><joint name="{}" type="hinge" axis="{}" armature="{:.9g}" )"
      R"(damping="{:.9g}" frictionloss="{:.9g}"/>{})",
      l.link, text(l.origin), l.joint, text(l.axis), w.armature, drive.viscous + w.kd,
      drive.coulomb, inertial(l.mass, l.com, l.inertia));
  if (is_foot(l))
    out += fmt::format(
        R"(<geom name="{}" type="box" size="{}" pos="{}" mass="0" friction="{:.9g} 0.01 0.001"/>)",
        l.link, text(kSoleHalf), text(sole_at(l.joint[0] == 'l')), w.friction);
  for (int child = 0; child < w.legs.size(); ++child) {
    if (w.legs.links[static_cast<std::size_t>(child)].parent == index) write_link(out, w, child);
  }
  out += "</body>\n";
}

/// The floor leans, and gravity does not.
std::string mjcf(const FloorTruth& w) {
  std::string out = fmt::format(
      R"(<mujoco model="floor"><compiler angle="radian" boundmass="1e-9" boundinertia="1e-12"/>
<option timestep="{}" gravity="0 0 -9.81" integrator="implicit" cone="elliptic"/>
<worldbody><geom name="floor" type="plane" size="0 0 1" euler="{:.9g} {:.9g} 0"
friction="{:.9g} 0.01 0.001"/><body name="trunk" pos="0 0 0.5"><freejoint name="free"/>{}
<site name="imu" pos="0 0 0"/>
<body name="payload" pos="{}">
<inertial pos="0 0 0" mass="{:.9g}" diaginertia="1e-9 1e-9 1e-9"/></body>
)",
      kFloorStep_s, w.slope[0], w.slope[1], w.friction,
      inertial(w.trunk.mass, w.trunk.com, w.trunk.inertia), text(w.payload_at),
      std::max(w.payload_kg, 1e-8));
  for (int i = 0; i < w.legs.size(); ++i) {
    if (w.legs.links[static_cast<std::size_t>(i)].parent < 0) write_link(out, w, i);
  }
  out += "</body></worldbody><actuator>";
  for (std::size_t j = 0; j < w.legs.links.size(); ++j)
    out += fmt::format(R"(<position name="{0}" joint="{0}" kp="{1:.9g}" forcelimited="true" )"
                       R"(forcerange="-4.1 4.1"/>)",
                       w.legs.links[j].joint, w.kp * w.drives[j].gain);
  return out +
         R"(</actuator><sensor><accelerometer site="imu"/><gyro site="imu"/></sensor></mujoco>)";
}

/// v in the axes that q turns the world's into.
Vec3 seen_in(const Quat& q, const Vec3& v) { return plant::rotate(plant::conjugate(q), v); }

class Logger {
 public:
  Logger(const FloorTruth& truth, std::uint64_t seed) : truth_(truth), random_(seed) {}

  void row(const mjModel& m, const mjData& d, double t, const std::vector<double>& goals) {
    out_.t.push_back(t);
    for (std::size_t j = 0; j < goals.size(); ++j) {
      const std::string& name = truth_.legs.links[j].joint;
      add("u:" + name, goals[j]);
      constexpr double kQuantum = 0.00153398078788564;
      const double read = d.qpos[7 + j] + truth_.drives[j].zero;
      add("q:" + name, std::round(read / kQuantum) * kQuantum);
    }
    for (int i = 0; i < 3; ++i)
      add(std::string("base_p:") + "xyz"[i], d.qpos[i] + truth_.camera_noise_m * random_.normal());
    const double s = truth_.camera_noise_rad;
    const Quat q =
        plant::multiply({d.qpos[3], d.qpos[4], d.qpos[5], d.qpos[6]},
                        plant::from_rotation_vector(
                            {s * random_.normal(), s * random_.normal(), s * random_.normal()}));
    for (std::size_t i = 0; i < 4; ++i) add(std::string("base_q:") + "wxyz"[i], q[i]);
    imu(d);
    feet(m, d);
  }
  recording::Recording take() { return std::move(out_); }

 private:
  void add(const std::string& name, double value) {
    for (recording::Channel& c : out_.channels) {
      if (c.name != name) continue;
      c.values.push_back(value);
      return;
    }
    out_.channels.push_back({name, {value}});
  }
  void imu(const mjData& d) {
    const Quat mount = plant::from_rotation_vector(truth_.imu_turn);
    const Vec3 acc = seen_in(mount, {d.sensordata[0], d.sensordata[1], d.sensordata[2]});
    const Vec3 gyro = seen_in(mount, {d.sensordata[3], d.sensordata[4], d.sensordata[5]});
    for (std::size_t i = 0; i < 3; ++i)
      add(std::string("imu_acc:") + "xyz"[i],
          acc[i] + truth_.acc_bias[i] + 0.05 * random_.normal());
    for (std::size_t i = 0; i < 3; ++i)
      add(std::string("imu_gyro:") + "xyz"[i],
          gyro[i] + truth_.gyro_bias[i] + 0.005 * random_.normal());
  }
  void feet(const mjModel& m, const mjData& d) {
    std::map<std::string, double> sum;
    for (const LinkSpec& l : truth_.legs.links) {
      if (is_foot(l)) sum[l.link] = 0;
    }
    for (int c = 0; c < d.ncon; ++c) {
      mjtNum force[6];
      mj_contactForce(&m, &d, c, force);
      for (const int geom : {d.contact[c].geom1, d.contact[c].geom2}) {
        const char* name = mj_id2name(&m, mjOBJ_GEOM, geom);
        if (name != nullptr && sum.contains(name)) sum[name] += force[0];
      }
    }
    for (const auto& [link, force] : sum)
      add("fz:" + link, truth_.force_scale * force + 0.3 * random_.normal());
  }

  const FloorTruth& truth_;
  plant::Random random_;
  recording::Recording out_;
};

/// Goals, and what pulls and pushes, of a robot that moves.
class Hand {
 public:
  Hand(const FloorTruth& truth, const FloorMotion& motion, std::uint64_t seed)
      : truth_(truth), motion_(motion) {
    Random random(seed ^ 0x9055);
    for (int i = 0; i < truth.push.times && truth.push.force > 0; ++i) {
      const double angle = random.uniform(0, 2 * plant::kPi);
      pushes_.push_back({random.uniform(1.0, kLength_s - 1.0), std::cos(angle), std::sin(angle)});
    }
  }
  std::vector<double> goals(double t) const {
    std::vector<double> out;
    for (const LinkSpec& l : truth_.legs.links) out.push_back(goal_of(l, motion_, t));
    return out;
  }
  /// What the drives hold: later, and as their encoders count.
  void command(double t, mjData& d) {
    const long sent = std::lround(std::floor((t - truth_.delay_s) / kRow_s + 1e-9));
    if (sent == held_) return;
    held_ = sent;
    const std::vector<double> goal = goals(static_cast<double>(sent) * kRow_s), first = goals(0.0);
    for (std::size_t j = 0; j < goal.size(); ++j) {
      const std::size_t next = neighbour_of(j);
      d.ctrl[j] =
          goal[j] - truth_.drives[j].zero + truth_.drives[j].leak * (goal[next] - first[next]);
    }
  }
  void pull(double t, int trunk, mjData& d) const {
    for (std::size_t j = 0; j < truth_.drives.size(); ++j)
      d.qfrc_applied[6 + j] =
          truth_.drives[j].hum * std::sin(2 * plant::kPi * truth_.drives[j].hum_hz * t);
    const double blow = truth_.fan * std::sin(2 * plant::kPi * truth_.fan_hz * t);
    const Vec3 ahead = plant::rotate({d.qpos[3], d.qpos[4], d.qpos[5], d.qpos[6]}, {1, 0, 0});
    Vec3 force = blow * ahead;
    for (const Push& p : pushes_) {
      if (t >= p.at && t < p.at + truth_.push.length)
        force = force + truth_.push.force * Vec3{p.x, p.y, 0};
    }
    std::copy(force.begin(), force.end(), d.xfrc_applied + static_cast<std::ptrdiff_t>(6) * trunk);
  }

 private:
  /// The joint after it in its leg; of the last, the one before: a goal that never moves leaks
  /// nothing.
  std::size_t neighbour_of(std::size_t j) const {
    const auto& links = truth_.legs.links;
    const bool last = j + 1 == links.size() || links[j + 1].joint[0] != links[j].joint[0];
    return last ? j - 1 : j + 1;
  }
  struct Push {
    double at, x, y;
  };
  const FloorTruth& truth_;
  const FloorMotion& motion_;
  std::vector<Push> pushes_;
  long held_ = std::numeric_limits<long>::min();  // row whose goals the drives hold
};

/// Puts the robot down from just above the floor.
void put_down(const mjModel& m, mjData& d) {
  mj_forward(&m, &d);
  double lowest = 1e9;
  for (int g = 0; g < m.ngeom; ++g) {
    if (m.geom_type[g] == mjGEOM_BOX) lowest = std::min(lowest, d.geom_xpos[3 * g + 2]);
  }
  d.qpos[2] -= lowest - kSoleHalf[2] - 0.002;
}

/// Upright enough to go on.
bool stands(const mjData& d) {
  constexpr double kFallen = 0.88;  // cosine of half a radian
  return plant::rotate({d.qpos[3], d.qpos[4], d.qpos[5], d.qpos[6]}, {0, 0, 1})[2] > kFallen;
}

}  // namespace

FloorTruth nominal_floor() {
  FloorTruth out;
  out.legs = make_robot("op3-stand");
  // the trunk alone: arms and head of about their own mass again, a little higher
  const auto& links = plant::op3_body().links;
  const auto trunk =
      std::find_if(links.begin(), links.end(), [](const auto& l) { return l.name == "body_link"; });
  out.trunk = {trunk->mass_kg + 0.6,
               trunk->com_m + Vec3{0.01, 0, 0.03},
               {2 * trunk->ixx, 2 * trunk->iyy, 2 * trunk->izz, 0, 0, 0}};
  out.payload_at = {0.0, 0.0, 0.1};
  out.drives.resize(out.legs.links.size());
  return out;
}

recording::Recording run_on_floor(const FloorTruth& truth, const FloorMotion& motion,
                                  std::uint64_t seed) {
  const plant::ModelPtr model = plant::compile_mjcf(mjcf(truth), "floor");
  const plant::DataPtr data(mj_makeData(model.get()));
  Hand hand(truth, motion, seed);
  const std::vector<double> start = hand.goals(0.0);
  std::copy(start.begin(), start.end(), data->qpos + 7);
  data->qpos[3] = std::cos(0.5 * motion.heading), data->qpos[6] = std::sin(0.5 * motion.heading);
  put_down(*model, *data);
  const int trunk = mj_name2id(model.get(), mjOBJ_BODY, "trunk");
  Logger log(truth, seed);
  const auto every = std::lround(kRow_s / kFloorStep_s);
  const long settle = std::lround(kFloorSettle_s / kFloorStep_s);
  const long steps = settle + std::lround(kLength_s / kFloorStep_s);
  for (long step = 0; step < steps && stands(*data); ++step) {
    const double t = static_cast<double>(step - settle) * kFloorStep_s;
    hand.command(t, *data);
    hand.pull(t, trunk, *data);
    if (step % every == 0 && step >= settle) {
      mj_forward(model.get(), data.get());
      log.row(*model, *data, t, hand.goals(t));
    }
    mj_step(model.get(), data.get());
  }
  recording::Recording out = log.take();
  out.file = motion.name + ".csv", out.condition = motion.condition;
  return out;
}

std::string floor_urdf(const FloorTruth& nominal) {
  std::string urdf = to_urdf(nominal.legs);
  const double* i = nominal.trunk.inertia;
  const std::string trunk = fmt::format(
      "<link name=\"base\">\n    <inertial>\n      <origin xyz=\"{}\"/>\n      <mass "
      "value=\"{:.9g}\"/>\n      <inertia ixx=\"{:.9g}\" iyy=\"{:.9g}\" izz=\"{:.9g}\" "
      "ixy=\"{:.9g}\" ixz=\"{:.9g}\" iyz=\"{:.9g}\"/>\n    </inertial>\n  </link>",
      text(nominal.trunk.com), nominal.trunk.mass, i[0], i[1], i[2], i[3], i[4], i[5]);
  const std::string empty = "<link name=\"base\"/>";
  urdf.replace(urdf.find(empty), empty.size(), trunk);
  for (const LinkSpec& l : nominal.legs.links) {
    if (!is_foot(l)) continue;
    const std::size_t at = urdf.find("</link>", urdf.find("<link name=\"" + l.link + "\">"));
    urdf.insert(at, fmt::format("  <collision>\n      <origin xyz=\"{}\"/>\n      <geometry><box "
                                "size=\"{}\"/></geometry>\n    </collision>\n  ",
                                text(sole_at(l.joint[0] == 'l')), text(2.0 * kSoleHalf)));
  }
  return urdf;
}

}  // namespace sanso::conceal
