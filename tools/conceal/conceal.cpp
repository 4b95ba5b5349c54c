// The order of the draws is the case: whoever adds one changes every case of that seed.
#include "tools/conceal/conceal.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "shared/files/atomic_file.h"
#include "tools/conceal/built.h"
#include "tools/conceal/decoy.h"
#include "tools/conceal/floor_case.h"
#include "tools/conceal/seal.h"
#include "tools/conceal/severity.h"
#include "tools/plant/world_error.h"
#include "tools/recording/csv_writer.h"

namespace sanso::conceal {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::array<std::pair<Family, const char*>, 6> kFamilies{
    {{Family::clean, "clean"},
     {Family::single, "single"},
     {Family::pair, "pair"},
     {Family::decoy, "decoy"},
     {Family::outside, "outside"},
     {Family::ambiguous, "ambiguous"}}};
// Pairs of which one tends to hide the other (diagnosis method, section 4).
constexpr std::array<std::pair<const char*, const char*>, 6> kMaskingPairs{
    {{"command_delay", "viscous_friction"},
     {"servo_p_gain", "coulomb_friction"},
     {"link_mass", "encoder_offset"},
     {"backlash", "stribeck_friction"},
     {"supply_sag", "current_limit"},
     {"link_mass", "torque_constant"}}};

// 2: tolerances of every figure, dry friction drawn, several formulas. Seeds of 1 are other cases.
constexpr int kAnswerFormat = 2;

/// A case while it is being made.
struct Case {
  Family family = Family::clean;
  double ratio_target = 0;
  RobotSpec nominal;
  JointTruth nominal_joint;
  WorldTruth without, with;
  std::vector<Experiment> experiments;
  std::vector<HiddenEffect> effects;
  std::vector<double> ratios;
  std::vector<std::string> twins;
  std::optional<Decoy> decoy;
};

Family draw_family(Random& random) {
  const double x = random.uniform();
  if (x < 0.20) return Family::clean;
  if (x < 0.62) return Family::single;
  if (x < 0.77) return Family::pair;
  if (x < 0.86) return Family::decoy;
  if (x < 0.94) return Family::outside;
  return Family::ambiguous;
}

double draw_ratio(Random& random) {
  constexpr double kRatios[] = {0.3, 1, 3, 10, 30};
  return kRatios[random.bits() % 5];
}

const Hideable& draw_hideable(Random& random, const std::function<bool(const Hideable&)>& allowed) {
  std::vector<const Hideable*> choices;
  for (const Hideable& h : hideables()) {
    if (allowed(h)) choices.push_back(&h);
  }
  return *choices[random.bits() % choices.size()];
}

/// Hides one more effect at the target ratio against a world without it.
void hide(Case& c, const Hideable& effect, const SeverityMeter& meter, Random& random) {
  const int at =
      static_cast<int>(random.bits() % static_cast<std::uint64_t>(c.without.robot.size()));
  const Random parameters(random.bits());
  double reached = 0;
  const double size =
      size_for_ratio(effect, at, c.without, meter, c.ratio_target, parameters, reached);
  Random same = parameters;
  c.effects.push_back(effect.apply(c.with, at, size, same));
  c.ratios.push_back(reached);
}

void hide_effects(Case& c, const ConcealOptions& options, Random& random) {
  // one recording of each condition is enough to measure loudness
  const SeverityMeter meter(c.without, {c.experiments[0], c.experiments[2], c.experiments[4]},
                            random.bits());
  const auto in_library = [](const Hideable& h) { return h.in_library; };
  if (c.family == Family::single) {
    hide(c, options.effect ? hideable(*options.effect) : draw_hideable(random, in_library), meter,
         random);
  } else if (c.family == Family::outside) {
    hide(c, draw_hideable(random, [](const Hideable& h) { return !h.in_library; }), meter, random);
  } else if (c.family == Family::ambiguous) {
    const Hideable& effect =
        draw_hideable(random, [](const Hideable& h) { return !h.twins.empty(); });
    hide(c, effect, meter, random);
    c.twins = effect.twins;
  } else if (c.family == Family::pair && random.chance(0.5)) {
    const auto& [first, second] = kMaskingPairs[random.bits() % kMaskingPairs.size()];
    hide(c, hideable(first), meter, random);
    hide(c, hideable(second), meter, random);
  } else if (c.family == Family::pair) {
    const Hideable& first = draw_hideable(random, in_library);
    hide(c, first, meter, random);
    hide(c,
         draw_hideable(random, [&](const Hideable& h) { return h.in_library && h.id != first.id; }),
         meter, random);
  }
}

std::string model_toml(const RobotSpec& robot, const JointTruth& j) {
  return fmt::format(
      "format = 1\n[robot]\nurdf = \"robot.urdf\"\nbase = \"fixed\"\ngravity = [0.0, 0.0, -9.81]\n"
      "[control]\nperiod_s "
      "= {}\n"
      "[joint_default]   # {}: XM430-W350 servos at 12 V\nactuator = \"dc_servo\"\np_gain = {}\n"
      "voltage = {:.1f}\n"
      "resistance = {}\ntorque_constant = {}\nback_emf = {}\narmature = {}\nviscous = {}\ncoulomb "
      "= {}\n"
      "command_delay_s = {}\nsensor_delay_s = {}\nposition_quantum = {:.12g}\n",
      kControlPeriod_s, robot.name, j.p_gain, j.voltage, j.resistance, j.torque_constant,
      j.back_emf, j.armature, j.viscous, j.coulomb, j.command_delay_s, j.sensor_delay_s, j.quantum);
}

std::string answer_json(const Case& c, const ConcealOptions& options) {
  json effects = json::array();
  for (std::size_t i = 0; i < c.effects.size(); ++i) {
    effects.push_back({{"id", c.effects[i].id},
                       {"where", c.effects[i].where},
                       {"parameters", c.effects[i].parameters},
                       {"ratio", c.ratios[i]}});
    if (c.effects[i].coulomb_beside > 0.0)
      effects.back()["beside"] = {{"coulomb_friction", c.effects[i].coulomb_beside}};
  }
  json answer{{"format", kAnswerFormat},
              {"formulas", to_json(c.without.joints.front().formulas)},
              {"tolerances", tolerances(c.without, c.nominal, c.nominal_joint)},
              {"robot", options.robot},
              {"seed", options.seed},
              {"family", to_string(c.family)},
              {"effects", effects},
              {"ratio_target", c.ratio_target},
              {"twins", c.twins}};
  if (c.decoy) answer["decoy"] = {{"defect", c.decoy->defect}, {"file", c.decoy->file}};
  return answer.dump();
}

}  // namespace

