// Motion files: TOML in and out. Numbers are written with the digits that a robot can tell apart.
#include <cmath>
#include <limits>
#include <set>
#include <sstream>

#include "host/motion/measures.h"
#include "host/motion/motion.h"
#include "shared/files/atomic_file.h"
#include "shared/files/input_error.h"
#include "shared/files/toml.h"
#include "shared/grounds/ground_file.h"
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
using files::TomlTable;

double number(const TomlTable& table, std::string_view key, double low, double high) {
  return table.need(key, table.number(key, low, high),
                    "a number from " + files::toml_number(low) + " to " + files::toml_number(high));
}

std::string text(const TomlTable& table, std::string_view key) {
  return table.need(key, table.string(key), "a text in quotes");
}

std::vector<double> numbers(const TomlTable& table, std::string_view key, std::size_t count) {
  return table.need(key, table.numbers(key, count),
                    "a list of " + std::to_string(count) + " numbers");
}

TomlTable section(const TomlTable& table, std::string_view key) {
  return table.need(key, table.table(key), "a table");
}

void read_cost(const TomlTable& table, mpc::CostWeights& weights) {
  for (const WeightGroup& group : kStateWeights)
    weights.state.segment(group.from, group.count).setConstant(number(table, group.key, 0.0, 1e6));
  TomlTable::into(weights.state[model::kDVel + 2], table.number("base_rise", 0.0, 1e6));
  weights.input.setConstant(number(table, "input", 0.0, 1e6));
  table.finish();
}

constexpr double kLargest = std::numeric_limits<double>::max();  // any number but inf and nan

void read_figure(const TomlTable& table, const char* key, double& value) {
  TomlTable::into(value, table.number(key, -kLargest, kLargest));
}
void read_figure(const TomlTable& table, const char* key, int& value) {
  const auto given =
      table.number(key, std::numeric_limits<int>::min(), std::numeric_limits<int>::max());
  if (given && *given != std::floor(*given))
    table.fail(key, "not a whole number", files::toml_number(*given), "a whole number");
  if (given) value = static_cast<int>(*given);
}
void read_figure(const TomlTable& table, const char* key, bool& value) {
  TomlTable::into(value, table.boolean(key));
}
void read_figure(const TomlTable& table, const char* key, std::string& value) {
  TomlTable::into(value, table.string(key));
}

void read_recipe(const TomlTable& table, Recipe& recipe) {
  const std::string kind = text(table, "kind");
  try {
    recipe.kind = motion_kind(kind);
  } catch (const std::invalid_argument& error) {
    table.fail("kind", "unknown kind", kind, error.what());
  }
  visit_recipe(recipe, [&](const char* key, auto& value) { read_figure(table, key, value); });
  table.finish();
}

void read_skate(const TomlTable& table, Skate& skate) {
  visit_skate(skate, [&](const char* key, auto& value) { read_figure(table, key, value); });
  table.finish();
  if (!(skate.push_s > 0.0 && skate.push_s <= 5.0))
    table.fail("push_s", "out of range", files::toml_number(skate.push_s), "above 0, at most 5");
  try {
    (void)grounds::load_ground(skate.ground);
  } catch (const files::InputError& error) {
    table.fail("ground", "no such profile", skate.ground, error.what());
  }
}

void read_flight(const TomlTable& table, FlightJog& flight) {
  visit_flight_jog(flight, [&](const char* key, auto& value) { read_figure(table, key, value); });
  table.finish();
}

Clause read_clause(const TomlTable& entry) {
  Clause clause;
  clause.measure = text(entry, "measure");
  if (!find_measure(clause.measure)) {
    std::string known;
    for (const auto& m : known_measures()) known += (known.empty() ? "" : ", ") + m.name;
    entry.fail("measure", "unknown measure", clause.measure, "one of " + known);
  }
  clause.at_least = entry.number("at_least", -kLargest, kLargest);
  clause.at_most = entry.number("at_most", -kLargest, kLargest);
  TomlTable::into(clause.waived, entry.string("waived"));
  if (!clause.at_least && !clause.at_most)
    entry.fail("measure", "no bound", clause.measure, "at_least or at_most beside it");
  entry.finish();
  return clause;
}

std::vector<Clause> read_success(const TomlTable& root) {
  if (!root.has("success"))
    root.fail("success", "missing key", "", "a list of tables, [[success]]");
  std::vector<Clause> clauses;
  for (const TomlTable& entry : root.tables("success")) clauses.push_back(read_clause(entry));
  return clauses;
}

void read_orientation(const TomlTable& entry, std::size_t n,
                      policy::OrientationPrimitive& orientation) {
  const std::vector<double> start = numbers(entry, "start", 4), goal = numbers(entry, "goal", 4);
  const std::vector<double> rate = numbers(entry, "start_rate", 3),
                            weights = numbers(entry, "weights", 3 * n);
  for (int k = 0; k < 4; ++k) {
    orientation.start[k] = start[k];
    orientation.goal[k] = goal[k];
  }
  // files hold rounded numbers; the wire wants unit quaternions
  orientation.start = math::quat_normalized(orientation.start);
  orientation.goal = math::quat_normalized(orientation.goal);
  for (int k = 0; k < 3; ++k) orientation.start_rate[k] = rate[k];
  for (std::size_t b = 0; b < n; ++b) {
    for (std::size_t k = 0; k < 3; ++k)
      orientation.weights[b][k] = static_cast<float>(weights[3 * b + k]);
  }
  entry.finish();
}

