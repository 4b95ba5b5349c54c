// `sanso bench`: one subcommand a benchmark, its options, and where its numbers go (table or
// --json).
#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <type_traits>

#include "tools/bench/bench_dynamics.h"
#include "tools/bench/bench_tick.h"
#include "tools/bench/mpc/bench_mpc.h"
#include "tools/campaign/campaign.h"
#include "tools/campaign/falls.h"
#include "tools/campaign/soak.h"
#include "tools/sanso/commands.h"
#include "tools/sanso/loop_study.h"
#include "tools/sanso/page_cost.h"

namespace sanso::cli {
namespace {

struct Bench {
  const char* name;
  const char* about;
  int (*run)(bool json);
};

constexpr std::array kBenches{
    Bench{"dynamics", "one 60 ms step of the whole body: time, arithmetic, share of the peak",
          bench::bench_dynamics},
    Bench{"tick", "one 10 ms tick of the controller", bench::bench_tick},
    Bench{"bus", "one bus cycle, by arithmetic", bench::bench_bus},
};

/// `sanso bench mpc`: the only one with settings of its own.
void add_mpc(CLI::App& bench, int& result) {
  auto o = std::make_shared<bench::BenchMpcOptions>();
  CLI::App* command = bench.add_subcommand(
      "mpc", "one policy update along a motion, beside the same iLQG on MuJoCo");
  command->add_flag("--json", o->json, "figures as JSON");
  command->add_option("--updates", o->updates, "policy updates timed")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  command->add_flag("--peer", o->peer, "also run the peer, interleaved, and print the ratio");
  command->add_option("--peer-updates", o->peer_updates, "updates that the peer repeats")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  command
      ->add_option("--motion", o->motion,
                   "motion of the library whose states the updates start from")
      ->capture_default_str();
  command->add_option("--disturbance", o->disturbance, "1: centimetres, hundredths of a radian")
      ->check(CLI::Range(0.0, 10.0))
      ->capture_default_str();
  command->add_option("--lanes", o->lanes,
                      "avx512, avx2 or portable; default the widest this processor has");
  command->add_option("--budget-ms", o->budget_ms, "time given to the solver; 0: none")
      ->check(CLI::Range(0.0, 1000.0))
      ->capture_default_str();
  command->add_flag("!--no-residual", o->residual, "without the residual network");
  o->mpc.visit([&](const char* name, auto& value, const char*, auto low, auto high,
                   const char* reason) {
    std::string flag = std::string("--") + name;
    std::replace(flag.begin(), flag.end(), '_', '-');
    if constexpr (std::is_same_v<std::decay_t<decltype(value)>, bool>)
      command->add_flag(flag, value, reason);
    else
      command->add_option(flag, value, reason)->check(CLI::Range(low, high))->capture_default_str();
  });
  command->footer("Example:\n  sanso bench mpc --threads 2 --peer");
  command->callback([o, &result] { result = bench::bench_mpc(*o); });
}

void add_loop(CLI::App& bench, int& result) {
  auto o = std::make_shared<LoopStudyOptions>();
  CLI::App* command =
      bench.add_subcommand("loop", "what update period, horizon and iterations buy in closed loop");
  command->add_flag("--json", o->json, "figures as JSON");
  command->add_option("--seeds", o->seeds, "trials of each task")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command->add_option("--push-N", o->push_N, "forward push of 0.1 s")
      ->check(CLI::Range(0.0, 200.0))
      ->capture_default_str();
  command->add_option("--threads", o->threads, "of the planner")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  command->add_flag("--only-default", o->only_default, "one case: 60 ms, 0.72 s, to convergence");
  command->add_option("--figure", o->figure, "write the push's costs as SVG");
  command->callback([o, &result] { result = bench_loop(*o); });
}

void add_faults(CLI::App& bench, int& result) {
  auto o = std::make_shared<campaign::Options>();
  CLI::App* command = bench.add_subcommand(
      "faults",
      "what the controller makes of each fault, in virtual time (docs/results/faults.md)");
  command->add_flag("--json", o->json, "rows as JSON");
  command->add_option("--filter", o->filter, "only scenarios with this in their name");
  command->add_option("--seed", o->seed, "of the emulated robots")->capture_default_str();
  command->add_option("--threads", o->threads, "scenarios at a time")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  command->add_option("--page", o->page, "write the page to this file");
  command->footer("Example:\n  sanso bench faults --filter walk_forward/bus");
  command->callback([o, &result] { result = campaign::bench_faults(*o); });
}

void add_falls(CLI::App& bench, int& result) {
  auto o = std::make_shared<campaign::FallOptions>();
  CLI::App* command = bench.add_subcommand(
      "falls", "a robot pushed over, its limbs drawn in before the impact and not");
  command->add_flag("--json", o->json, "falls as JSON");
  command->add_option("--directions", o->directions, "of the push, around the robot")
      ->check(CLI::Range(1, 360))
      ->capture_default_str();
  command->add_option("--push-N", o->push_N, "at the torso, for 0.15 s")
      ->check(CLI::Range(0.0, 500.0))
      ->capture_default_str();
  command->add_option("--seed", o->seed, "of the emulated robots")->capture_default_str();
  command->add_option("--world", o->world, "of the robot")->capture_default_str();
  command->footer("Example:\n  sanso bench falls --directions 8 --push-N 80");
  command->callback([o, &result] { result = campaign::bench_falls(*o); });
}

void add_soak(CLI::App& bench, int& result) {
  auto o = std::make_shared<campaign::SoakOptions>();
  CLI::App* command =
      bench.add_subcommand("soak", "one controller for many ticks under random faults and hosts");
  command->add_flag("--json", o->json, "figures as JSON");
  command->add_option("--ticks", o->ticks, "of 10 ms; 8640000 are a day")
      ->check(CLI::Range(std::int64_t{1}, std::int64_t{1'000'000'000}))
      ->capture_default_str();
  command->add_option("--seed", o->seed, "of everything random")->capture_default_str();
  command
      ->add_option("--world", o->world,
                   "of the robot; hung: no physics of a body, many times as fast")
      ->capture_default_str();
  command->footer("Example:\n  sanso bench soak --world hung --ticks 8640000");
  command->callback([o, &result] { result = campaign::bench_soak(*o); });
}

void add_page(CLI::App& bench, int& result) {
  auto o = std::make_shared<PageCostOptions>();
  CLI::App* command = bench.add_subcommand(
      "page", "times of tick and policy with the live page open in a browser, and without it");
  command->add_flag("--json", o->json, "figures as JSON");
  command->add_option("--motion", o->motion, "name of a motion file")->capture_default_str();
  command->add_option("--rounds", o->rounds, "of a session without and one with the page")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  command->add_option("--trials", o->trials, "of each session")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  command->add_option("--browser", o->browser, "chromium, if it is not found by itself");
  command->add_option("--out", o->out, "folder of the sessions")->capture_default_str();
  command->footer("Example:\n  sanso bench page --rounds 5");
  command->callback([o, &result] { result = bench_page(*o); });
}

void add_simple(CLI::App& bench, const Bench& b, int& result) {
  auto json = std::make_shared<bool>(false);
  CLI::App* command = bench.add_subcommand(b.name, b.about);
  command->add_flag("--json", *json, "figures as JSON");
  command->footer(std::string("Example:\n  sanso bench ") + b.name);
  command->callback([run = b.run, json, &result] { result = run(*json); });
}

}  // namespace

void add_bench(CLI::App& app, int& result) {
  CLI::App* bench = app.add_subcommand("bench", "timing against the budgets of docs/tour.md");
  bench->require_subcommand(1);
  bench->footer("Example:\n  sanso bench tick");
  add_mpc(*bench, result);
  add_loop(*bench, result);
  add_faults(*bench, result);
  add_falls(*bench, result);
  add_soak(*bench, result);
  add_page(*bench, result);
  for (const Bench& b : kBenches) add_simple(*bench, b, result);
}

}  // namespace sanso::cli