const char* to_string(Family family) {
  for (const auto& [f, name] : kFamilies) {
    if (f == family) return name;
  }
  return "unknown";
}

std::optional<Family> family_from_string(const std::string& name) {
  for (const auto& [f, text] : kFamilies) {
    if (name == text) return f;
  }
  return std::nullopt;
}

namespace {

/// Writes a case; the answer sealed.
Concealed write_case(const fs::path& out, const std::string& urdf, const std::string& toml,
                     const std::vector<recording::Recording>& recordings,
                     const std::string& answer) {
  fs::create_directories(out / "model");
  fs::create_directories(out / "recordings");
  files::write_atomically(out / "model" / "robot.urdf", urdf);
  files::write_atomically(out / "model" / "model.toml", toml);
  Concealed result;
  result.model = (out / "model").string();
  for (const auto& r : recordings) {
    const fs::path path = out / "recordings" / r.file;
    recording::write_csv(r, path.string());
    result.recordings.push_back(path.string());
  }
  const auto sealed = make_seal(answer);
  files::write_atomically(out / "answer.sealed", sealed);
  result.hash = seal_hash(sealed);
  return result;
}

}  // namespace

Concealed conceal(const ConcealOptions& options) {
  const fs::path out(options.out);
  if (fs::exists(out / "answer.sealed")) {
    throw plant::WorldError(options.out +
                            " holds a case already; choose another --out or remove it");
  }
  if (options.robot == kFloorRobot) {
    const FloorCase made = make_floor_case(options);
    return write_case(out, made.urdf, made.toml, made.recordings, made.answer);
  }
  const RobotSpec nominal = make_robot(options.robot);
  Random random(options.seed * 0x9E3779B97F4A7C15ull + 0xC0);
  Case c;
  c.family = draw_family(random);
  c.ratio_target = draw_ratio(random);
  if (options.effect) c.family = Family::single;
  if (options.family) c.family = *options.family;
  if (options.ratio) c.ratio_target = *options.ratio;
  c.nominal = nominal;
  c.nominal_joint = nominal_joint(random);
  c.without = built_world(nominal, c.nominal_joint, random);
  const Formulas formulas = draw_formulas(random);
  for (JointTruth& joint : c.without.joints) joint.formulas = formulas;
  c.with = c.without;
  c.experiments = make_experiments(nominal, random);
  if (c.family == Family::clean || c.family == Family::decoy) c.ratio_target = 0;
  if (c.family != Family::clean && c.family != Family::decoy) hide_effects(c, options, random);

  const bool ambiguous = c.family == Family::ambiguous;
  std::vector<recording::Recording> recordings;
  for (std::size_t i = 0; i < c.experiments.size(); ++i) {
    if (ambiguous && c.experiments[i].condition != c.experiments[0].condition) continue;
    const Signals signals = run_experiment(c.with, c.experiments[i], random.bits());
    recordings.push_back(
        as_recording(c.with, c.experiments[i], signals, random.bits(), !ambiguous));
  }
  if (c.family == Family::decoy) c.decoy = spoil(recordings, random);

  return write_case(out, to_urdf(nominal), model_toml(nominal, c.nominal_joint), recordings,
                    answer_json(c, options));
}

}  // namespace sanso::conceal
