// A report descriptor from a device nobody knows, and reports that need not fit it.
#include <algorithm>
#include <array>

#include "firmware/imu/hid_descriptor.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace sanso::firmware;
  HidLayout layout;
  (void)parse_hid_descriptor({bytes, size}, layout);
  std::array<std::uint8_t, 64> report{};
  std::copy_n(bytes, std::min<std::size_t>(size, report.size()), report.begin());
  double value = 0;
  for (const HidField& field : layout.fields)
    for (int e = 0; e < field.count; ++e) (void)read_hid_field(field, e, report, value);
  for (const HidFeature& feature : layout.features) (void)make_feature_report(feature, 5, report);
  return 0;
}
