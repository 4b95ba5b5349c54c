// `sanso learn`: options. Which robot stands behind the name that `--robot` gives: page_option.
#include <fmt/format.h>

#include <memory>

#include "host/app/learn_command.h"
#include "tools/sanso/commands.h"
#include "tools/sanso/page_option.h"
#include "tools/session_report/session_report.h"

namespace sanso::cli {
void add_learn(CLI::App& app, int& result) {
  auto options = std::make_shared<app::LearnOptions>();
  CLI::App* command = app.add_subcommand("learn", "run and learn a motion, trial by trial");
  command->add_option("--motion", options->motion, "name of a motion file (see sanso motions)")
      ->required();
  command
      ->add_option("--iterations", options->iterations,
                   "trials in all, including those of a resumed session")
      ->required()
      ->check(CLI::Range(1, 100000));
  command
      ->add_option(
          "--robot", options->robot,
          "in-process (virtual clock), emulated (three processes, real clock) or HOST:PORT of a "
          "controller")
      ->capture_default_str();
  command->add_option("--key", options->key,
                      "with HOST:PORT: file of 64 hexadecimal digits, the controller's key_file");
  command
      ->add_option("--out", options->out,
                   "folder of the session: episodes, state, summary.json, report.html")
      ->required();
  command->add_flag("--resume", options->resume,
                    "continue the session in --out after its last finished trial");
  command->add_option("--seed", options->seed, "of everything random; same seed, same bits")
      ->capture_default_str();
  command
      ->add_option("--without", options->without,
                   "switch off: lower, middle, upper, residual, stochastic")
      ->delimiter(',');
  command
      ->add_option(
          "--world", options->world,
          "of the emulated robot: nominal, lab, hard, back, worst, tired, seed:N, honest:N, "
          "honest:NxWIDTH (further from the maker's figures) or a TOML file")
      ->capture_default_str();
  command
      ->add_option("--ground", options->ground,
                   "where the robot stands: plane, slope3, ramp, ramp_high, jump_ramp, plates, "
                   "stairs or a profile file (shared/grounds/README.md)")
      ->capture_default_str();
  command->add_option("--threads", options->threads, "of the planner")
      ->capture_default_str()
      ->check(CLI::Range(1, 64));
  command
      ->add_option("--profile", options->profile,
                   "settings to begin with: ours, or paper (what the paper prints)")
      ->capture_default_str();
  command->add_option("--set", options->set,
                      "a setting of planner or session, NAME=VALUE, may be given more than once; "
                      "docs/settings-learn.md has them all");
  command->add_option("--adopt", options->adopt,
                      "verdict.json: what it confirmed goes into the planner's first model");
  command->add_flag_callback(
      "--settings",
      [] {
        fmt::print("{}", app::learn_settings_page());
        throw CLI::Success();
      },
      "print all settings with default, range and reason");
  command->footer(
      "Examples:\n"
      "  sanso learn --motion squat --iterations 100 --out results/squat\n"
      "  sanso learn --motion squat --iterations 200 --out results/squat --resume\n"
      "  sanso learn --motion squat --iterations 20 --out results/no_upper --without upper "
      "--world hard\n"
      "  sanso learn --motion stand --iterations 5 --out results/bars --ground plates\n"
      "  sanso learn --motion squat --iterations 20 --out results/paper --profile paper\n"
      "  sanso learn --motion stand --iterations 9 --out results/short --set mpc.horizon=8 "
      "--set session.learn_after_failures=2\n"
      "  sanso learn --motion squat --iterations 20 --out named --adopt found/verdict.json");
  auto page_options = std::make_shared<PageOptions>();
  add_page_options(*command, *page_options);
  command->callback([options, page_options, &result] {
    const auto page = serve_page(*page_options, options->robot, options->world, options->ground);
    result = learn_with_page(*options, page.get(), *page_options, [](const auto& done) {
      fmt::print("report: {}\n", report::write_session_report(done.out).string());
    });
  });
}

}  // namespace sanso::cli
