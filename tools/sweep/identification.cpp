// The search of `sanso identify` with its losses shared over ranks: every rank holds the same
// state and the same numbers.
#include "tools/sweep/identification.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "host/app/interrupt.h"
#include "host/learn/wall_clock.h"

namespace sanso::sweep {
namespace {

using Json = nlohmann::ordered_json;

}  // namespace

learn::Identification identify_over(const Ranks& ranks, const app::IdentifyOptions& options,
                                    const app::IdentificationData& data) {
  const app::Interrupt interrupt;
  const auto stop = [&ranks] { return ranks.any(app::Interrupt::requested()); };
  return app::search_parameters(options, data, stop, ranks.shared_candidates(), ranks.rank() == 0);
}

int run_identification(const Ranks& ranks, const app::IdentifyOptions& given) {
  app::IdentifyOptions options = given;
  options.quiet = options.quiet || ranks.rank() != 0;
  const double begin = learn::wall_s();
  const app::IdentificationData data = app::load_identification_data(options);
  const learn::Identification found = identify_over(ranks, options, data);
  const bool complete = found.generations >= options.generations;
  if (ranks.rank() != 0) return complete ? 0 : 2;
  Json answer{{"ranks", ranks.size()},
              {"wall_s", learn::wall_s() - begin},
              {"bytes_per_generation", 8 * options.population}};
  answer.update(Json::parse(app::identification_json(options, data, found)));
  fmt::print("{}\n", answer.dump(2));
  return complete ? 0 : 2;
}

}  // namespace sanso::sweep
