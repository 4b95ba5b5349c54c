// Walks the same items as the layout does and writes each down, by name where the usage is known.
#include "firmware/imu/hid_description.h"

#include <cstdio>

#include "firmware/imu/hid_descriptor.h"
#include "firmware/imu/hid_items.h"

namespace sanso::firmware {
namespace {

struct Named {
  std::uint32_t usage;
  const char* name;
};

constexpr Named kNames[] = {{0x00010002, "mouse"},
                            {0x00010004, "joystick"},
                            {0x00010005, "gamepad"},
                            {0x00010006, "keyboard"},
                            {0x000C0001, "consumer control"},
                            {0x00200001, "sensor collection"},
                            {0x00200073, "accelerometer"},
                            {0x00200076, "gyrometer"},
                            {0x00200201, "state"},
                            {0x00200202, "event"},
                            {0x0020030E, "report interval"},
                            {0x00200316, "reporting state"},
                            {0x00200319, "power state"},
                            {0x00200453, "acceleration x"},
                            {0x00200454, "acceleration y"},
                            {0x00200455, "acceleration z"},
                            {0x00200457, "angular velocity x"},
                            {0x00200458, "angular velocity y"},
                            {0x00200459, "angular velocity z"},
                            {0x00200483, "orientation quaternion"}};

std::string name_of_usage(std::uint32_t usage) {
  for (const Named& n : kNames)
    if (n.usage == usage) return n.name;
  char text[24];
  std::snprintf(text, sizeof text, "usage %04X:%04X", usage >> 16, usage & 0xFFFF);
  return text;
}

class TextSink final : public HidItemSink {
 public:
  Status take(const HidItem& item) override {
    if (application.empty()) application = name_of_usage(item.application);
    if (item.constant) return Status::ok;
    char head[64];
    std::snprintf(head, sizeof head, "  %s report %d, bit %u: ", item.feature ? "feature" : "input",
                  item.report_id, item.first_bit);
    text += head;
    if (item.property != 0) {
      text += name_of_usage(item.property);
    } else {
      for (std::size_t i = 0; i < item.usages.size(); ++i) {
        const HidUsages& range = item.usages[i];
        text += (i > 0 ? ", " : "") + name_of_usage(range.first);
        if (range.last != range.first) text += " to " + name_of_usage(range.last);
      }
    }
    std::snprintf(head, sizeof head, " (%u x %u bit)\n", item.count, item.bits);
    text += head;
    return Status::ok;
  }
  std::string text, application;
};

}  // namespace

std::string describe_hid(std::span<const std::uint8_t> descriptor) {
  TextSink sink;
  HidReportSizes sizes;
  const Status status = read_hid_items(descriptor, sink, sizes);
  std::string text = sink.text;
  if (status != Status::ok)
    text += std::string("  and then the descriptor is ") + to_string(status) + "\n";
  return text;
}

std::string why_no_imu(std::span<const std::uint8_t> descriptor, board::HidIdentity identity) {
  HidLayout layout;
  const Status status = parse_hid_descriptor(descriptor, layout, identity);
  if (descriptor.empty() || status == Status::ok) return {};
  TextSink sink;
  HidReportSizes sizes;
  (void)read_hid_items(descriptor, sink, sizes);
  std::string text = "is no IMU";
  if (!sink.application.empty()) text += " but a " + sink.application;
  if (status == Status::unsupported) {
    text += ": missing";
    if (!layout.has(HidQuantity::acceleration)) text += " acceleration x y z";
    if (!layout.has(HidQuantity::angular_velocity)) text += " angular velocity x y z";
  } else {
    text += std::string(": its report descriptor is ") + to_string(status);
  }
  return text + "; what it has:\n" + describe_hid(descriptor) +
         "  name another device in device.imu; sanso-firmware --devices lists them";
}

}  // namespace sanso::firmware
