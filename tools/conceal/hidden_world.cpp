// MuJoCo for the links, hidden_joint for the drives, and the log as a real robot would write it:
// quantised, noisy, late.
#include "tools/conceal/hidden_world.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "tools/plant/mujoco_model.h"

namespace sanso::conceal {
namespace {

constexpr double kStep_s = 0.0002;
constexpr int kServoEvery = 5;     // steps: the servo's loop runs at 1 kHz
constexpr double kSettle_s = 2.0;  // on the first command, before the recording begins
constexpr double kVoltQuantum = 0.1;

/// The command as each servo gets it: delayed, held, sometimes lost.
class CommandLine {
 public:
  CommandLine(const WorldTruth& world, const Experiment& experiment, Random& random)
      : experiment_(experiment) {
    const std::size_t rows = experiment.command.size();
    for (int j = 0; j < world.robot.size(); ++j) {
      const JointTruth& joint = world.joints[static_cast<std::size_t>(j)];
      std::vector<std::size_t> source(rows);
      for (std::size_t row = 0; row < rows; ++row) {
        const bool taken =
            row % static_cast<std::size_t>(joint.hold_cycles) == 0 && !random.chance(joint.loss);
        source[row] = row == 0 || taken ? row : source[row - 1];
      }
      source_.push_back(std::move(source));
      joints_.push_back(joint);
      skew_.push_back(j * world.bus_skew_s);
    }
  }
  double goal(int joint, double t) const {
    const auto j = static_cast<std::size_t>(joint);
    const double row =
        std::floor(instant_of_command(joints_[j], t - skew_[j]) / kControlPeriod_s + 1e-9);
    const auto last = static_cast<double>(experiment_.command.size()) - 1;
    return experiment_.command[source_[j][static_cast<std::size_t>(std::clamp(row, 0.0, last))]][j];
  }

 private:
  const Experiment& experiment_;
  std::vector<std::vector<std::size_t>> source_;
  std::vector<JointTruth> joints_;
  std::vector<double> skew_;
};

/// MuJoCo's model of the world with the joints' own masses where they belong.
class Body {
 public:
  Body(const WorldTruth& world, const Experiment& experiment)
      : world_(world), experiment_(experiment) {
    std::vector<double> armature;
    // a motor behind play or compliance is a mass of its own; the last gear stays with the link
    for (const JointTruth& j : world.joints) armature.push_back(two_masses(j) ? 1e-4 : j.armature);
    model_ = plant::compile_mjcf(to_mjcf(world.robot, armature, kStep_s, experiment.gravity),
                                 "the hidden world");
    data_ = plant::DataPtr(mj_makeData(model_.get()));
    for (const LinkSpec& link : world.robot.links) {
      const int joint = mj_name2id(model_.get(), mjOBJ_JOINT, link.joint.c_str());
      qpos_.push_back(model_->jnt_qposadr[joint]);
      dof_.push_back(model_->jnt_dofadr[joint]);
      body_.push_back(mj_name2id(model_.get(), mjOBJ_BODY, link.link.c_str()));
      payload_body_.push_back(
          mj_name2id(model_.get(), mjOBJ_BODY, (link.link + "_payload").c_str()));
    }
    set_payloads(-kSettle_s);
    for (int j = 0; j < world.robot.size(); ++j) data_->qpos[qpos_[j]] = experiment.command[0][j];
    mj_forward(model_.get(), data_.get());
  }

  double angle(int j) const { return data_->qpos[qpos_[j]]; }
  double rate(int j) const { return data_->qvel[dof_[j]]; }
  double external(int j) const { return -data_->qfrc_bias[dof_[j]]; }
  void set_torque(int j, double torque) { data_->qfrc_applied[dof_[j]] = torque; }

  void step(double t) {
    if (world_.payload.link >= 0 && !late_on_ && t >= world_.payload.from_s) set_payloads(t);
    for (const LinkForce* force : {&world_.push, &world_.tether}) {
      if (force->link < 0) continue;
      const bool on = t >= force->from_s && t < force->until_s;
      double* wrench = data_->xfrc_applied + 6 * body_[static_cast<std::size_t>(force->link)];
      for (int i = 0; i < 3; ++i) wrench[i] = on ? force->force[static_cast<std::size_t>(i)] : 0;
    }
    mj_step(model_.get(), data_.get());
  }

 private:
  void set_payloads(double t) {
    std::vector<double> mass(body_.size(), 1e-9);
    if (experiment_.payload_kg > 0)
      mass[static_cast<std::size_t>(world_.robot.payload_link)] += experiment_.payload_kg;
    if (world_.payload.link >= 0 && t >= world_.payload.from_s) {
      mass[static_cast<std::size_t>(world_.payload.link)] += world_.payload.mass;
      late_on_ = true;
    }
    for (std::size_t i = 0; i < mass.size(); ++i) model_->body_mass[payload_body_[i]] = mass[i];
  }

