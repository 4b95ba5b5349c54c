// Motion files: TOML in and out. Numbers are written with the fewest digits that a robot can tell
// apart.
#include <cmath>
#include <set>
#include <sstream>

#define TOML_EXCEPTIONS 1
#include <toml++/toml.h>

#include "host/motion/measures.h"
#include "host/motion/motion.h"
#include "host/motion/toml_table.h"
#include "shared/files/atomic_file.h"
#include "shared/model/joints.h"

namespace sanso::motion {
namespace {

constexpr int kFormat = 1;
const char* const kBaseNames[3] = {"base_x", "base_y", "base_z"};

std::string scalar_name(int i) { return i < 3 ? kBaseNames[i] : model::kJoints[i - 3].name; }

/// The weights of W_x in groups: one number for entries that are always equal.
struct WeightGroup {
  const char* key;
  int from, count;  // in the tangent
};
constexpr WeightGroup kStateWeights[] = {
    {"base_x", model::kDPos, 1},         {"base_y", model::kDPos + 1, 1},
    {"base_z", model::kDPos + 2, 1},     {"roll", model::kDTheta, 1},
    {"pitch", model::kDTheta + 1, 1},    {"yaw", model::kDTheta + 2, 1},
    {"joints", model::kDJoint, 12},      {"base_velocity", model::kDVel, 3},
    {"roll_rate", model::kDOmega, 1},    {"pitch_rate", model::kDOmega + 1, 1},
    {"yaw_rate", model::kDOmega + 2, 1}, {"joint_rates", model::kDJointRate, 12}};

void read_cost(TomlTable table, mpc::CostWeights& weights) {
  for (const WeightGroup& group : kStateWeights) {
    weights.state.segment(group.from, group.count).setConstant(table.number(group.key, 0.0, 1e6));
  }
  weights.input.setConstant(table.number("input", 0.0, 1e6));
  table.finish();
}

void read_recipe(TomlTable table, Recipe& recipe) {
  try {
    recipe.kind = motion_kind(table.text("kind"));
  } catch (const std::invalid_argument& error) {
    table.fail("kind", error.what());
  }
  visit_recipe(recipe, [&](const char* key, auto& value) { table.optional(key, value); });
  table.finish();
}

std::vector<Clause> read_success(TomlTable& root) {
  std::vector<Clause> clauses;
  for (TomlTable& entry : root.tables("success")) {
    Clause clause;
    clause.measure = entry.text("measure");
    if (!find_measure(clause.measure)) {
      std::string known;
      for (const auto& m : known_measures()) known += (known.empty() ? "" : ", ") + m.name;
      entry.fail("measure", "'" + clause.measure + "' is none of " + known);
    }
    clause.at_least = entry.optional_number("at_least");
    clause.at_most = entry.optional_number("at_most");
    entry.optional("waived", clause.waived);
    if (!clause.at_least && !clause.at_most)
      entry.fail("measure", "neither at_least nor at_most stands beside it");
    entry.finish();
    clauses.push_back(clause);
  }
  return clauses;
}

void read_primitives(TomlTable table, policy::PrimitiveSet& set) {
  const std::string form = table.text("form");
  if (form != "discrete" && form != "rhythmic")
    table.fail("form", "'" + form + "' is neither discrete nor rhythmic");
  set.form = form == "discrete" ? policy::PrimitiveForm::discrete : policy::PrimitiveForm::rhythmic;
  set.num_basis = static_cast<int>(table.number("num_basis", 2, policy::kMaxBasis));
  set.duration_s = table.number("duration_s", 0.1, policy::kMaxPrimitiveDuration_s);
  set.period_s = table.number("period_s", 0.1, policy::kMaxPrimitiveDuration_s);
  set.fade_start = table.number("fade_start", 0.0, 1.0);
  const auto n = static_cast<std::size_t>(set.num_basis);
  for (int i = 0; i < policy::kNumScalarPrimitives; ++i) {
    TomlTable entry = table.table(scalar_name(i));
    policy::ScalarPrimitive& scalar = set.scalar[i];
    scalar.start = entry.number("start", -1e3, 1e3);
    scalar.start_rate = entry.number("start_rate", -1e3, 1e3);
    scalar.goal = entry.number("goal", -1e3, 1e3);
    scalar.drift = entry.number("drift", -1e3, 1e3);
    const std::vector<double> weights = entry.numbers("weights", n);
    for (std::size_t b = 0; b < n; ++b) scalar.weights[b] = static_cast<float>(weights[b]);
    entry.finish();
  }
  TomlTable entry = table.table("orientation");
  const std::vector<double> start = entry.numbers("start", 4), goal = entry.numbers("goal", 4);
  const std::vector<double> rate = entry.numbers("start_rate", 3),
                            weights = entry.numbers("weights", 3 * n);
  for (int k = 0; k < 4; ++k) {
    set.orientation.start[k] = start[k];
    set.orientation.goal[k] = goal[k];
  }
  // files hold rounded numbers; the wire wants unit quaternions
  set.orientation.start = math::quat_normalized(set.orientation.start);
  set.orientation.goal = math::quat_normalized(set.orientation.goal);
  for (int k = 0; k < 3; ++k) set.orientation.start_rate[k] = rate[k];
  for (std::size_t b = 0; b < n; ++b) {
    for (std::size_t k = 0; k < 3; ++k)
      set.orientation.weights[b][k] = static_cast<float>(weights[3 * b + k]);
  }
  entry.finish();
  table.finish();
}

// --- writing ---

class TomlText {
 public:
  void heading(const std::string& name) { out_ << "\n[" << name << "]\n"; }
  void line(const std::string& raw) { out_ << raw << "\n"; }
  void put(const std::string& key, const std::string& value) {
    out_ << key << " = \"";
    for (const char c : value) {
      if (c == '"' || c == '\\') out_ << '\\';
      out_ << c;
    }
    out_ << "\"\n";
  }
  void put(const std::string& key, bool value) {
    out_ << key << " = " << (value ? "true" : "false") << "\n";
  }
  void put(const std::string& key, int value) { out_ << key << " = " << value << "\n"; }
  void put(const std::string& key, double value) {
    out_ << key << " = " << number(value, 9) << "\n";
  }
  void list(const std::string& key, const std::vector<double>& values, int digits) {
    out_ << key << " = [";
    for (std::size_t k = 0; k < values.size(); ++k) {
      if (k > 0) out_ << (k % 15 == 0 ? ",\n  " : ", ");
      out_ << number(values[k], digits);
    }
    out_ << "]\n";
  }
  std::string text() const { return out_.str(); }

