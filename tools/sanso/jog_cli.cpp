// `sanso motions jog`: from a robot's own trials to a jog that flies. Its servos are identified at
// 10 ms, the figures are searched that fly best on that model, their rehearsal becomes a motion.
#include <fmt/format.h>

#include <atomic>
#include <charconv>
#include <cmath>
#include <limits>
#include <memory>
#include <system_error>
#include <thread>

#include "host/learn/model/identify_fine.h"
#include "host/learn/session/progress.h"
#include "host/motion/make/rehearse.h"
#include "tools/sanso/commands.h"

namespace sanso::cli {
namespace {

namespace fs = std::filesystem;

struct JogOptions {
  std::string name;
  fs::path session, out = ".";
  std::vector<int> trials = {1, 2, 3};
  int generations = 6, threads = 2;
  std::uint64_t seed = 1;
  std::vector<std::string> figures;
};

/// Of "KEY=VALUE"; throws where the value is no finite number.
double value_of(const std::string& text, std::size_t sign) {
  double value = NAN;
  const char* const end = text.data() + text.size();
  const auto [read, error] = std::from_chars(text.data() + sign + 1, end, value);
  if (error != std::errc() || read != end || !std::isfinite(value))
    throw std::runtime_error("--set " + text + ": expected a number behind the sign =");
  return value;
}

void set_figure(motion::FlightJog& jog, const std::string& text) {
  const std::size_t sign = text.find('=');
  std::string known;
  bool found = false;
  motion::visit_flight_jog(jog, [&](const std::string& key, auto& value) {
    known += (known.empty() ? "" : ", ") + key;
    if (sign == std::string::npos || key != text.substr(0, sign)) return;
    value = static_cast<std::decay_t<decltype(value)>>(value_of(text, sign));
    found = true;
  });
  if (!found) throw std::runtime_error("--set " + text + ": no such figure; there are: " + known);
}

/// Of the robot that ran these trials.
model::ModelParameters identified(const JogOptions& o) {
  std::vector<learn::FineWindow> windows;
  constexpr int kFirstTick = 60, kStride = 4;  // the robot stands at first
  for (const int trial : o.trials) {
    const fs::path file = learn::trial_file(o.session, static_cast<std::uint32_t>(trial - 1));
    const auto some = learn::fine_windows_of(learn::load_episode(file), kFirstTick, kStride);
    windows.insert(windows.end(), some.begin(), some.end());
  }
  constexpr double kDuty = 0.9;  // of the controller's guard
  model::ModelParameters initial = model::nominal_parameters();
  for (model::ServoParameters& servo : initial.servo) servo.torque_limit *= kDuty;
  const learn::FineIdentification found =
      learn::identify_fine(windows, learn::ParameterMap(initial), model::make_plane(), o.seed);
  const model::ServoParameters& knee = found.parameters.servo[3];
  fmt::print(
      "{} windows of 0.1 s: loss {:.3f} -> {:.3f}; servo {:.2f} N m/rad, {:.2f} N m s/rad, rotor "
      "{:.4f} kg m^2, dry friction {:.2f} N m, delay {:.0f} ms; "
      "trunk {:.2f} kg, centre {:.1f} mm\n",
      windows.size(), found.loss_initial, found.loss, knee.stiffness, knee.damping, knee.armature,
      knee.coulomb, 1e3 * found.delay_s, found.parameters.body[0].mass,
      1e3 * found.parameters.body[0].com[0]);
  return found.parameters;
}

/// Rhythm, bounce and feet vary about what is given, not the way. `z` in spreads.
constexpr int kVaried = 10;
motion::FlightJog varied(const motion::FlightJog& given, const Eigen::VectorXd& z) {
  constexpr double kSpread = 0.1, kStraight = 0.93;
  motion::FlightJog jog = given;
  double* const figures[kVaried] = {
      &jog.period_s, &jog.flight_s,  &jog.lift_off_m_s, &jog.absorb_s, &jog.swing_height_m,
      &jog.heel_rad, &jog.heel_up_s, &jog.heel_down_s,  &jog.toe_rad,  &jog.kappa};
  for (int i = 0; i < kVaried - 1; ++i) *figures[i] *= std::exp(kSpread * z[i]);
  jog.kappa = std::min(kStraight, jog.kappa * std::exp(0.3 * kSpread * z[kVaried - 1]));
  return jog;
}

/// Figures that make no jog are worse than any that do.
double loss_of(const motion::FlightJog& figures, const model::StepModel& model) {
  try {
    return -motion::worth(motion::rehearse(motion::flight_reference(figures), model));
  } catch (const motion::ClipError&) {
    return std::numeric_limits<double>::infinity();
  }
}

/// The losses of all candidates; any number of threads gives the same.
std::vector<double> losses_of(const Eigen::MatrixXd& candidates, const motion::FlightJog& given,
                              const model::StepModel& model, int threads) {
  std::vector<double> losses(static_cast<std::size_t>(candidates.cols()));
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    for (std::size_t i = next++; i < losses.size(); i = next++)
      losses[i] = loss_of(varied(given, candidates.col(static_cast<Eigen::Index>(i))), model);
  };
  std::vector<std::thread> helpers(static_cast<std::size_t>(threads) - 1);
  for (std::thread& helper : helpers) helper = std::thread(work);
  work();
  for (std::thread& helper : helpers) helper.join();
  return losses;
}

/// The best that the cross-entropy method finds in the model, over the very run that the motion is
/// made of: contacts make a rehearsal chaotic, and what flies over fewer steps need not over more.
motion::FlightJog optimised(const motion::FlightJog& given, const model::StepModel& model,
                            const JogOptions& o) {
  const learn::EvaluateCandidates evaluate = [&](const Eigen::MatrixXd& candidates) {
    return losses_of(candidates, given, model, o.threads);
  };
  learn::CrossEntropySettings search;
  search.population = 12;
  search.elites = 4;
  search.smallest_deviation = 0.1;
  learn::CrossEntropyState state = learn::start_cross_entropy(
      Eigen::VectorXd::Zero(kVaried), Eigen::VectorXd::Ones(kVaried), evaluate);
  learn::Progress progress(stdout, "figures", o.generations);
  for (int i = 0; i < o.generations; ++i) {
    learn::advance_cross_entropy(state, search, o.seed, evaluate);
    progress.update(i + 1, fmt::format("worth {:.1f}", -state.best_loss));
  }
  return varied(given, state.best);
}

void make(const JogOptions& o) {
  motion::FlightJog given;
  for (const std::string& figure : o.figures) set_figure(given, figure);
  const model::StepModel model = model::make_step_model(identified(o));
  const motion::FlightJog jog = optimised(given, model, o);
  const motion::FlightReference reference = motion::flight_reference(jog);
  const motion::Rehearsal r = motion::rehearse(reference, model);
  const motion::Motion made = motion::jog_motion(o.name, jog, reference, r);
  fmt::print(
      "in the model {:.0f} % of the steps fly 20 ms, {:.0f} % 28 ms; double support {:.1f} %, tilt "
      "{:.1f} deg\n",
      100.0 * r.flight_share(0.02), 100.0 * r.flight_share(0.028), 100.0 * r.double_support_share,
      57.29578 * r.largest_tilt_rad);
  fs::create_directories(o.out);
  motion::write_motion(o.out / (o.name + ".toml"), made);
  fmt::print("motion: {}\n", (o.out / (o.name + ".toml")).string());
}

}  // namespace

