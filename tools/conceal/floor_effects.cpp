// Sizes and signs are drawn so that the robot stays on its feet.
#include "tools/conceal/floor_effects.h"

#include <algorithm>
#include <cmath>

namespace sanso::conceal {
namespace {

using nlohmann::json;
using plant::operator*;
using Places = std::vector<std::string>;

json three(const Vec3& v, const char* prefix) {
  const std::string p = prefix;
  return {{p + "x", v[0]}, {p + "y", v[1]}, {p + "z", v[2]}};
}

double either_way(Random& random) { return random.chance(0.5) ? 1.0 : -1.0; }

std::size_t one_joint(const FloorTruth& w, Random& random, Places& where) {
  const std::size_t j = random.bits() % w.legs.links.size();
  where = {w.legs.links[j].joint};
  return j;
}

/// All joints, one leg's, or those whose names begin alike.
template <class Change>
void at_joints(FloorTruth& w, const std::string& begin, Places& where, Change change) {
  for (std::size_t j = 0; j < w.legs.links.size(); ++j) {
    const std::string& name = w.legs.links[j].joint;
    if (!name.starts_with(begin)) continue;
    change(w.drives[j]);
    where.push_back(name);
  }
}

void add_masses(std::vector<FloorEffect>& all) {
  all.push_back(
      {"link_mass", 0.05, true, [](FloorTruth& w, double size, Random& random, Places& where) {
         where = {"base"};
         const double share = size * (size < 0.4 ? either_way(random) : 1.0);
         w.trunk.mass *= 1 + share;
         for (double& i : w.trunk.inertia) i *= 1 + share;
         return json{{"share", share}};
       }});
  all.push_back({"payload", 0.1, true, [](FloorTruth& w, double size, Random&, Places& where) {
                   where = {"base"};
                   w.payload_kg = size;
                   return json{{"mass", size}};
                 }});
  all.push_back(
      {"link_com", 0.004, true, [](FloorTruth& w, double size, Random& random, Places& where) {
         where = {"base"};
         const double forward = size * either_way(random);
         w.trunk.com[0] += forward;
         return json{{"x", forward}, {"y", 0.0}, {"z", 0.0}};
       }});
}

void add_sensors(std::vector<FloorEffect>& all) {
  all.push_back(
      {"foot_force_scale", 0.03, true, [](FloorTruth& w, double size, Random& random, Places&) {
         w.force_scale *= 1 + size * either_way(random);
         return json{{"scale", w.force_scale}};
       }});
  all.push_back(
      {"imu_misalignment", 0.012, true, [](FloorTruth& w, double size, Random& random, Places&) {
         w.imu_turn = size * direction(random);
         // the reading turns the other way
         return three(-1.0 * w.imu_turn, "");
       }});
  all.push_back({"imu_bias", 0.01, true, [](FloorTruth& w, double size, Random& random, Places&) {
                   w.gyro_bias = size * direction(random);
                   return three(w.gyro_bias, "gyro_");
                 }});
  all.push_back({"encoder_offset", 0.004, true,
                 [](FloorTruth& w, double size, Random& random, Places& where) {
                   const double off = size * either_way(random);
                   w.drives[one_joint(w, random, where)].zero += off;
                   return json{{"offset", off}};
                 }});
}

void add_surroundings(std::vector<FloorEffect>& all) {
  all.push_back(
      {"ground_slope", 0.006, true, [](FloorTruth& w, double size, Random& random, Places&) {
         const double angle = random.uniform(0, 2 * plant::kPi);
         w.slope = {size * std::cos(angle), size * std::sin(angle), 0};
         return json{{"x", w.slope[0]}, {"y", w.slope[1]}};
       }});
  all.push_back(
      {"external_push", 0.5, true, [](FloorTruth& w, double size, Random&, Places& where) {
         where = {"base"};
         w.push.force = size;
         return json::object();
       }});
}

void add_drives(std::vector<FloorEffect>& all) {
  all.push_back(
      {"servo_p_gain", 0.06, true, [](FloorTruth& w, double size, Random& random, Places& where) {
         // softer than two thirds the legs give way
         const double gain = 1 + size * (size < 0.3 ? either_way(random) : 1.0);
         const char* legs[] = {"", "", "l_", "r_"};
         at_joints(w, legs[random.bits() % 4], where, [&](FloorDrive& d) { d.gain *= gain; });
         return json{{"gain", gain}};
       }});
  all.push_back(
      {"coulomb_friction", 0.04, true, [](FloorTruth& w, double size, Random&, Places& where) {
         at_joints(w, "", where, [&](FloorDrive& d) { d.coulomb += size; });
         return json{{"coulomb", size}};
       }});
  all.push_back(
      {"viscous_friction", 0.1, true, [](FloorTruth& w, double size, Random&, Places& where) {
         at_joints(w, "", where, [&](FloorDrive& d) { d.viscous += size; });
         return json{{"viscous", size}};
       }});
  all.push_back(
      {"command_delay", 0.003, true, [](FloorTruth& w, double size, Random&, Places& where) {
         at_joints(w, "", where, [](FloorDrive&) {});
         w.delay_s += size;
         return json{{"delay", size}};
       }});
}

void add_unknown(std::vector<FloorEffect>& all) {
  all.push_back({"hum", 0.06, false, [](FloorTruth& w, double size, Random& random, Places& where) {
                   FloorDrive& d = w.drives[one_joint(w, random, where)];
                   d.hum = size, d.hum_hz = random.uniform(0.8, 2.0);
                   return json{{"torque", d.hum}, {"hz", d.hum_hz}};
                 }});
  all.push_back(
      {"leaking_goal", 0.05, false, [](FloorTruth& w, double size, Random& random, Places& where) {
         w.drives[one_joint(w, random, where)].leak = size;
         return json{{"share", size}};
       }});
  all.push_back({"fan", 0.12, false, [](FloorTruth& w, double size, Random& random, Places& where) {
                   where = {"base"};
                   w.fan = size, w.fan_hz = random.uniform(0.7, 1.5);
                   return json{{"force", w.fan}, {"hz", w.fan_hz}};
                 }});
}

}  // namespace

const std::vector<FloorEffect>& floor_effects() {
  static const std::vector<FloorEffect> all = [] {
    std::vector<FloorEffect> out;
    add_masses(out), add_sensors(out), add_surroundings(out), add_drives(out), add_unknown(out);
    return out;
  }();
  return all;
}

}  // namespace sanso::conceal
