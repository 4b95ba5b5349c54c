// Any bytes are either a recording or an InputError; what is accepted reads back unchanged.
#include <cstdlib>

#include "shared/files/input_error.h"
#include "tools/recording/csv_reader.h"
#include "tools/recording/csv_writer.h"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  using namespace sanso::recording;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    const Recording first = parse_csv(text, "fuzz.csv");
    const std::string written = to_csv(first);
    if (to_csv(parse_csv(written, "again.csv")) != written) std::abort();
  } catch (const sanso::files::InputError&) {
  }
  return 0;
}
