// `sanso conceal` hides physics in a world; `sanso reveal` opens the sealed answer beside a
// verdict.
#include <fmt/format.h>

#include <memory>

#include "tools/conceal/conceal.h"
#include "tools/conceal/reveal.h"
#include "tools/sanso/commands.h"

namespace sanso::cli {

void add_conceal(CLI::App& app, int& result) {
  struct Options {
    conceal::ConcealOptions conceal;
    std::string family, effect;
    double ratio = 0;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "conceal", "hide physics in a world: recordings, nominal model, sealed answer");
  command->add_option("--seed", options->conceal.seed, "draws world, effect and severity")
      ->required();
  command->add_option("--robot", options->conceal.robot, "pendulum, arm, op3-stand or op3-floor")
      ->required();
  command->add_option("--out", options->conceal.out, "directory of the case")->required();
  command->add_option("--family", options->family,
                      "clean, single, pair, decoy, outside or ambiguous (drawn when not given)");
  command->add_option("--effect", options->effect, "which effect to hide (drawn when not given)");
  command->add_option("--ratio", options->ratio,
                      "severity: RMS of the change over noise RMS (drawn when not given)");
  command->footer("Example:\n  sanso conceal --seed 7 --robot pendulum --out case_7");
  command->callback([options, &result] {
    if (!options->family.empty()) {
      options->conceal.family = conceal::family_from_string(options->family);
      if (!options->conceal.family) {
        throw CLI::ValidationError("--family",
                                   "expected clean, single, pair, decoy, outside or ambiguous");
      }
    }
    if (!options->effect.empty()) options->conceal.effect = options->effect;
    if (options->ratio > 0) options->conceal.ratio = options->ratio;
    const conceal::Concealed made = conceal::conceal(options->conceal);
    fmt::print("model       {}\nrecordings  {} files in {}/recordings\nseal        {}\n",
               made.model, made.recordings.size(), options->conceal.out, made.hash);
    fmt::print(
        "next        sanso diagnose --model {} --recordings {}/recordings/*.csv --out "
        "{}/diagnosis\n",
        made.model, options->conceal.out, options->conceal.out);
    result = kDone;
  });
}

void add_reveal(CLI::App& app, int& result) {
  auto directory = std::make_shared<std::string>();
  auto verdict = std::make_shared<std::string>();
  CLI::App* command =
      app.add_subcommand("reveal", "open a sealed answer and compare a verdict with it");
  command->add_option("DIR", *directory, "case that `sanso conceal` made")->required();
  command->add_option("--verdict", *verdict, "verdict.json of `sanso diagnose`")->required();
  command->footer(
      "Exit code 0: the verdict is right, 1: it is not.\n"
      "Example:\n  sanso reveal case_7 --verdict case_7/diagnosis/verdict.json");
  command->callback([directory, verdict, &result] {
    const conceal::Score score = conceal::reveal(*directory, *verdict);
    fmt::print("{}\n", conceal::to_json(score));
    result = score.right ? kDone : kBadAnswer;
  });
}

}  // namespace sanso::cli
