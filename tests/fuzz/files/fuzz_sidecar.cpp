// Any bytes are either a sidecar or an InputError.
#include "shared/files/input_error.h"
#include "tools/recording/sidecar.h"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  using namespace sanso::recording;
  Recording recording;
  try {
    parse_sidecar({reinterpret_cast<const char*>(data), size}, "fuzz.toml", recording);
  } catch (const sanso::files::InputError&) {
  }
  return 0;
}
