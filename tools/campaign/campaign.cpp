// Spreads the scenarios over threads; each has a robot of its own, so the order does not matter.
#include "tools/campaign/campaign.h"

#include <fmt/format.h>

#include <mutex>
#include <stdexcept>

#include "shared/files/atomic_file.h"
#include "shared/files/parallel.h"
#include "tools/campaign/run_scenario.h"

namespace sanso::campaign {
namespace {

std::vector<Row> chosen(const std::string& filter) {
  std::vector<Row> rows;
  for (Scenario& scenario : scenarios())
    if (scenario.name().find(filter) != std::string::npos)
      rows.push_back({std::move(scenario), {}});
  return rows;
}

void run(Row& row, std::uint64_t seed) {
  try {
    row.found = run_scenario(row.scenario, seed);
  } catch (const std::runtime_error& error) {
    row.found.broken.push_back(error.what());
  }
}

void run_all(std::vector<Row>& rows, const Options& options) {
  std::mutex printing;
  files::parallel_for(rows.size(), options.threads, [&](std::size_t i) {
    run(rows[i], options.seed);
    const std::lock_guard lock(printing);
    fmt::print(stderr, "{}\n", line_of(rows[i]));
  });
}

}  // namespace

int bench_faults(const Options& options) {
  std::vector<Row> rows = chosen(options.filter);
  if (rows.empty()) {
    fmt::print(stderr, "no scenario has \"{}\" in its name; expected a part of one like \"{}\"\n",
               options.filter, scenarios().front().name());
    return 2;
  }
  run_all(rows, options);
  std::size_t failed = 0;
  for (const Row& row : rows) failed += row.found.passed() ? 0 : 1;
  if (options.json) fmt::print("{}\n", json_of(rows, options));
  if (!options.page.empty()) files::write_atomically(options.page, page_of(rows, options));
  fmt::print(stderr, "{} scenarios, {} not as expected\n", rows.size(), failed);
  return failed == 0 ? 0 : 1;
}

}  // namespace sanso::campaign