 private:
  static std::string number(double value, int digits) {
    char buffer[40];
    std::snprintf(buffer, sizeof buffer, "%.*g", digits, value == 0.0 ? 0.0 : value);
    // TOML tells floats from integers by the point
    std::string text = buffer;
    if (text.find_first_of(".en") == std::string::npos) text += ".0";
    return text;
  }
  std::ostringstream out_;
};

constexpr int kPoseDigits = 9;    // 1 nm, 1 nrad of what a pose is
constexpr int kWeightDigits = 6;  // one part in a million of the forcing: 1 urad in the joints

void write_primitives(TomlText& toml, const policy::PrimitiveSet& set) {
  toml.heading("primitives");
  toml.put("form",
           std::string(set.form == policy::PrimitiveForm::discrete ? "discrete" : "rhythmic"));
  toml.put("num_basis", set.num_basis);
  toml.put("duration_s", set.duration_s);
  toml.put("period_s", set.period_s);
  toml.put("fade_start", set.fade_start);
  for (int i = 0; i < policy::kNumScalarPrimitives; ++i) {
    const policy::ScalarPrimitive& scalar = set.scalar[i];
    toml.heading("primitives." + scalar_name(i));
    toml.put("start", scalar.start);
    toml.put("start_rate", scalar.start_rate);
    toml.put("goal", scalar.goal);
    toml.put("drift", scalar.drift);
    toml.list("weights", {scalar.weights.begin(), scalar.weights.begin() + set.num_basis},
              kWeightDigits);
  }
  toml.heading("primitives.orientation");
  const auto& o = set.orientation;
  toml.list("start", {o.start[0], o.start[1], o.start[2], o.start[3]}, kPoseDigits);
  toml.list("start_rate", {o.start_rate[0], o.start_rate[1], o.start_rate[2]}, kPoseDigits);
  toml.list("goal", {o.goal[0], o.goal[1], o.goal[2], o.goal[3]}, kPoseDigits);
  std::vector<double> weights;
  for (int b = 0; b < set.num_basis; ++b)
    weights.insert(weights.end(), o.weights[b].begin(), o.weights[b].end());
  toml.list("weights", weights, kWeightDigits);
}

void write_success(TomlText& toml, const Motion& motion) {
  toml.heading("window");
  toml.line("# the moving part, without the standing before and after");
  toml.put("from_s", motion.window.from_s);
  toml.put("to_s", motion.window.to_s);
  for (const Clause& clause : motion.success) {
    toml.line("\n[[success]]");
    toml.put("measure", clause.measure);
    if (clause.at_least) toml.put("at_least", *clause.at_least);
    if (clause.at_most) toml.put("at_most", *clause.at_most);
    if (!clause.waived.empty()) toml.put("waived", clause.waived);
  }
}

}  // namespace

MotionKind motion_kind(const std::string& name) {
  for (const MotionKind kind : {MotionKind::in_place, MotionKind::one_leg, MotionKind::gait}) {
    if (name == to_string(kind)) return kind;
  }
  throw std::invalid_argument("'" + name + "' is none of in_place, one_leg, gait");
}

const char* to_string(MotionKind kind) {
  switch (kind) {
    case MotionKind::in_place:
      return "in_place";
    case MotionKind::one_leg:
      return "one_leg";
    case MotionKind::gait:
      return "gait";
  }
  return "unknown";
}

std::string to_toml(const Motion& motion) {
  TomlText toml;
  toml.line(
      "# A motion of sanso. Made by `sanso motions import`; the weights and clauses may be edited "
      "by hand.");
  toml.put("format", kFormat);
  toml.put("name", motion.name);
  toml.put("title", motion.title);
  toml.heading("source");
  toml.put("credit", motion.source.credit);
  toml.put("licence", motion.source.licence);
  toml.put("changes", motion.source.changes);
  toml.heading("retarget");
  toml.put("kind", std::string(to_string(motion.recipe.kind)));
  visit_recipe(motion.recipe, [&](const char* key, const auto& value) { toml.put(key, value); });
  toml.heading("cost");
  toml.line(
      "# diagonal of W_x per m^2, rad^2, (m/s)^2, (rad/s)^2 and of W_u per rad^2; no factor 1/2");
  for (const WeightGroup& group : kStateWeights)
    toml.put(group.key, motion.weights.state[group.from]);
  toml.put("input", motion.weights.input[0]);
  toml.heading("stop");
  toml.put("cost_limit", motion.stop.cost_limit);
  toml.put("tilt_limit_rad", motion.stop.tilt_limit_rad);
  toml.put("drop_limit_m", motion.stop.drop_limit_m);
  write_success(toml, motion);
  write_primitives(toml, motion.primitives);
  return toml.text();
}

Motion parse_motion(const std::string& text, const std::string& name_for_messages) {
  const toml::table document = parse_toml(text, name_for_messages);
  TomlTable root(document, name_for_messages, "");
  Motion motion;
  if (root.number("format", 1, 1000) != kFormat) root.fail("format", "this program reads format 1");
  motion.name = root.text("name");
  motion.title = root.text("title");
  TomlTable source = root.table("source");
  motion.source = {source.text("credit"), source.text("licence"), source.text("changes")};
  source.finish();
  read_recipe(root.table("retarget"), motion.recipe);
  read_cost(root.table("cost"), motion.weights);
  TomlTable stop = root.table("stop");
  motion.stop = {stop.number("cost_limit", 1, 1e6), stop.number("tilt_limit_rad", 0.05, 1.5),
                 stop.number("drop_limit_m", 0.005, 0.25)};
  stop.finish();
  TomlTable window = root.table("window");
  motion.window = {window.number("from_s", 0, 60), window.number("to_s", 0, 60)};
  window.finish();
  motion.success = read_success(root);
  read_primitives(root.table("primitives"), motion.primitives);
  root.finish();
  if (policy::validate(motion.primitives) != Status::ok) {
    root.fail(
        "primitives",
        "a number is outside what the robot can follow (joints within 3.2 rad, base within 20 m)");
  }
  return motion;
}

Motion read_motion(const std::filesystem::path& path) {
  return parse_motion(files::read_text(path), path.string());
}

void write_motion(const std::filesystem::path& path, const Motion& motion) {
  files::write_atomically(path, to_toml(motion));
}

}  // namespace sanso::motion
