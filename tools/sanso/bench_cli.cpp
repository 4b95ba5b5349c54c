#include <array>
#include <memory>
#include <string>
#include <vector>

#include "tools/bench/bench_dynamics.h"
#include "tools/bench/bench_tick.h"
#include "tools/bench/mpc/bench_mpc.h"
#include "tools/sanso/commands.h"

namespace sanso::cli {
namespace {

struct Bench {
  const char* name;
  int (*run)(bool json);
};

int bench_mpc(bool json) {
  bench::BenchMpcOptions options;
  options.json = json;
  options.peer = true;
  return bench::bench_mpc(options);
}

constexpr std::array kBenches{
    Bench{"mpc", bench_mpc},
    Bench{"dynamics", bench::bench_dynamics},
    Bench{"tick", bench::bench_tick},
    Bench{"bus", bench::bench_bus},
};

}  // namespace

void add_bench(CLI::App& app, int& result) {
  struct Options {
    std::string what;
    bool json = false;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("bench", "timing against the budgets of docs/tour.md");
  std::vector<std::string> names;
  for (const Bench& b : kBenches) names.emplace_back(b.name);
  command->add_option("what", options->what, "what to time")->required()->check(CLI::IsMember(names));
  command->add_flag("--json", options->json, "figures as JSON");
  command->footer("Example:\n  sanso bench tick");
  command->callback([options, &result] {
    for (const Bench& b : kBenches)
      if (options->what == b.name) result = b.run(options->json);
  });
}

}  // namespace sanso::cli
