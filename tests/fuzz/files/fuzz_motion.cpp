// Any bytes are either a motion or a MotionError.
#include "host/motion/motion.h"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  try {
    sanso::motion::parse_motion({reinterpret_cast<const char*>(data), size}, "fuzz.toml");
  } catch (const sanso::motion::MotionError&) {
  }
  return 0;
}
