// Uploads of all three kinds: they read or not, and what reads is usable.
#include <cstdlib>
#include <memory>

#include "shared/policy/layer_sum.h"
#include "shared/policy/policy_bytes.h"
#include "shared/policy/primitives.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace sanso;
  if (size == 0) return 0;
  const std::span<const std::uint8_t> data(bytes + 1, size - 1);
  static const auto upper = std::make_unique<policy::UpperPolicy>();
  static const auto middle = std::make_unique<policy::MiddleTable>();
  static const auto primitives = std::make_unique<policy::PrimitiveSet>();
  policy::Knot knot;
  switch (bytes[0] % 3) {
    case 0:
      if (policy::from_bytes(data, *upper) != Status::ok) break;
      if (upper->knots.empty()) std::abort();
      for (const double tick : {-1.0, 0.0, 7.5, 1e4}) {
        const double weight = policy::upper_weight(*upper, tick);
        if (!(weight >= 0 && weight <= 1)) std::abort();
        policy::sample_upper(*upper, tick, knot);
      }
      break;
    case 1:
      if (policy::from_bytes(data, *middle) != Status::ok) break;
      if (middle->knots.empty()) std::abort();
      policy::sample_middle(*middle, 4.0, knot);
      break;
    default:
      if (policy::from_bytes(data, *primitives) != Status::ok) break;
      policy::PrimitivePlayer player;
      player.reset(*primitives);
      for (int k = 0; k < 20; ++k) player.step();
  }
  return 0;
}
