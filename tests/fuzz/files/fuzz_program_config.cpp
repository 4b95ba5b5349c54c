// Any bytes are either the onboard controller's settings or an error that says why not.
#include "firmware/config/program_config.h"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  sanso::firmware::ProgramConfig config;
  std::string error;
  const bool ok = sanso::firmware::parse_program_config({reinterpret_cast<const char*>(data), size},
                                                        "fuzz.toml", config, error);
  if (ok == !error.empty()) __builtin_trap();
  return 0;
}