void add_jog(CLI::App& motions) {
  auto options = std::make_shared<JogOptions>();
  CLI::App* command = motions.add_subcommand(
      "jog", "make a jog that flies for the robot that ran a session, from its own servos");
  command->add_option("NAME", options->name, "name of the motion")->required();
  command->add_option("--session", options->session, "folder of a session in its world")
      ->required()
      ->check(CLI::ExistingDirectory);
  command->add_option("--trials", options->trials, "of it that are looked at, from 1")
      ->delimiter(',')
      ->check(CLI::PositiveNumber);
  command
      ->add_option("--generations", options->generations,
                   "of the search for better figures in the model; 0: as given")
      ->capture_default_str()
      ->check(CLI::Range(0, 1000));
  command->add_option("--threads", options->threads, "of the search")
      ->capture_default_str()
      ->check(CLI::Range(1, 64));
  command->add_option("--seed", options->seed, "of identification and search")
      ->capture_default_str();
  command->add_option("--set", options->figures, "a figure of [flight], KEY=VALUE");
  command->add_option("--out", options->out, "folder")->capture_default_str();
  command->footer(
      "Examples:\n  sanso learn --motion jog --iterations 3 --out runs/jog\n"
      "  sanso motions jog my_jog --session runs/jog --out my_motions\n"
      "  SANSO_MOTIONS=my_motions sanso learn --motion my_jog --iterations 20 --out runs/my_jog");
  command->callback([options] { make(*options); });
}

}  // namespace sanso::cli
