// Any bytes are either a model.toml or an InputError; what is accepted is written and read back
// unchanged.
#include <cstdlib>

#include "shared/files/input_error.h"
#include "tools/diagnose/model_folder/model_folder.h"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  using namespace sanso;
  constexpr const char* urdf =
      "<robot name='p'><link name='base'/><joint name='a' type='continuous'><parent "
      "link='base'/><child link='arm'/>"
      "</joint><link name='arm'/></robot>";
  try {
    const auto model =
        diagnose::parse_model({reinterpret_cast<const char*>(data), size}, urdf, "fuzz.toml");
    const std::string written = diagnose::model_toml(model);
    if (diagnose::model_toml(diagnose::parse_model(written, urdf, "again.toml")) != written)
      std::abort();
  } catch (const sanso::files::InputError&) {
  }
  return 0;
}
