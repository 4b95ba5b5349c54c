// Address ranges, access and limits as one table; reads and writes of indirect addresses are
// forwarded.
#include "tools/emulator/register_file.h"

#include <algorithm>

namespace sanso::emulator {
namespace {

namespace xm = servo_bus::xm430;
using servo_bus::Access;
using servo_bus::Register;
using servo_bus::StatusError;

/// Index of the indirect entry whose data byte lies at `address` (0..55), -1 when it is no indirect
/// data.
int indirect_entry(std::uint16_t address) {
  if (address >= xm::kIndirectData1 && address < xm::kIndirectData1 + xm::kIndirectPerBlock) {
    return address - xm::kIndirectData1;
  }
  if (address >= xm::kIndirectData29 && address < xm::kIndirectData29 + xm::kIndirectPerBlock) {
    return xm::kIndirectPerBlock + address - xm::kIndirectData29;
  }
  return -1;
}

std::uint16_t indirect_address_of(int entry) {
  return static_cast<std::uint16_t>(
      entry < xm::kIndirectPerBlock ? xm::kIndirectAddress1 + 2 * entry
                                    : xm::kIndirectAddress29 + 2 * (entry - xm::kIndirectPerBlock));
}

std::uint16_t indirect_data_of(int entry) {
  return static_cast<std::uint16_t>(entry < xm::kIndirectPerBlock
                                        ? xm::kIndirectData1 + entry
                                        : xm::kIndirectData29 + entry - xm::kIndirectPerBlock);
}

bool is_indirect_address(std::uint16_t address) {
  return (address >= xm::kIndirectAddress1 && address < xm::kIndirectData1) ||
         (address >= xm::kIndirectAddress29 && address < xm::kIndirectData29);
}

const Register* register_holding(std::uint16_t address) {
  for (const Register& r : xm::kRegisters) {
    if (address >= r.address && address < r.address + r.size) return &r;
  }
  return nullptr;
}

std::int64_t value_of(std::span<const std::uint8_t> bytes, bool is_signed) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i)
    value |= static_cast<std::uint64_t>(bytes[i]) << (8 * i);
  const unsigned bits = 8 * static_cast<unsigned>(bytes.size());
  if (is_signed && (value >> (bits - 1)) & 1) value |= ~std::uint64_t{0} << bits;
  return static_cast<std::int64_t>(value);
}

}  // namespace

void RegisterFile::load_defaults(bool eeprom) {
  for (const Register& r : xm::kRegisters) {
    if (eeprom || r.address >= xm::kFirstRamAddress) set(r, r.initial_raw);
  }
  for (int entry = 0; entry < 2 * xm::kIndirectPerBlock; ++entry) {
    servo_bus::put_le(&bytes_[indirect_address_of(entry)], 2, indirect_data_of(entry));
    bytes_[indirect_data_of(entry)] = 0;
  }
}

std::int64_t RegisterFile::get(const Register& r) const {
  return value_of({&bytes_[r.address], r.size}, r.is_signed);
}

void RegisterFile::set(const Register& r, std::int64_t value_raw) {
  servo_bus::put_le(&bytes_[r.address], r.size, value_raw);
}

/// Where a byte really lives: indirect data points elsewhere (by default at itself).
std::uint16_t RegisterFile::resolve(std::uint16_t address) const {
  const int entry = indirect_entry(address);
  return entry < 0 ? address : servo_bus::get_u16({&bytes_[indirect_address_of(entry)], 2});
}

StatusError RegisterFile::read(std::uint16_t address, std::span<std::uint8_t> out) const {
  if (out.empty() || address + out.size() > bytes_.size()) return StatusError::data_range;
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = bytes_[resolve(static_cast<std::uint16_t>(address + i))];
  return StatusError::none;
}

StatusError RegisterFile::write(std::uint16_t address, std::span<const std::uint8_t> data,
                                Touched& touched) {
  touched.clear();
  if (data.empty()) return StatusError::data_length;
  if (address + data.size() > bytes_.size()) return StatusError::data_range;
  const bool torque_on = get(xm::kTorqueEnable) != 0;

  auto shadow = bytes_;
  for (std::size_t i = 0; i < data.size(); ++i) {
    const std::uint16_t target = resolve(static_cast<std::uint16_t>(address + i));
    shadow[target] = data[i];
    if (is_indirect_address(target) || indirect_entry(target) >= 0) continue;
    const Register* r = register_holding(target);
    if (!r || r->access == Access::read) return StatusError::access;
    if (r->address < xm::kFirstRamAddress && torque_on) return StatusError::access;
    if (std::find(touched.begin(), touched.end(), r) == touched.end() && !touched.try_push(r)) {
      return StatusError::data_length;
    }
  }

  // every touched register must hold an allowed value as a whole
  for (const Register* r : touched) {
    const std::int64_t value = value_of({&shadow[r->address], r->size}, r->is_signed);
    if (value < r->min_raw || value > r->max_raw) return StatusError::data_range;
  }
  for (int entry = 0; entry < 2 * xm::kIndirectPerBlock; ++entry) {
    const std::uint16_t pointed = servo_bus::get_u16({&shadow[indirect_address_of(entry)], 2});
    if (pointed < xm::kFirstRamAddress || pointed >= xm::kTableBytes)
      return StatusError::data_range;
  }
  bytes_ = shadow;
  return StatusError::none;
}

}  // namespace sanso::emulator
