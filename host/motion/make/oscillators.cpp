// Inner steps of 1 ms: the fastest rate, a = 8 / rise, is far below.
#include "host/motion/make/oscillators.h"

#include <algorithm>
#include <cmath>

#include "shared/files/toml.h"
#include "shared/model/joints.h"

namespace sanso::motion {
namespace {

using files::TomlTable;

using model::kPi;
constexpr double kDeg = kPi / 180.0;
constexpr double kLimitCycleStep_s = 0.001;

int joint_of(const TomlTable& table, const std::string& name) {
  std::string known;
  for (int j = 0; j < model::kNumJoints; ++j) {
    if (name == model::kJoints[j].name) return j;
    known += (known.empty() ? "" : ", ") + std::string(model::kJoints[j].name);
  }
  table.fail(name, "no such joint", name, "one of " + known);
}

Oscillator read_oscillator(const TomlTable& entry) {
  Oscillator o;
  o.frequency_Hz = entry.need("frequency_Hz", entry.number("frequency_Hz", 0.05, 5.0),
                              "a number from 0.05 to 5");
  TomlTable::into(o.lag_rad, entry.number("lag_deg", -360.0, 360.0));
  o.lag_rad *= kDeg;
  const TomlTable amplitudes =
      entry.need("amplitude_deg", entry.table("amplitude_deg"), "a table of degrees by joint");
  for (const std::string& joint : amplitudes.keys())
    o.amplitude_rad[joint_of(amplitudes, joint)] = kDeg * *amplitudes.number(joint, -45.0, 45.0);
  entry.finish();
  return o;
}

void require_one_rhythm(const TomlTable& root, const RecordRecipe& recipe) {
  const double f = recipe.oscillators.front().frequency_Hz;
  for (const Oscillator& o : recipe.oscillators)
    if (o.frequency_Hz != f)
      root.fail("oscillator", "a rhythmic recording has one frequency",
                files::toml_number(o.frequency_Hz), files::toml_number(f));
  const double ticks = 100.0 / f;
  if (std::abs(ticks - std::round(ticks)) > 1e-6)
    root.fail("oscillator", "its period is not a whole number of 10 ms", files::toml_number(f),
              files::toml_number(100.0 / std::round(ticks)));
}

}  // namespace

const char* const kExampleRecordRecipe =
    R"(# A recording: oscillators move the robot, a hand holds it
like = "skate_ramp"    # posture, ground, weights and clauses of this motion
kind = "discrete"      # or "rhythmic"
coupling = 5.0         # 1/s
rise_s = 0.5           # amplitudes grow within this time
basis_per_second = 20.0

[[oscillator]]         # from side to side: ankles against hips
frequency_Hz = 0.5
amplitude_deg = { r_hip_roll = 2, l_hip_roll = 2, r_ank_roll = -2, l_ank_roll = -2 }

[[oscillator]]         # up and down: the trunk keeps its attitude
frequency_Hz = 0.5
lag_deg = 90
[oscillator.amplitude_deg]
r_hip_pitch = 2
r_knee = -4
r_ank_pitch = -2
l_hip_pitch = -2
l_knee = 4
l_ank_pitch = 2
)";

RecordRecipe parse_record_recipe(const std::string& text, const std::string& file) {
  const TomlTable root = TomlTable::parse(text, file);
  RecordRecipe r;
  r.like = root.need("like", root.string("like"), "the name of a motion");
  r.rhythmic = root.choice("kind", {"discrete", "rhythmic"}).value_or(0) == 1;
  TomlTable::into(r.duration_s, root.number("duration_s", 0.5, 60.0));
  TomlTable::into(r.coupling, root.number("coupling", 0.0, 50.0));
  TomlTable::into(r.rise_s, root.number("rise_s", 0.1, 10.0));
  TomlTable::into(r.basis_per_second, root.number("basis_per_second", 2.0, 50.0));
  TomlTable::into(r.hand, root.number("hand", 0.0, 1.0));
  if (const auto cycles = root.integer("cycles", 1, 20)) r.cycles = static_cast<int>(*cycles);
  for (const TomlTable& entry : root.tables("oscillator"))
    r.oscillators.push_back(read_oscillator(entry));
  if (r.oscillators.empty()) root.fail("oscillator", "missing", "", "at least one [[oscillator]]");
  if (r.rhythmic) require_one_rhythm(root, r);
  root.finish();
  return r;
}

Oscillators::Oscillators(const RecordRecipe& recipe, std::vector<double> phase_rad)
    : oscillators_(recipe.oscillators),
      coupling_(recipe.coupling),
      gain_(8.0 / recipe.rise_s),
      phase_(std::move(phase_rad)) {
  if (!phase_.empty()) return;
  for (const Oscillator& o : oscillators_) phase_.push_back(o.lag_rad);
}

void Oscillators::step(double dt_s) {
  const int inner = std::max(1, static_cast<int>(std::lround(dt_s / kLimitCycleStep_s)));
  const double h = dt_s / inner;
  std::vector<double> rate(phase_.size());
  for (int k = 0; k < inner; ++k) {
    for (std::size_t i = 0; i < phase_.size(); ++i) {
      rate[i] = 2.0 * kPi * oscillators_[i].frequency_Hz;
      for (std::size_t j = 0; j < phase_.size(); ++j)
        rate[i] += coupling_ * std::sin((phase_[j] - oscillators_[j].lag_rad) -
                                        (phase_[i] - oscillators_[i].lag_rad));
    }
    for (std::size_t i = 0; i < phase_.size(); ++i) phase_[i] += h * rate[i];
    amplitude_rate_ += h * gain_ * (gain_ / 4.0 * (1.0 - amplitude_) - amplitude_rate_);
    amplitude_ += h * amplitude_rate_;
  }
}

model::Input Oscillators::offset() const {
  model::Input sum = model::Input::Zero();
  for (std::size_t i = 0; i < phase_.size(); ++i)
    sum += amplitude_ * std::sin(phase_[i]) * oscillators_[i].amplitude_rad;
  return sum;
}

}  // namespace sanso::motion
