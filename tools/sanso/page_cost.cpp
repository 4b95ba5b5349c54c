// Times are those that the sessions have stored: of every tick the controller's own clock at its
// start and the processor time that it took, of every policy the wall time to it.
#include "tools/sanso/page_cost.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "host/app/learn_command.h"
#include "host/learn/session/summary.h"
#include "tools/sanso/browser.h"
#include "tools/sanso/page_option.h"

namespace sanso::cli {
namespace {

namespace fs = std::filesystem;
constexpr double kQuantiles[] = {0.5, 0.99, 0.999, 1.0};

/// All trials of one kind.
struct Times {
  std::vector<float> start_us;   // how far from 10 ms a tick begins after the one before it
  std::vector<float> tick_us;    // processor time of the tick
  std::vector<float> update_ms;  // from observation to policy
  int trials = 0, failed = 0, late_ticks = 0, late_updates = 0, bus_lost = 0;
};

void add(const learn::Episode& episode, Times& times) {
  ++times.trials;
  times.failed += episode.end == learn::TrialEnd::completed ? 0 : 1;
  for (std::size_t k = 0; k < episode.ticks.size(); ++k) {
    const wire::Observation& o = episode.ticks[k];
    times.tick_us.push_back(static_cast<float>(o.tick_cpu_ns) * 1e-3F);
    if (k == 0 || o.tick != episode.ticks[k - 1].tick + 1) continue;
    const auto off = static_cast<double>(o.time - episode.ticks[k - 1].time - kTickPeriod);
    times.start_us.push_back(static_cast<float>(std::abs(off) * 1e-3));
  }
  if (!episode.ticks.empty()) {
    const wire::Observation &first = episode.ticks.front(), &last = episode.ticks.back();
    times.late_ticks += static_cast<int>(last.late_ticks - first.late_ticks);
    times.bus_lost += static_cast<int>(last.bus_lost - first.bus_lost);
  }
  for (const learn::PlanRecord& plan : episode.plans) {
    times.update_ms.push_back(static_cast<float>(plan.update_ms));
    times.late_updates += plan.late;
  }
}

/// One session with new processes; its trials are added to `times`.
void run(const PageCostOptions& asked, const fs::path& out, page::LivePage* page, Times& times) {
  app::LearnOptions options;
  options.motion = asked.motion;
  options.iterations = asked.trials;
  options.robot = "emulated";
  options.out = out;
  options.quiet = true;
  options.watcher = page;
  fs::remove_all(out);
  (void)app::learn(options, watched(page));
  for (int trial = 0; trial < asked.trials; ++trial) {
    const fs::path stored = learn::trial_file(out, static_cast<std::uint32_t>(trial));
    if (fs::exists(stored)) add(learn::load_episode(stored), times);
  }
}

nlohmann::json json_of(const Times& t) {
  nlohmann::json out = {{"trials", t.trials},
                        {"failed", t.failed},
                        {"ticks", t.tick_us.size()},
                        {"late_ticks", t.late_ticks},
                        {"updates", t.update_ms.size()},
                        {"late_updates", t.late_updates},
                        {"bus_lost", t.bus_lost}};
  for (const auto& [name, values] :
       {std::pair<const char*, const std::vector<float>&>{"start_us", t.start_us},
        {"tick_us", t.tick_us},
        {"update_ms", t.update_ms}})
    for (const double p : kQuantiles)
      out[name].push_back(values.empty() ? 0.0 : learn::percentile(values, p));
  return out;
}

void print(const char* name, const nlohmann::json& j) {
  const auto four = [&](const char* key, const char* unit) {
    std::string out;
    for (const nlohmann::json& value : j.at(key))
      out += fmt::format("{}{:.4g}", out.empty() ? "" : " / ", value.get<double>());
    return out + " " + unit;
  };
  fmt::print(
      "{}: {} trials, {} failed\n"
      "  begin of a tick, off by       {} (p50 / p99 / p99.9 / max), {} of {} ticks late\n"
      "  processor time of a tick      {}\n"
      "  policy update, of 60 ms       {}, {} of {} late\n"
      "  replies of servos lost        {}\n",
      name, j.at("trials").get<int>(), j.at("failed").get<int>(), four("start_us", "us"),
      j.at("late_ticks").get<int>(), j.at("ticks").get<int>(), four("tick_us", "us"),
      four("update_ms", "ms"), j.at("late_updates").get<int>(), j.at("updates").get<int>(),
      j.at("bus_lost").get<int>());
}

}  // namespace

int bench_page(const PageCostOptions& options) {
  const fs::path browser = find_browser(options.browser, "bench page");
  Times without, with;
  for (int round = 0; round < options.rounds; ++round) {
    run(options, options.out / fmt::format("round_{}_without", round), nullptr, without);
    PageOptions wanted;
    wanted.port = 0;
    const std::unique_ptr<page::LivePage> page = serve_page(wanted, "emulated", "lab");
    if (!page) return 2;
    HeadlessBrowser viewer(browser, page->address());
    run(options, options.out / fmt::format("round_{}_with", round), page.get(), with);
    if (!viewer.running() || page->broadcast().viewers() == 0) {
      fmt::print(stderr, "sanso bench page: nobody looked at the page: {}\n", viewer.last_words());
      return 2;
    }
  }
  const nlohmann::json a = json_of(without), b = json_of(with);
  if (options.json) {
    fmt::print("{}\n", nlohmann::json{{"without", a}, {"with", b}}.dump(1));
  } else {
    print("without the page", a);
    print("with the page open in a browser", b);
  }
  return with.late_updates > 0 && without.late_updates == 0 ? 1 : 0;
}

}  // namespace sanso::cli
