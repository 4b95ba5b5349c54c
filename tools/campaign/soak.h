// `sanso bench soak`: one controller for as many ticks as wanted, while hosts come and go and
// random faults come and pass. Laws that no tick may break are looked at in every tick.
#pragma once

#include <cstdint>
#include <string>

namespace sanso::campaign {

struct SoakOptions {
  std::int64_t ticks = 100'000;  // 8.64 million are a day
  std::uint64_t seed = 1;
  std::string world = "lab";  // "hung": without the physics of a body, many times as fast
  bool json = false;
};

/// Exit code: 0 when no law was broken and the controller always came back to idle, else 1.
int bench_soak(const SoakOptions& options);

}  // namespace sanso::campaign
