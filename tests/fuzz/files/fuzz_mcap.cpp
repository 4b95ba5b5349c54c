// Any bytes are either an MCAP recording or an InputError.
#include <unistd.h>

#include <fstream>

#include "shared/files/input_error.h"
#include "tools/recording/mcap_recording.h"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  using namespace sanso::recording;
  static const std::string path = "/tmp/sanso_fuzz_" + std::to_string(::getpid()) + ".mcap";
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  try {
    read_mcap(path, 100'000);
  } catch (const sanso::files::InputError&) {
  }
  return 0;
}