void read_primitives(const TomlTable& table, policy::PrimitiveSet& set) {
  const auto form = table.need("form", table.choice("form", {"discrete", "rhythmic"}),
                               "\"discrete\" or \"rhythmic\"");
  set.form = form == 0 ? policy::PrimitiveForm::discrete : policy::PrimitiveForm::rhythmic;
  set.num_basis = static_cast<int>(number(table, "num_basis", 2, policy::kMaxBasis));
  set.duration_s = number(table, "duration_s", 0.1, policy::kMaxPrimitiveDuration_s);
  set.period_s = number(table, "period_s", 0.1, policy::kMaxPrimitiveDuration_s);
  set.fade_start = number(table, "fade_start", 0.0, 1.0);
  const auto n = static_cast<std::size_t>(set.num_basis);
  for (int i = 0; i < policy::kNumScalarPrimitives; ++i) {
    const TomlTable entry = section(table, scalar_name(i));
    policy::ScalarPrimitive& scalar = set.scalar[i];
    scalar.start = number(entry, "start", -1e3, 1e3);
    scalar.start_rate = number(entry, "start_rate", -1e3, 1e3);
    scalar.goal = number(entry, "goal", -1e3, 1e3);
    scalar.drift = number(entry, "drift", -1e3, 1e3);
    const std::vector<double> weights = numbers(entry, "weights", n);
    for (std::size_t b = 0; b < n; ++b) scalar.weights[b] = static_cast<float>(weights[b]);
    entry.finish();
  }
  read_orientation(section(table, "orientation"), n, set.orientation);
  table.finish();
}

Motion read_document(const TomlTable& root) {
  if (number(root, "format", 1, 1000) != kFormat)
    root.fail("format", "another format", "", "format 1: this program reads format 1");
  Motion motion;
  motion.name = text(root, "name");
  motion.title = text(root, "title");
  const TomlTable source = section(root, "source");
  motion.source = {text(source, "credit"), text(source, "licence"), text(source, "changes")};
  source.finish();
  if (root.has("skate"))
    read_skate(section(root, "skate"), motion.skate.emplace());
  else if (root.has("flight"))
    read_flight(section(root, "flight"), motion.flight.emplace());
  else
    read_recipe(section(root, "retarget"), motion.recipe);
  read_cost(section(root, "cost"), motion.weights);
  if (root.has("controller")) {
    const TomlTable controller = section(root, "controller");
    motion.target_rate_rad_s = number(controller, "max_target_rate_rad_s", 1.0, 60.0);
    controller.finish();
  }
  const TomlTable stop = section(root, "stop");
  motion.stop = {number(stop, "cost_limit", 1, 1e6), number(stop, "tilt_limit_rad", 0.05, 1.5),
                 number(stop, "drop_limit_m", 0.005, 0.25)};
  stop.finish();
  const TomlTable window = section(root, "window");
  motion.window = {number(window, "from_s", 0, 60), number(window, "to_s", 0, 60)};
  window.finish();
  motion.success = read_success(root);
  read_primitives(section(root, "primitives"), motion.primitives);
  root.finish();
  if (policy::validate(motion.primitives) != Status::ok) {
    root.fail("primitives", "a number is outside what the robot can follow", "",
              "joints within 3.2 rad, base within 20 m");
  }
  return motion;
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

void write_making(TomlText& toml, const Motion& motion) {
  const auto put = [&](const char* key, const auto& value) { toml.put(key, value); };
  if (motion.skate) {
    toml.heading("skate");
    visit_skate(*motion.skate, put);
    return;
  }
  if (motion.flight) {
    toml.heading("flight");
    visit_flight_jog(*motion.flight, put);
    return;
  }
  toml.heading("retarget");
  toml.put("kind", std::string(to_string(motion.recipe.kind)));
  visit_recipe(motion.recipe, put);
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
  toml.line(std::string("# A motion of sanso. Made by `sanso motions ") +
            (motion.skate    ? "skate"
             : motion.flight ? "jog"
                             : "import") +
            "`; the weights and clauses may be edited by hand.");
  toml.put("format", kFormat);
  toml.put("name", motion.name);
  toml.put("title", motion.title);
  toml.heading("source");
  toml.put("credit", motion.source.credit);
  toml.put("licence", motion.source.licence);
  toml.put("changes", motion.source.changes);
  write_making(toml, motion);
  toml.heading("cost");
  toml.line(
      "# diagonal of W_x per m^2, rad^2, (m/s)^2, (rad/s)^2 and of W_u per rad^2; no factor 1/2");
  for (const WeightGroup& group : kStateWeights)
    toml.put(group.key, motion.weights.state[group.from]);
  const double rise = motion.weights.state[model::kDVel + 2];  // of base_velocity, where it differs
  if (rise != motion.weights.state[model::kDVel]) toml.put("base_rise", rise);
  toml.put("input", motion.weights.input[0]);
  if (motion.target_rate_rad_s) {
    toml.heading("controller");
    toml.put("max_target_rate_rad_s", *motion.target_rate_rad_s);
  }
  toml.heading("stop");
  toml.put("cost_limit", motion.stop.cost_limit);
  toml.put("tilt_limit_rad", motion.stop.tilt_limit_rad);
  toml.put("drop_limit_m", motion.stop.drop_limit_m);
  write_success(toml, motion);
  write_primitives(toml, motion.primitives);
  return toml.text();
}

Motion parse_motion(const std::string& toml, const std::string& name_for_messages) {
  try {
    return read_document(TomlTable::parse(toml, name_for_messages));
  } catch (const files::InputError& error) {
    throw MotionError(error.what());
  }
}

Motion read_motion(const std::filesystem::path& path) {
  try {
    return read_document(TomlTable::read(path.string()));
  } catch (const files::InputError& error) {
    throw MotionError(error.what());
  }
}

void write_motion(const std::filesystem::path& path, const Motion& motion) {
  files::write_atomically(path, to_toml(motion));
}

}  // namespace sanso::motion
