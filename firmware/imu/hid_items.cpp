// One pass over the items with the standard's state: global items with their stack, local items
// until the next main item, and a bit counter for each report.
#include "firmware/imu/hid_items.h"

#include <algorithm>

namespace sanso::firmware {
namespace {

constexpr std::uint32_t kLogicalCollection = 2;
constexpr std::uint32_t kMaxReportBits = 4096;

struct Globals {
  std::uint32_t usage_page = 0;
  std::int32_t logical_minimum = 0;
  std::uint32_t unit = 0, unit_exponent = 0;
  std::uint32_t report_size = 0, report_count = 0;
  std::uint8_t report_id = 0;
};

std::int32_t sign_extended(std::uint32_t value, std::size_t size) {
  if (size == 1) return static_cast<std::int8_t>(value);
  if (size == 2) return static_cast<std::int16_t>(value);
  return static_cast<std::int32_t>(value);
}

class ItemReader {
 public:
  ItemReader(std::span<const std::uint8_t> bytes, HidItemSink& sink, HidReportSizes& sizes)
      : bytes_(bytes), sink_(sink), sizes_(sizes) {}

  Status run() {
    while (at_ < bytes_.size())
      if (const Status status = item(); status != Status::ok) return status;
    return depth_ == 0 ? Status::ok : Status::malformed;
  }

 private:
  Status item() {
    const std::uint8_t prefix = bytes_[at_++];
    if (prefix == 0xFE) return skip_long_item();
    const std::size_t size = (prefix & 3) == 3 ? 4 : (prefix & 3);
    if (bytes_.size() - at_ < size) return Status::malformed;
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < size; ++i)
      value |= static_cast<std::uint32_t>(bytes_[at_ + i]) << (8 * i);
    at_ += size;
    switch (prefix & 0x0C) {
      case 0x00:
        return main_item(prefix & 0xFC, value);
      case 0x04:
        return global_item(prefix & 0xFC, value, size);
      case 0x08:
        return local_item(prefix & 0xFC, value, size);
      default:
        return Status::ok;  // reserved
    }
  }

  Status skip_long_item() {
    if (bytes_.size() - at_ < 2 || bytes_.size() - at_ - 2 < bytes_[at_]) return Status::malformed;
    at_ += 2u + bytes_[at_];
    return Status::ok;
  }

  Status global_item(int tag, std::uint32_t value, std::size_t size) {
    switch (tag) {
      case 0x04:
        globals_.usage_page = value;
        break;
      case 0x14:
        globals_.logical_minimum = sign_extended(value, size);
        break;
      case 0x54:
        globals_.unit_exponent = value;
        break;
      case 0x64:
        globals_.unit = value;
        break;
      case 0x74:
        globals_.report_size = value;
        break;
      case 0x84:
        globals_.report_id = static_cast<std::uint8_t>(value);
        break;
      case 0x94:
        globals_.report_count = value;
        break;
      case 0xA4:
        return pushed_.try_push(globals_) ? Status::ok : Status::full;
      case 0xB4:
        if (pushed_.empty()) return Status::malformed;
        globals_ = pushed_.back();
        pushed_.pop_back();
        break;
      default:
        break;  // maxima and physical ranges do not say where data lie
    }
    return Status::ok;
  }

  Status local_item(int tag, std::uint32_t value, std::size_t size) {
    const std::uint32_t usage = size == 4 ? value : (globals_.usage_page << 16) | (value & 0xFFFF);
    switch (tag) {
      case 0x08:
        return usages_.try_push({usage, usage}) ? Status::ok : Status::full;
      case 0x18:
        range_.first = usage;
        return range_end(1);
      case 0x28:
        range_.last = usage;
        return range_end(2);
      default:
        break;
    }
    return Status::ok;
  }

  /// A range is whole when minimum and maximum have come, in either order.
  Status range_end(unsigned which) {
    range_have_ |= which;
    if (range_have_ != 3) return Status::ok;
    range_have_ = 0;
    if (range_.last < range_.first) return Status::malformed;
    return usages_.try_push(range_) ? Status::ok : Status::full;
  }

  Status main_item(int tag, std::uint32_t value) {
    Status status = Status::ok;
    if (tag == 0xA0) {
      if (depth_++ == 0 && !usages_.empty()) application_ = usages_.back().last;
      // a logical collection holds the selectors of the property named just before it
      if (value == kLogicalCollection && !usages_.empty()) property_ = usages_.back().last;
    } else if (tag == 0xC0) {
      if (depth_-- == 0) return Status::malformed;
      property_ = 0;
    } else if (tag == 0x80 || tag == 0xB0) {
      status = data(value, tag == 0xB0);
    }
    usages_.clear();
    range_have_ = 0;
    return status;
  }

  HidReportSize* size_of(std::uint8_t id, bool feature) {
    for (HidReportSize& r : sizes_)
      if (r.id == id && r.feature == feature) return &r;
    const std::uint32_t id_bits = id != 0 || feature ? 8u : 0u;
    return sizes_.try_push({id, feature, id_bits}) ? &sizes_.back() : nullptr;
  }

  Status data(std::uint32_t flags, bool feature) {
    if (globals_.report_size > 32 || globals_.report_count > 512) return Status::malformed;
    HidReportSize* report = size_of(globals_.report_id, feature);
    if (report == nullptr || report->bits > kMaxReportBits) return Status::full;
    HidItem item;
    item.feature = feature;
    item.constant = (flags & 1) != 0;
    item.report_id = globals_.report_id;
    item.first_bit = report->bits;
    item.bits = globals_.report_size;
    item.count = globals_.report_count;
    item.logical_minimum = globals_.logical_minimum;
    item.unit = globals_.unit;
    item.unit_exponent = globals_.unit_exponent;
    item.usages = {usages_.data(), usages_.size()};
    item.property = property_;
    item.application = application_;
    report->bits += item.bits * item.count;
    return sink_.take(item);
  }

  std::span<const std::uint8_t> bytes_;
  HidItemSink& sink_;
  HidReportSizes& sizes_;
  std::size_t at_ = 0;
  int depth_ = 0;
  Globals globals_;
  FixedVector<Globals, 8> pushed_;
  FixedVector<HidUsages, 64> usages_;
  HidUsages range_;
  unsigned range_have_ = 0;  // 1 minimum, 2 maximum
  std::uint32_t property_ = 0, application_ = 0;
};

}  // namespace

std::uint32_t HidItem::usage(std::uint32_t index) const {
  for (const HidUsages& range : usages) {
    const std::uint32_t here = range.last - range.first;
    if (index <= here) return range.first + index;
    index -= here + 1;
  }
  return 0;
}

Status read_hid_items(std::span<const std::uint8_t> descriptor, HidItemSink& sink,
                      HidReportSizes& sizes) {
  sizes.clear();
  return ItemReader(descriptor, sink, sizes).run();
}

}  // namespace sanso::firmware
