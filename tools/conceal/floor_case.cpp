// Every figure is off its nominal one by a tolerance in every case; an effect comes on top, in a
// size that its loudest channel shows at the wanted ratio to what noise and tolerances make of it.
#include "tools/conceal/floor_case.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "tools/plant/world_error.h"

namespace sanso::conceal {
namespace {

using nlohmann::json;
using plant::operator*;

struct FloorEffect {
  std::string id;
  std::vector<std::string> where;
  double smallest;  // size at ratio 1: about what a tolerance or its estimate's noise is
  bool in_library;
  /// Hides a size and tells the parameters by the library's names.
  std::function<json(FloorTruth&, double size, Random&)> apply;
};

Vec3 direction(Random& random) {
  Vec3 v{random.normal(), random.normal(), random.normal()};
  return (1.0 / std::max(plant::norm(v), 1e-9)) * v;
}

json three(const Vec3& v, const char* prefix) {
  const std::string p = prefix;
  return {{p + "x", v[0]}, {p + "y", v[1]}, {p + "z", v[2]}};
}

double either_way(Random& random) { return random.chance(0.5) ? 1.0 : -1.0; }

const std::vector<FloorEffect>& floor_effects() {
  static const std::vector<FloorEffect> all = {
      {"link_mass",
       {"base"},
       0.05,
       true,
       [](FloorTruth& w, double size, Random& random) {
         const double share = size * (size < 0.6 ? either_way(random) : 1.0);
         w.trunk.mass *= 1 + share;
         for (double& i : w.trunk.inertia) i *= 1 + share;
         return json{{"share", share}};
       }},
      {"payload",
       {"base"},
       0.1,
       true,
       [](FloorTruth& w, double size, Random&) {
         w.payload_kg = size;
         return json{{"mass", size}};
       }},
      {"foot_force_scale",
       {},
       0.03,
       true,
       [](FloorTruth& w, double size, Random& random) {
         w.force_scale *= 1 + size * either_way(random);
         return json{{"scale", w.force_scale}};
       }},
      {"imu_misalignment",
       {},
       0.012,
       true,
       [](FloorTruth& w, double size, Random& random) {
         w.imu_turn = size * direction(random);
         // the reading turns the other way
         return three(-1.0 * w.imu_turn, "");
       }},
      {"imu_bias",
       {},
       0.01,
       true,
       [](FloorTruth& w, double size, Random& random) {
         w.gyro_bias = size * direction(random);
         return three(w.gyro_bias, "gyro_");
       }},
      {"ground_slope",
       {},
       0.01,
       true,
       [](FloorTruth& w, double size, Random& random) {
         const double angle = random.uniform(0, 2 * plant::kPi);
         w.slope = {size * std::cos(angle), size * std::sin(angle), 0};
         return json{{"x", w.slope[0]}, {"y", w.slope[1]}};
       }},
  };
  return all;
}

// chosen: larger, the robot falls or the answer is plain
constexpr double kLargestRatio = 10.0;

FloorTruth as_built(const FloorTruth& nominal, Random& random) {
  FloorTruth out = nominal;
  out.legs = as_built(nominal.legs, random);
  const double mass = 1 + random.uniform(-0.03, 0.03);
  out.trunk.mass *= mass;
  for (double& i : out.trunk.inertia) i *= mass;
  for (double& c : out.trunk.com) c *= 1 + random.uniform(-0.02, 0.02);
  out.force_scale = 1 + random.uniform(-0.005, 0.005);
  out.imu_turn = random.uniform(0, 0.005) * direction(random);
  out.gyro_bias = random.uniform(0, 0.003) * direction(random);
  out.acc_bias = random.uniform(0, 0.05) * direction(random);
  out.slope = {random.uniform(-0.003, 0.003), random.uniform(-0.003, 0.003), 0};
  out.kp *= random.uniform(0.95, 1.05), out.friction = random.uniform(0.6, 1.0);
  return out;
}

/// Stand, squat, sway, twice each, in headings of their own.
std::vector<FloorMotion> motions(Random& random) {
  std::vector<FloorMotion> out;
  const char* names[] = {"stand", "squat", "sway"};
  for (int i = 0; i < 6; ++i) {
    FloorMotion m;
    m.name = fmt::format("rec_{}", i + 1);
    m.condition = names[i % 3];
    m.heading = random.uniform(-plant::kPi, plant::kPi);
    m.rate_hz = random.uniform(0.3, 0.6);
    if (i % 3 == 1) m.squat = random.uniform(0.2, 0.35);
    if (i % 3 == 2) m.sway = random.uniform(0.06, 0.1);
    out.push_back(m);
  }
  return out;
}

std::vector<double> values_of(const recording::Recording& r, const std::string& name) {
  const auto values = r.find(name);
  if (values.empty()) throw plant::WorldError("no channel " + name);
  return {values.begin(), values.end()};
}

void multiply(recording::Recording& r, const std::string& kind, double factor) {
  for (recording::Channel& c : r.channels) {
    if (c.name.starts_with(kind))
      for (double& v : c.values) v *= factor;
  }
}

/// One way in which a logger spoils a file, and the name that the gate has to say.
json spoil(std::vector<recording::Recording>& all, Random& random) {
  recording::Recording& r = all[random.bits() % all.size()];
  std::string defect = "wrong unit";
  switch (random.bits() % 5) {
    case 0:
      multiply(r, "imu_acc:", 1 / 9.80665);
      break;
    case 1:
      multiply(r, "fz:", 1 / 9.80665);
      break;
    case 2:
      multiply(r, "fz:", -1.0), defect = "wrong sign";
      break;
    case 3:
      multiply(r, "base_q:", 1.4);
      break;
    default: {
      const auto y = values_of(r, "base_q:y");
      std::erase_if(r.channels, [](const auto& c) { return c.name == "base_q:y"; });
      defect = "missing channel";
    }
  }
  return {{"defect", defect}, {"file", r.file}};
}

const FloorEffect& chosen(const ConcealOptions& options, Random& random,
                          const std::string& other_than) {
  const auto& all = floor_effects();
  if (options.effect && other_than.empty()) {
    for (const FloorEffect& e : all) {
      if (e.id == *options.effect) return e;
    }
    throw plant::WorldError("no effect '" + *options.effect + "' can be hidden on op3-floor");
  }
  for (;;) {
    const FloorEffect& e = all[random.bits() % all.size()];
    if (e.id != other_than) return e;
  }
}

Family draw_floor_family(Random& random) {
  const double x = random.uniform();
  return x < 0.25   ? Family::clean
         : x < 0.75 ? Family::single
         : x < 0.88 ? Family::pair
                    : Family::decoy;
}

json hidden(const FloorEffect& e, double ratio, FloorTruth& truth, Random& random) {
  const double reached = std::min(ratio, kLargestRatio);
  const json parameters = e.apply(truth, reached * e.smallest, random);
  return {{"id", e.id}, {"where", e.where}, {"parameters", parameters}, {"ratio", reached}};
}

}  // namespace

FloorCase make_floor_case(const ConcealOptions& options) {
  Random random(options.seed * 0x9E3779B97F4A7C15ull + 0xF1);
  Family family = draw_floor_family(random);
  constexpr double kRatios[] = {1, 3, 10};
  double ratio = kRatios[random.bits() % 3];
  if (options.effect) family = Family::single;
  if (options.family) family = *options.family;
  if (options.ratio) ratio = *options.ratio;
  if (family == Family::outside || family == Family::ambiguous)
    throw plant::WorldError(std::string("op3-floor has no family ") + to_string(family) +
                            "; expected clean, single, pair or decoy");
  const FloorTruth nominal = nominal_floor();
  FloorTruth truth = as_built(nominal, random);
  json effects = json::array();
  if (family == Family::single || family == Family::pair) {
    const FloorEffect& first = chosen(options, random, "");
    effects.push_back(hidden(first, ratio, truth, random));
    if (family == Family::pair)
      effects.push_back(hidden(chosen(options, random, first.id), ratio, truth, random));
  } else {
    ratio = 0;
  }
  FloorCase out;
  for (const FloorMotion& motion : motions(random))
    out.recordings.push_back(run_on_floor(truth, motion, random.bits()));
  json answer{{"format", 2},           {"robot", options.robot},
              {"seed", options.seed},  {"family", to_string(family)},
              {"effects", effects},    {"ratio_target", ratio},
              {"twins", json::array()}};
  if (family == Family::decoy) answer["decoy"] = spoil(out.recordings, random);
  out.answer = answer.dump();
  out.urdf = floor_urdf(nominal);
  out.toml = fmt::format(
      "format = 1\n[robot]\nurdf = \"robot.urdf\"\nbase = \"floating\"\n[joint_default]\n"
      "actuator = \"position_pd\"\nkp = {}\nkd = {}\n[ground]\nfriction = {}\n",
      nominal.kp, nominal.kd, nominal.friction);
  return out;
}

}  // namespace sanso::conceal
