// The words of docs/faults.md: what each number means and where to look. Numbers, names, reactions
// and the table of states come from the code itself.
#pragma once

#include <array>

#include "firmware/exchange/faults.h"

namespace sanso::firmware {

struct FaultWords {
  Fault fault;
  const char* meaning;
  const char* look_at;
};

inline constexpr std::array kFaultWords{
    FaultWords{
        Fault::bus_silent,
        "No leg servo has given a good reply for `bus.silent_ticks` ticks (0.1 s).",
        "bus cable between computer and hips, servo supply (OpenCR's switch), another program"
        " on the bus."},
    FaultWords{
        Fault::servo_silent,
        "One leg servo has been silent for `bus.silent_ticks` ticks while others answer; "
        "during stand-up, one of arms and head too. A reply that cannot be true (error byte, "
        "a jump of more than 0.5 rad in a tick, an angle outside the encoder) counts as none; "
        "without torque a joint that stays where it jumped to is believed after five readings."
        " Detail: its id.",
        "the plug of that servo and of the one before it in the chain; a servo that reboots "
        "by itself has a supply problem."},
    FaultWords{
        Fault::bus_gone,
        "The serial device reports an error: unplugged, or the emulator's pty has gone. "
        "Nothing can be sent; the servos hold their last goal.",
        "plug in again: a helper thread opens the port again within a second and the program "
        "says so. Then `lower`, then clear the fault."},
    FaultWords{
        Fault::power_switch,
        "The OpenCR board (id 200) did not confirm that the servo supply is on. Detail: 200.",
        "battery, OpenCR's power, baud rate. Without an OpenCR set `bus.require_opencr = "
        "false`."},
    FaultWords{
        Fault::servo_missing, "A servo did not answer for 2 s at start. Detail: its id.",
        "its plug, its id, its baud rate: `sanso-firmware --config FILE --self-test` looks for it "
        "at every speed."},
    FaultWords{Fault::servo_model, "A servo is not an XM430-W350 (model 1020). Detail: its id.",
               "the id table; another servo type needs other limits and gains, so it is refused."},
    FaultWords{
        Fault::servo_register,
        "A register does not hold what was written, or the EEPROM has another return delay, "
        "operating or drive mode than the controller needs; a start writes nothing there. Or a "
        "servo of a robot that is found standing contradicts itself about its torque, or names a "
        "goal where its joint cannot be. Detail: the servo's id.",
        "`sanso-firmware --config FILE --self-test` shows what differs, with `--write-eeprom` it "
        "writes it. A servo in hardware shutdown refuses torque settings: reboot it (F21)."},
    FaultWords{
        Fault::bus_foreign,
        "Another program is on the servo bus: before the first request a whole packet, bytes in "
        "two ticks or ten at once (detail: how many bytes; a single crackle only makes it listen "
        "anew), or later a whole instruction that is not ours. At the start nothing has been sent.",
        "stop the other program (on an OP3: the demo service), then clear."},
    FaultWords{
        Fault::over_temperature,
        "A servo is at `guard.max_temperature_C` or reports overheating. Detail: its id.",
        "let it cool with torque off; look for a joint that carries weight in the held pose."},
    FaultWords{
        Fault::overload,
        "A servo reports overload and has switched its torque off. Detail: its id.",
        "what blocked the joint; then lower, and reboot the servo (`sanso-firmware --config FILE "
        "--self-test --reboot`) or switch the supply off and on: only these clear a servo's "
        "shutdown."},
    FaultWords{Fault::servo_hardware,
               "A servo reports an encoder or power-stage error. Detail: its id.",
               "supply off and on; if it comes back, the servo is broken."},
    FaultWords{Fault::under_voltage,
               "Every new reading of the supply, whichever servo gave it, was under "
               "`guard.min_voltage_V` for `guard.voltage_time_s`. Detail: 0.1 V.",
               "charge the battery; check the plug of the DC adapter."},
    FaultWords{Fault::over_voltage, "The same over `guard.max_voltage_V`. Detail: 0.1 V.",
               "the supply."},
    FaultWords{
        Fault::torque_lost,
        "A servo says that its torque is off although it was switched on: it has rebooted or "
        "shut down. Detail: its id.",
        "supply dips (limit voltage before?), then clear: start-up writes all gains again."},
    FaultWords{
        Fault::imu_silent,
        "No complete IMU sample for `imu.silent_s`, or none within 3 s of the start.",
        "what the program printed about the sensor (absent, or what it is instead); "
        "`sanso-firmware --devices`; the kernel's sensor hub must not claim it, or use "
        "`hidapi-libusb:` (docs/howto/robot.md). A sensor that comes back is switched on again by "
        "itself."},
    FaultWords{Fault::imu_frozen,
               "The IMU repeats one sample, bit for bit, for `imu.frozen_s`. A living sensor has "
               "noise.",
               "the sensor's supply and cable; unplug it and plug it in again: it is opened and "
               "switched on anew."},
    FaultWords{
        Fault::imu_implausible,
        "The IMU does not tell of this robot. Detail 1: its mean specific force is not 9.81 "
        "m/s^2 upwards (units, axes, mounting); 2: its orientation does not turn as its gyro "
        "says (an axis flipped, a jump); 3: while both soles stand, the trunk turns another "
        "way than the legs turn it (mounting turned about z): for 50 ms, or for half a second "
        "once legs and sensor have agreed, because soles that rock over a plate do so for a "
        "moment.",
        "`imu.quat_base_sensor_*`, the sensor's units and axes, its screws."},
    FaultWords{
        Fault::fallen,
        "The trunk is tilted by more than `guard.fall_tilt_rad`, or the base is lower than "
        "`guard.fall_height_m` above the soles, for `guard.fall_time_s`. Detail: tilt in "
        "mrad. The limbs are drawn in softly (30 % duty) for `guard.tuck_s`, then torque off;"
        " the same happens when a robot falls while another fault is latched.",
        "put the robot on its feet, clear, arm."},
    FaultWords{Fault::estimate,
               "The state estimate is not finite or is far from anything possible.",
               "keep the flight record: this is a defect of the program or of a sensor."},
    FaultWords{Fault::emergency_stop,
               "Somebody pressed it: a host's command, a button, or Enter on the controller's "
               "console. Torque off in the same tick.",
               "what was wrong; then put the robot on its feet, clear, arm."},
    FaultWords{Fault::tick_overrun,
               "`guard.overrun_ticks` of the last 100 ticks began late. Detail: how many.",
               "real-time priority and locked memory (the program says at start when it has them "
               "not), other load, a USB adapter with a latency of 16 ms."},
};

struct LimitWords {
  Limit limit;
  const char* meaning;
};

inline constexpr std::array kLimitWords{
    LimitWords{Limit::joint_range,
               "A target was pulled inside the joint limits less `guard.joint_margin_rad`; a joint "
               "found outside comes in at 0.5 rad/s."},
    LimitWords{Limit::joint_rate,
               "A target was slowed to `guard.max_target_rate_rad_s` (arms and head: "
               "`guard.max_held_rate_rad_s`)."},
    LimitWords{Limit::servo_torque,
               "A target was brought nearer to the joint: `guard.max_target_offset_rad`. (What a "
               "motor may use is `guard.max_duty`.)"},
    LimitWords{Limit::current, "A motor current was over `guard.max_current_A`."},
    LimitWords{Limit::temperature, "A servo is warmer than `guard.warm_temperature_C`."},
    LimitWords{Limit::voltage,
               "A servo saw less than `guard.low_voltage_V` at its last reading, or says that its "
               "supply is out of limits."},
    LimitWords{
        Limit::upper_stale,
        "The upper policy is past its last knot and fades out over one of its periods; middle"
        " and lower layer carry on."},
    LimitWords{
        Limit::host_silent,
        "No good datagram of the owner for `supervisor.host_silent_s` while torque is on; in "
        "a trial a soft stop follows, and after `supervisor.left_alone_s` the robot is "
        "lowered."},
    LimitWords{Limit::bus_loss,
               "At least one servo did not answer this tick; its last angle and rate are continued "
               "for three ticks, then held."},
    LimitWords{
        Limit::pose_stale,
        "The pose source has been there and is now more than 10 ticks old; legs and IMU carry"
        " on alone."},
    LimitWords{Limit::imu_late, "The IMU sample in use is older than `imu.late_s`."},
    LimitWords{Limit::tilt, "The trunk is tilted by more than `guard.tilt_limit_rad`."},
    LimitWords{Limit::late_tick, "This tick began more than half a period late."},
    LimitWords{Limit::upper_missing,
               "The trial has its upper layer on, and no policy has come yet: its weight is 0."},
    LimitWords{
        Limit::derated,
        "A servo is warmer than `guard.warm_temperature_C` and gets less of the supply, down "
        "to `guard.hot_duty`."},
};

struct RefusalWords {
  Refusal refusal;
  const char* meaning;
};

inline constexpr std::array kRefusalWords{
    RefusalWords{Refusal::wrong_state,
                 "The present state does not allow the command; the table is below."},
    RefusalWords{Refusal::no_primitives,
                 "No primitives have been uploaded: there is no first pose to stand up to."},
    RefusalWords{Refusal::stale_table,
                 "The middle-layer table belongs to another trial. Upload one with this trial's "
                 "number, or leave the middle layer out of the mask."},
    RefusalWords{
        Refusal::not_upright,
        "The trunk is tilted by more than `guard.tilt_limit_rad`: put the robot on its feet "
        "before arming."},
    RefusalWords{
        Refusal::start_pose,
        "The robot is still moving to the first pose of newly uploaded primitives. Try again "
        "a moment later."},
    RefusalWords{Refusal::torque_on,
                 "The fault is not cleared while the servos hold the robot: it would fall. `lower` "
                 "first (or the emergency stop, when somebody holds it)."},
    RefusalWords{
        Refusal::servo_not_fresh,
        "Not all twenty servos have given good readings in the last ticks: look at cables and"
        " ids."},
    RefusalWords{
        Refusal::imu_not_fresh,
        "No IMU sample of this tick, no estimate yet, or the IMU cannot be believed (F32)."},
    RefusalWords{
        Refusal::joint_range,
        "A joint is more than 0.6 rad outside its range: its horn is mounted turned, or the "
        "offset is wrong."},
    RefusalWords{
        Refusal::goals_unconfirmed,
        "A servo did not confirm its goal or its duty in 20 ticks: nothing was switched on."},
    RefusalWords{
        Refusal::upload_checksum,
        "All pieces came, but the checksum of the whole is wrong. Send it again under a new "
        "number."},
    RefusalWords{
        Refusal::upload_contents,
        "The upload is whole but not valid: wrong length, a number out of range, a quaternion"
        " that is none."},
    RefusalWords{Refusal::upload_size,
                 "The upload is larger than the controller's memory for its kind."},
    RefusalWords{
        Refusal::torque_unconfirmed,
        "A servo did not confirm its torque in 20 ticks: torque is off everywhere again. Look"
        " for a servo in hardware shutdown."},
    RefusalWords{Refusal::no_realtime,
                 "The machine grants no real-time priority or no locked memory. Set the limits, or "
                 "`device.allow_without_realtime = true` where nobody can be hurt."},
    RefusalWords{Refusal::hot_or_low,
                 "A servo is warm (`guard.warm_temperature_C`), its supply is low "
                 "(`guard.low_voltage_V`) or it reports an error: not a moment to stand up."},
    RefusalWords{Refusal::ending, "The program is about to end."},
    RefusalWords{
        Refusal::stale_command,
        "The command answers an observation that is more than 0.5 s old: it was long on its "
        "way. Look at where the robot is now and send it again."},
    RefusalWords{
        Refusal::not_owner,
        "Another host owns the robot; this one may watch (and stop it by the emergency stop)."
        " Ownership is free 2 s after the owner's last datagram."},
};

}  // namespace sanso::firmware