  const WorldTruth& world_;
  const Experiment& experiment_;
  plant::ModelPtr model_;
  plant::DataPtr data_;
  std::vector<int> qpos_, dof_, body_, payload_body_;
  bool late_on_ = false;
};

/// Values of one signal at every step, to be read at any instant.
struct Track {
  std::vector<double> values;
  double at(double t) const {
    const double x = std::clamp(t / kStep_s, 0.0, static_cast<double>(values.size() - 1));
    const auto i = std::min(static_cast<std::size_t>(x), values.size() - 2);
    return values[i] + (x - static_cast<double>(i)) * (values[i + 1] - values[i]);
  }
};

/// What every step of an experiment left behind.
struct Log {
  explicit Log(int joints)
      : q(static_cast<std::size_t>(joints)), dq(q.size()), current(q.size()), duty(q.size()) {}
  std::vector<Track> q, dq, current, duty;
  Track volt;
};

long steps_in(double seconds) { return std::lround(seconds / kStep_s); }

/// The experiment in steps of the physics: first the settling, which nobody records.
class Run {
 public:
  Run(const WorldTruth& world, const Experiment& experiment, const CommandLine& commands)
      : world_(world),
        commands_(commands),
        body_(world, experiment),
        joints_(world.joints),
        memory_(joints_.size()),
        log_(world.robot.size()) {
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      joints_[j].p_gain *= experiment.gain_scale;
      memory_[j].motor_angle = memory_[j].creep_angle = body_.angle(static_cast<int>(j));
    }
  }

  Log record(long record_steps) {
    const long settle_steps = steps_in(kSettle_s);
    for (long step = -settle_steps; step < record_steps; ++step) {
      const double t = static_cast<double>(step) * kStep_s;
      const double open_circuit =
          1 + world_.supply_level + world_.supply_slope_per_min * std::max(0.0, t) / 60;
      drive(t, open_circuit, (step + settle_steps) % kServoEvery == 0);
      if (step >= 0) note(open_circuit);
      body_.step(t);
    }
    return std::move(log_);
  }

 private:
  /// Servos (when their period is over), gears and supply at one instant.
  void drive(double t, double open_circuit, bool servos_due) {
    double load = 0;
    for (int joint = 0; joint < world_.robot.size(); ++joint) {
      const auto j = static_cast<std::size_t>(joint);
      if (servos_due) {
        run_servo(joints_[j], commands_.goal(joint, t), true, body_.angle(joint),
                  kServoEvery * kStep_s, memory_[j]);
      }
      const double supply = joints_[j].voltage * open_circuit - supply_drop_;
      double torque = run_gear(joints_[j], supply, true, body_.angle(joint), body_.rate(joint),
                               body_.external(joint), kStep_s, memory_[j]);
      if (world_.coupling.to == joint)
        torque -= world_.coupling.viscous * body_.rate(world_.coupling.from);
      body_.set_torque(joint, torque);
      load += std::abs(memory_[j].current * memory_[j].duty);
    }
    supply_drop_ = world_.supply_resistance * load;
  }
  void note(double open_circuit) {
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      log_.q[j].values.push_back(body_.angle(static_cast<int>(j)));
      log_.dq[j].values.push_back(body_.rate(static_cast<int>(j)));
      log_.current[j].values.push_back(memory_[j].current);
      log_.duty[j].values.push_back(memory_[j].duty);
    }
    log_.volt.values.push_back(joints_[0].voltage * open_circuit - supply_drop_);
  }

  const WorldTruth& world_;
  const CommandLine& commands_;
  Body body_;
  std::vector<JointTruth> joints_;
  std::vector<JointMemory> memory_;
  Log log_;
  double supply_drop_ = 0;
};

/// One joint's channels as its sensors see them: late, at uneven instants, filtered.
void sense_joint(const JointTruth& joint, const Log& log, std::size_t j, std::size_t rows,
                 long record_steps, Random& random, Signals& out) {
  std::vector<double> q(rows), dq(rows), current(rows), duty(rows);
  double filtered = log.dq[j].at(0);
  for (std::size_t row = 0; row < rows; ++row) {
    const double stamp = static_cast<double>(row) * kControlPeriod_s;
    const double t = stamp - joint.sensor_delay_s + joint.jitter_s * random.normal();
    const double blend =
        joint.velocity_filter_s > 0 ? 1 - std::exp(-kControlPeriod_s / joint.velocity_filter_s) : 1;
    filtered += blend * (log.dq[j].at(t) - filtered);
    q[row] = recorded_angle(joint, log.q[j].at(t));
    dq[row] = filtered;
    current[row] = log.current[j].at(t);
    duty[row] = log.duty[j].values[static_cast<std::size_t>(
        std::clamp(t / kStep_s, 0.0, static_cast<double>(record_steps - 1)))];
  }
  out.q.push_back(std::move(q));
  out.dq.push_back(std::move(dq));
  out.current.push_back(std::move(current));
  out.duty.push_back(std::move(duty));
}

