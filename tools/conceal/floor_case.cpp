// Every figure is off its nominal one by a tolerance in every case; an effect comes on top, in a
// size that its loudest channel shows at the wanted ratio to what noise and tolerances make of it.
#include "tools/conceal/floor_case.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "tools/conceal/floor_effects.h"
#include "tools/plant/world_error.h"

namespace sanso::conceal {
namespace {

using nlohmann::json;
using plant::operator*;

// chosen: larger, the robot falls or the answer is plain
constexpr double kLargestRatio = 10.0;
constexpr std::uint64_t kMostDraws = 20;
constexpr std::size_t kFewestRows = 200;  // of a motion in which it fell: two seconds

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
  out.kp *= random.uniform(0.988, 1.012), out.friction = random.uniform(0.6, 1.0);
  for (FloorDrive& d : out.drives) {
    d.gain = random.uniform(0.992, 1.008), d.zero = random.uniform(-0.0015, 0.0015);
    d.coulomb *= random.uniform(0.7, 1.3), d.viscous *= random.uniform(0.7, 1.3);
  }
  out.delay_s = random.uniform(0.0, 0.0005);
  return out;
}

/// Stand, squat, sway, stand on one leg, walk; twice each, in headings of their own.
std::vector<FloorMotion> motions(Random& random) {
  std::vector<FloorMotion> out;
  const char* names[] = {"stand", "squat", "sway", "one-leg", "walk"};
  for (int i = 0; i < 10; ++i) {
    FloorMotion m;
    m.name = fmt::format("rec_{:02}", i + 1);
    m.condition = names[i % 5];
    m.heading = random.uniform(-plant::kPi, plant::kPi);
    m.rate_hz = random.uniform(0.3, 0.6);
    if (i % 5 == 1) m.squat = random.uniform(0.2, 0.35);
    if (i % 5 == 2) m.sway = random.uniform(0.06, 0.1);
    if (i % 5 >= 3) m.sway = random.uniform(0.13, 0.16), m.lift = random.uniform(0.25, 0.35);
    if (i % 5 == 3) m.rate_hz = random.uniform(0.12, 0.16);
    if (i % 5 == 4) {  // it falls from side to side, and is caught: slower, it would fall over
      m.sway = random.uniform(0.09, 0.12), m.lift = random.uniform(0.2, 0.3);
      m.stride = random.uniform(0.03, 0.07), m.rate_hz = random.uniform(0.4, 0.6);
    }
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

const FloorEffect& chosen(const ConcealOptions& options, bool in_library, Random& random,
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
    if (e.id != other_than && e.in_library == in_library) return e;
  }
}

bool is_known(const std::string& effect) {
  const auto& all = floor_effects();
  return std::none_of(all.begin(), all.end(),
                      [&](const FloorEffect& e) { return e.id == effect && !e.in_library; });
}

Family draw_floor_family(Random& random) {
  const double x = random.uniform();
  return x < 0.20   ? Family::clean
         : x < 0.65 ? Family::single
         : x < 0.78 ? Family::pair
         : x < 0.88 ? Family::decoy
                    : Family::outside;
}

json hidden(const FloorEffect& e, double ratio, FloorTruth& truth, Random& random) {
  const double reached = std::min(ratio, kLargestRatio);
  std::vector<std::string> where;
  const json parameters = e.apply(truth, reached * e.smallest, random, where);
  return {{"id", e.id}, {"where", where}, {"parameters", parameters}, {"ratio", reached}};
}

}  // namespace

FloorPlan plan_floor_case(const ConcealOptions& options, std::uint64_t draw) {
  Random random(options.seed * 0x9E3779B97F4A7C15ull + 0xF1 + draw * 0xD1B54A32D192ED03ull);
  Family family = draw_floor_family(random);
  constexpr double kRatios[] = {1, 3, 10};
  double ratio = kRatios[random.bits() % 3];
  if (options.effect) family = is_known(*options.effect) ? Family::single : Family::outside;
  if (options.family) family = *options.family;
  if (options.ratio) ratio = *options.ratio;
  if (family == Family::ambiguous)
    throw plant::WorldError(std::string("op3-floor has no family ") + to_string(family) +
                            "; expected clean, single, pair, decoy or outside");
  FloorTruth truth = as_built(nominal_floor(), random);
  json effects = json::array();
  if (family != Family::clean && family != Family::decoy) {
    const FloorEffect& first = chosen(options, family != Family::outside, random, "");
    effects.push_back(hidden(first, ratio, truth, random));
    if (family == Family::pair)
      effects.push_back(hidden(chosen(options, true, random, first.id), ratio, truth, random));
  } else {
    ratio = 0;
  }
  std::vector<FloorMotion> drawn = motions(random);
  std::vector<std::uint64_t> noise(drawn.size());
  for (std::uint64_t& seed : noise) seed = random.bits();
  json answer{{"format", 3},           {"robot", options.robot},
              {"seed", options.seed},  {"family", to_string(family)},
              {"effects", effects},    {"ratio_target", ratio},
              {"twins", json::array()}};
  return {std::move(truth), std::move(drawn), std::move(noise), std::move(answer), random};
}

std::string floor_toml(const FloorTruth& nominal) {
  const FloorDrive& drive = nominal.drives.front();
  return fmt::format(
      "format = 1\n[robot]\nurdf = \"robot.urdf\"\nbase = \"floating\"\n[joint_default]\n"
      "actuator = \"position_pd\"\nkp = {}\nkd = {}\narmature = {}\nviscous = {}\ncoulomb = {}\n"
      "[ground]\nfriction = {}\n",
      nominal.kp, nominal.kd, nominal.armature, drive.viscous, drive.coulomb, nominal.friction);
}

namespace {

/// Motions in which it stayed on its feet for long enough.
std::vector<recording::Recording> runs_of(const FloorPlan& plan) {
  std::vector<recording::Recording> out;
  for (std::size_t i = 0; i < plan.motions.size(); ++i) {
    recording::Recording made = run_on_floor(plan.truth, plan.motions[i], plan.noise[i]);
    if (made.rows() >= kFewestRows) out.push_back(std::move(made));
  }
  return out;
}

FloorCase finished(FloorPlan plan, FloorCase out) {
  if (plan.answer.at("family") == to_string(Family::decoy))
    plan.answer["decoy"] = spoil(out.recordings, plan.random);
  out.answer = plan.answer.dump();
  const FloorTruth nominal = nominal_floor();
  out.urdf = floor_urdf(nominal), out.toml = floor_toml(nominal);
  return out;
}

}  // namespace

FloorCase make_floor_case(const ConcealOptions& options) {
  FloorCase out;
  for (std::uint64_t draw = 0; draw < kMostDraws; ++draw) {
    FloorPlan plan = plan_floor_case(options, draw);
    out.recordings = runs_of(plan);
    if (2 * out.recordings.size() >= plan.motions.size())
      return finished(std::move(plan), std::move(out));
  }
  throw plant::WorldError(
      fmt::format("the robot of seed {} falls in every one of {} draws", options.seed, kMostDraws));
}

}  // namespace sanso::conceal
