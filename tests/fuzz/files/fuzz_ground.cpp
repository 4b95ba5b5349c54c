// Any bytes are either a ground or a refusal, for the emulated robot and for the model alike.
#include "shared/files/input_error.h"
#include "shared/grounds/ground_file.h"
#include "tools/plant/ground_profile.h"
#include "tools/plant/world_error.h"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  try {
    sanso::plant::parse_profile(text, "fuzz.toml");
  } catch (const sanso::plant::WorldError&) {
  }
  try {
    sanso::grounds::parse_ground(text, "fuzz.toml");
  } catch (const sanso::files::InputError&) {
  }
  return 0;
}
