// The list of all families in the order of the draws, and how an entry is made: the answer's id and
// place come from the entry, its parameters from what was changed.
#include "tools/conceal/hideable.h"

#include "tools/conceal/hideable_families.h"
#include "tools/plant/world_error.h"

namespace sanso::conceal {

using Scope = Hideable::Scope;

JointTruth& joint(WorldTruth& world, int at) { return world.joints[static_cast<std::size_t>(at)]; }
LinkSpec& link(WorldTruth& world, int at) {
  return world.robot.links[static_cast<std::size_t>(at)];
}
double sign(Random& random) { return random.chance(0.5) ? 1.0 : -1.0; }

Hideable on_joint(std::string id, double typical, double largest,
                  std::function<Parameters(JointTruth&, double size, Random&)> change,
                  std::vector<std::string> twins) {
  const std::string name = id;
  return {std::move(id),
          Scope::joint,
          typical,
          largest,
          true,
          [name, change](WorldTruth& world, int at, double size, Random& random) {
            JointTruth& there = joint(world, at);
            const double before = there.coulomb;
            HiddenEffect hidden{name, {link(world, at).joint}, change(there, size, random)};
            if (!hidden.parameters.contains("coulomb"))
              hidden.coulomb_beside = there.coulomb - before;
            return hidden;
          },
          std::move(twins)};
}

Hideable on_link(std::string id, double typical, double largest,
                 std::function<Parameters(WorldTruth&, int at, double size, Random&)> change) {
  const std::string name = id;
  return {std::move(id),
          Scope::link,
          typical,
          largest,
          true,
          [name, change](WorldTruth& world, int at, double size, Random& random) {
            return HiddenEffect{name, {link(world, at).link}, change(world, at, size, random)};
          },
          {}};
}

Hideable on_robot(std::string id, double typical, double largest,
                  std::function<Parameters(WorldTruth&, double size, Random&)> change,
                  std::vector<std::string> twins) {
  const std::string name = id;
  return {std::move(id),
          Scope::robot,
          typical,
          largest,
          true,
          [name, change](WorldTruth& world, int, double size, Random& random) {
            return HiddenEffect{name, {}, change(world, size, random)};
          },
          std::move(twins)};
}

Hideable outside(std::string id, double typical, double largest,
                 std::function<void(WorldTruth&, int at, double size, Random&)> change) {
  const std::string name = id;
  return {std::move(id),
          Scope::joint,
          typical,
          largest,
          false,
          [name, change](WorldTruth& world, int at, double size, Random& random) {
            change(world, at, size, random);
            return HiddenEffect{name, {link(world, at).joint}, {{"size", size}}};
          },
          {}};
}

const std::vector<Hideable>& hideables() {
  static const std::vector<Hideable> all = [] {
    std::vector<Hideable> out;
    for (auto make : {friction_of_speed_and_load, friction_of_side_and_memory, gear_effects,
                      effects_at_the_joint, mass_effects, servo_gain_effects,
                      limit_and_supply_effects, clock_and_sensor_effects, outside_effects}) {
      for (Hideable& h : make()) out.push_back(std::move(h));
    }
    return out;
  }();
  return all;
}

const Hideable& hideable(const std::string& id) {
  for (const Hideable& h : hideables()) {
    if (h.id == id) return h;
  }
  throw plant::WorldError("no effect '" + id + "' can be hidden; docs/howto/conceal.md lists them");
}

}  // namespace sanso::conceal