/// Rounded to whole quanta, without -0.
double on_grid(double value, double quantum) { return std::round(value / quantum) * quantum + 0.0; }

/// The columns of one joint, as its logger writes them.
void add_joint(const WorldTruth& world, const Experiment& experiment, const Signals& signals,
               std::size_t j, bool electrical_channels, Random& random, recording::Recording& r) {
  const std::string& name = world.robot.links[j].joint;
  const double quantum = world.joints[j].quantum;
  const std::size_t rows = experiment.command.size();
  std::vector<double> u(rows), q(rows), dq(rows), current(rows), pwm(rows);
  for (std::size_t row = 0; row < rows; ++row) {
    u[row] = on_grid(experiment.command[row][j], quantum);
    q[row] = on_grid(signals.q[j][row], quantum);
    dq[row] = on_grid(signals.dq[j][row], kRateQuantum);
    current[row] =
        on_grid(signals.current[j][row] + kCurrentQuantum * random.normal(), kCurrentQuantum);
    pwm[row] = std::round(signals.duty[j][row] * kPwmSteps) / kPwmSteps;
  }
  r.set("u:" + name, std::move(u));
  r.set("q:" + name, std::move(q));
  r.set("dq:" + name, std::move(dq));
  if (!electrical_channels) return;
  r.set("i:" + name, std::move(current));
  r.set("pwm:" + name, std::move(pwm));
}

/// What was different in this experiment: gain, gravity, payload.
void add_conditions(const WorldTruth& world, const Experiment& experiment,
                    recording::Recording& r) {
  if (experiment.gain_scale != 1.0) {
    recording::Override gain;
    gain.table = "joint_default";
    gain.key = "p_gain";
    gain.numbers = {JointTruth{}.p_gain * experiment.gain_scale};
    r.overrides.push_back(gain);
  }
  if (experiment.gravity[0] != 0) {
    recording::Override gravity;
    gravity.table = "robot";
    gravity.key = "gravity";
    gravity.numbers = {experiment.gravity[0], experiment.gravity[1], experiment.gravity[2]};
    r.overrides.push_back(gravity);
  }
  if (experiment.payload_kg > 0) {
    const LinkSpec& link = world.robot.links[static_cast<std::size_t>(world.robot.payload_link)];
    r.payloads.push_back({link.link,
                          experiment.payload_kg,
                          {link.payload_at[0], link.payload_at[1], link.payload_at[2]}});
  }
}

}  // namespace

Signals run_experiment(const WorldTruth& world, const Experiment& experiment, std::uint64_t seed) {
  const std::size_t rows = experiment.command.size();
  Random random(seed);
  const CommandLine commands(world, experiment, random);
  const long record_steps = steps_in(static_cast<double>(rows) * kControlPeriod_s + 0.05);
  const Log log = Run(world, experiment, commands).record(record_steps);

  Signals s;
  s.volt.resize(rows);
  for (std::size_t row = 0; row < rows; ++row)
    s.volt[row] = log.volt.at(static_cast<double>(row) * kControlPeriod_s);
  for (std::size_t j = 0; j < world.joints.size(); ++j)
    sense_joint(world.joints[j], log, j, rows, record_steps, random, s);
  return s;
}

recording::Recording as_recording(const WorldTruth& world, const Experiment& experiment,
                                  const Signals& signals, std::uint64_t seed,
                                  bool electrical_channels) {
  Random random(seed ^ 0xB05);
  const std::size_t rows = experiment.command.size();
  recording::Recording r;
  r.file = experiment.name + ".csv";
  r.condition = experiment.condition;
  for (std::size_t row = 0; row < rows; ++row)
    r.t.push_back(static_cast<double>(row) * kControlPeriod_s);
  for (std::size_t j = 0; j < world.joints.size(); ++j)
    add_joint(world, experiment, signals, j, electrical_channels, random, r);
  if (electrical_channels) {
    std::vector<double> volt(rows);
    for (std::size_t row = 0; row < rows; ++row)
      volt[row] = on_grid(signals.volt[row], kVoltQuantum);
    r.set("volt", std::move(volt));
  }
  add_conditions(world, experiment, r);
  return r;
}

}  // namespace sanso::conceal
