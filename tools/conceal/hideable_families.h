// The families of hideable effects and what their entries are made with. The order of a family is
// part of every case: a case draws an effect by its place.
#pragma once

#include "tools/conceal/hideable.h"

namespace sanso::conceal {

using Parameters = std::map<std::string, double>;

JointTruth& joint(WorldTruth& world, int at);
LinkSpec& link(WorldTruth& world, int at);
/// +1 or -1, equally likely.
double sign(Random& random);

/// An effect of one joint: `change` sets the joint and returns the parameters by name.
Hideable on_joint(std::string id, double typical, double largest,
                  std::function<Parameters(JointTruth&, double size, Random&)> change,
                  std::vector<std::string> twins = {});
/// An effect of one link.
Hideable on_link(std::string id, double typical, double largest,
                 std::function<Parameters(WorldTruth&, int at, double size, Random&)> change);
/// An effect of the whole robot.
Hideable on_robot(std::string id, double typical, double largest,
                  std::function<Parameters(WorldTruth&, double size, Random&)> change,
                  std::vector<std::string> twins = {});
/// An effect of one joint that the diagnosis's library does not hold.
Hideable outside(std::string id, double typical, double largest,
                 std::function<void(WorldTruth&, int at, double size, Random&)> change);

std::vector<Hideable> friction_of_speed_and_load();
std::vector<Hideable> friction_of_side_and_memory();
std::vector<Hideable> gear_effects();
std::vector<Hideable> effects_at_the_joint();
std::vector<Hideable> mass_effects();
std::vector<Hideable> servo_gain_effects();
std::vector<Hideable> limit_and_supply_effects();
std::vector<Hideable> clock_and_sensor_effects();
std::vector<Hideable> outside_effects();

}  // namespace sanso::conceal
