// Any bytes are either a world of the emulated robot or a WorldError.
#include "tools/plant/world.h"
#include "tools/plant/world_error.h"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  try {
    sanso::plant::parse_world({reinterpret_cast<const char*>(data), size}, "fuzz.toml");
  } catch (const sanso::plant::WorldError&) {
  }
  return 0;
}
