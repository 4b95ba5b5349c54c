// Hosts that hold the key and mean no good: messages, uploads and requests in any order and at any
// age, to a controller that boots, stands or moves. The laws are in attacked_controller.cpp.
#include "tests/fuzz/link/attacked_controller.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace sanso::fuzz;
  constexpr int kMostSteps = 64;
  Input input(bytes, size);
  AttackedController attacked(static_cast<Start>(input.number(1) % 4));
  for (int n = 0; n < kMostSteps && !input.empty(); ++n) attacked.step(input);
  return 0;
}
