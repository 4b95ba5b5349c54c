// In a servo period: limits of the goal, loop on encoder counts, whole steps of PWM. Then motor,
// friction and gear in small explicit steps.
#include "tools/conceal/hidden_joint.h"

#include <algorithm>
#include <cmath>

#include "tools/conceal/hidden_friction.h"

namespace sanso::conceal {
namespace {

constexpr double kToothStiffness = 2500;  // N m/rad, where a gear has play but no given compliance
constexpr double kToothDamping = 1.0;     // N m s/rad

constexpr double kContact = 8e4;     // N m/rad^1.5: as stiff as the springs at half a milliradian
constexpr double kContactLoss = 20;  // s/rad
constexpr double kLongestPoll = 0.0073;  // s, no multiple of any period of the bus

/// Torque of teeth that are pressed together by `stretch` at `rate`; they only push.
double tooth_torque(const JointTruth& j, double stretch, double rate) {
  if (stretch == 0 && j.backlash > 0) return 0;
  if (j.compliance == 0 && j.formulas.teeth == Teeth::hertzian) {
    const double depth = std::abs(stretch), approach = stretch > 0 ? rate : -rate;
    return std::copysign(
        kContact * depth * std::sqrt(depth) * std::max(0.0, 1 + kContactLoss * approach), stretch);
  }
  const double k = j.compliance > 0 ? 1 / j.compliance : kToothStiffness;
  const double d = j.compliance > 0 ? j.compliance_damping : kToothDamping;
  const double torque = k * stretch + d * rate;
  return j.backlash > 0 && torque * stretch < 0 ? 0 : torque;
}

double limited_goal(const JointTruth& j, double goal, double period_s, JointMemory& m) {
  if (!m.started) m.profile = goal;
  if (j.profile_speed >= 1e9 && j.profile_acceleration >= 1e9) return m.profile = goal;
  const double distance = goal - m.profile;
  const double reach = std::sqrt(2 * std::min(j.profile_acceleration, 1e6) * std::abs(distance));
  double wanted =
      std::copysign(std::min({j.profile_speed, reach, std::abs(distance) / period_s}), distance);
  const double change = j.profile_acceleration * period_s;
  wanted = std::clamp(wanted, m.profile_rate - change, m.profile_rate + change);
  m.profile_rate = wanted;
  return m.profile += wanted * period_s;
}

}  // namespace

bool two_masses(const JointTruth& joint) { return joint.backlash > 0 || joint.compliance > 0; }

double instant_of_command(const JointTruth& j, double t) {
  if (j.formulas.mailbox == Mailbox::at_once || j.command_delay_s <= 0)
    return t - j.command_delay_s;
  // a command waits half a poll on average; the rest of the delay is its way
  const double poll = std::min(j.command_delay_s, kLongestPoll);
  return std::floor(t / poll) * poll - (j.command_delay_s - 0.5 * poll);
}

double encoder_angle(const JointTruth& j, double q) {
  return (1 + j.encoder_scale) * q + j.offset + j.encoder_sine * std::sin(q) +
         j.encoder_cosine * std::cos(q);
}

double recorded_angle(const JointTruth& j, double q) {
  return encoder_angle(j, q) + j.record_offset;
}

void run_servo(const JointTruth& j, double goal, bool on, double link_angle, double period_s,
               JointMemory& m) {
  const double counts = std::round(encoder_angle(j, link_angle) / j.quantum);
  const double aim = limited_goal(j, goal, period_s, m);
  const double error = std::round(aim / j.quantum) * j.quantum - counts * j.quantum;
  const double goal_rate = m.started ? (aim - m.last_goal) / period_s : 0;
  m.goal_rate += 0.2 * (goal_rate - m.goal_rate);
  m.last_goal = aim;
  m.integral = on ? m.integral + error * period_s : 0;
  double duty = j.p_gain * error * (1 - j.gain_softening * error * error) + j.i_gain * m.integral +
                j.feed_forward * m.goal_rate - j.d_gain * m.motor_rate;
  if (j.dead_zone > 0) duty = std::copysign(std::max(0.0, std::abs(duty) - j.dead_zone), duty);
  m.filtered += (duty - m.filtered) *
                (j.output_filter_s > 0 ? 1 - std::exp(-period_s / j.output_filter_s) : 1);
  const double whole = std::round(kPwmSteps * std::clamp(m.filtered, -j.duty_limit, j.duty_limit));
  m.duty = on ? whole / kPwmSteps : 0;
  m.started = true;
}

double run_gear(const JointTruth& j, double supply_V, bool on, double link_angle, double link_rate,
                double external, double h, JointMemory& m) {
  const bool split = two_masses(j);
  const double rate = split ? m.motor_rate : link_rate;
  const double angle = split ? m.motor_angle : link_angle;

  m.current = on ? std::clamp((m.duty * supply_V - j.back_emf * rate) / j.resistance,
                              -j.current_limit, j.current_limit)
                 : 0.0;
  m.motor_torque = j.torque_constant * m.current;
  double drive = m.motor_torque;
  if (j.efficiency < 1) drive *= drive * rate > 0 ? j.efficiency : 1 / j.efficiency;

  m.rest_s = std::abs(rate) < 0.01 ? m.rest_s + h : 0;
  const double level = friction_level(j, rate, angle, m.motor_torque, external, m.rest_s);
  double friction = dry_friction(j, rate, level, h, m.bristle);
  friction += (j.viscous + (rate >= 0 ? 1 : -1) * j.viscous_difference) * rate;
  friction += j.angle_damping * std::sin(link_angle) * std::sin(link_angle) * rate;
  friction += j.air_drag * std::abs(rate) * rate;

  // springs and ripple that lose nothing
  m.creep_angle += (link_angle - m.creep_angle) * h / j.creep_time_s;
  double passive = -j.spring * link_angle + j.spring_torque -
                   j.cubic_spring * link_angle * link_angle * link_angle -
                   j.creep_spring * (link_angle - m.creep_angle);
  passive += j.cogging_sine * std::sin(j.cogging_order * angle) +
             j.cogging_cosine * std::cos(j.cogging_order * angle);
  passive -=
      j.stop_side * j.stop_stiffness * std::max(0.0, j.stop_side * (link_angle - j.stop_position));

  if (!split) {
    m.motor_rate = link_rate;
    m.motor_angle = link_angle;
    return drive - friction + passive;
  }
  // motor and link are two masses; the teeth push outside the play
  const double gap = m.motor_angle - link_angle;
  const double stretch = gap - std::clamp(gap, -0.5 * j.backlash, 0.5 * j.backlash);
  const double teeth = tooth_torque(j, stretch, m.motor_rate - link_rate);
  m.gear_torque = teeth;
  m.motor_rate += h * (drive - friction - teeth) / j.armature;
  m.motor_angle += h * m.motor_rate;
  return teeth + passive;
}

}  // namespace sanso::conceal
