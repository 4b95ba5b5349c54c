// One function a command; a mistake in it becomes an answer with "error", never an end of the
// emulator.
#include "tools/emulator/control.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace sanso::emulator {
namespace {

using nlohmann::json;

struct CommandError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

json truth_json(const Truth& t) {
  return {{"ok", true},
          {"time_s", to_seconds(t.time)},
          {"p_world_base", t.p_world_base},
          {"quat_world_base", t.quat_world_base},
          {"v_base_in_world", t.v_base_in_world},
          {"w_base_in_base", t.w_base_in_base},
          {"q", t.q},
          {"dq", t.dq},
          {"torque", t.torque},
          {"torque_on", t.torque_on},
          {"foot_force_in_world", t.foot_force_in_world},
          {"foot_contacts", t.foot_contacts},
          {"foot_clearance_m", t.foot_clearance_m},
          {"other_contacts", t.other_contacts},
          {"supply_V", t.supply_V},
          {"leg_state", t.leg_state()}};
}

void place(EmulatedRobot& robot, const json& command) {
  Placement p = walkready();
  if (command.contains("leg_angles")) {
    p = with_legs(command.at("leg_angles").get<std::array<double, 12>>());
  } else if (const std::string pose = command.value("pose", "walkready"); pose == "crouch") {
    p = crouch();
  } else if (pose != "walkready") {
    throw CommandError("pose '" + pose + "': expected walkready or crouch");
  }
  p.x_m = command.value("x", 0.0);
  p.y_m = command.value("y", 0.0);
  p.yaw_rad = command.value("yaw", 0.0);
  robot.place(p);
  if (command.value("held", false)) robot.hold_until_standing();
}

void add_fault(EmulatedRobot& robot, const json& command) {
  const std::string name = command.at("kind").get<std::string>();
  const auto kind = fault_from_string(name);
  if (!kind) {
    std::string known;
    for (const FaultKind k : all_fault_kinds())
      known += fmt::format("{}{}", known.empty() ? "" : ", ", to_string(k));
    throw CommandError("fault '" + name + "': expected one of " + known);
  }
  Fault fault;
  fault.kind = *kind;
  fault.id = command.value("id", 0);
  fault.start = robot.now() + from_seconds(command.value("after_s", 0.0));
  if (command.contains("duration_s"))
    fault.stop = fault.start + from_seconds(command.at("duration_s").get<double>());
  fault.probability = command.value("probability", 1.0);
  fault.amount = command.value("amount", 0.0);
  robot.faults().add(fault);
}

void push(EmulatedRobot& robot, const json& command) {
  const Nanoseconds start = robot.now() + from_seconds(command.value("after_s", 0.0));
  robot.push(command.value("force", plant::Vec3{}), command.value("torque", plant::Vec3{}), start,
             start + from_seconds(command.value("duration_s", 0.1)));
}

ProcessRequest run(EmulatedRobot& robot, const std::string& name, const json& command) {
  if (name == "place") {
    place(robot, command);
  } else if (name == "hold") {
    robot.hold(true);
  } else if (name == "release") {
    robot.hold(false);
  } else if (name == "push") {
    push(robot, command);
  } else if (name == "fault") {
    add_fault(robot, command);
  } else if (name == "clear_faults") {
    robot.faults().clear();
  } else if (name == "press") {
    robot.press(static_cast<std::uint8_t>(command.at("buttons").get<int>()));
  } else if (name == "unplug_bus") {
    return ProcessRequest::unplug_bus;
  } else if (name == "replug_bus") {
    return ProcessRequest::replug_bus;
  } else if (name == "quit") {
    return ProcessRequest::quit;
  } else if (name != "truth") {
    throw CommandError(
        "command '" + name +
        "': expected truth, place, hold, release, push, fault, clear_faults, press, unplug_bus, "
        "replug_bus or quit");
  }
  return ProcessRequest::none;
}

}  // namespace

ControlAnswer execute_command(EmulatedRobot& robot, const std::string& text) {
  try {
    const json command = json::parse(text);
    const std::string name = command.at("command").get<std::string>();
    const ProcessRequest request = run(robot, name, command);
    const json answer = name == "truth" ? truth_json(robot.truth()) : json{{"ok", true}};
    return {answer.dump(), request};
  } catch (
      const std::exception& error) {  // malformed JSON, missing key, wrong type, our own refusals
    return {json{{"ok", false}, {"error", error.what()}}.dump(), ProcessRequest::none};
  }
}

}  // namespace sanso::emulator
