// Bytes of a primitive set: little-endian, doubles for what is few, floats for the weights (1e-7 of
// full scale: below any servo's resolution). Layout: version, form, num_basis (u16), duration,
// period, fade_start, 15 scalars, orientation.
#include <cmath>

#include "shared/base/byte_io.h"
#include "shared/policy/primitives.h"

namespace sanso::policy {
namespace {

constexpr std::uint8_t kVersion = 1;
constexpr double kMaxLength_m = 20.0;  // farther than any motion of 60 s goes
constexpr double kMaxAngle_rad = 3.2;  // a servo's range
constexpr double kMaxRate = 50.0;      // rad/s or m/s: ten times what the servo can do
constexpr double kMaxWeight = 1e9f;    // forcing of 60 s motions at the highest acceleration
constexpr double kQuatTolerance = 1e-6;

constexpr std::size_t size_for(int num_basis) {
  const auto n = static_cast<std::size_t>(num_basis);
  return 4 + 3 * 8 + kNumScalarPrimitives * (4 * 8 + n * 4) + 11 * 8 + n * 3 * 4;
}
static_assert(size_for(kMaxBasis) == kMaxPrimitiveBytes);

/// Calls `field` for every number after the head, in the order of the format. One list for writing
/// and reading.
template <class Set, class Field>
void visit_fields(Set& set, Field&& field) {
  field(set.duration_s);
  field(set.period_s);
  field(set.fade_start);
  for (auto& s : set.scalar) {
    field(s.start);
    field(s.start_rate);
    field(s.goal);
    field(s.drift);
    for (int i = 0; i < set.num_basis; ++i) field(s.weights[i]);
  }
  for (int k = 0; k < 4; ++k) field(set.orientation.start[k]);
  for (int k = 0; k < 3; ++k) field(set.orientation.start_rate[k]);
  for (int k = 0; k < 4; ++k) field(set.orientation.goal[k]);
  for (int i = 0; i < set.num_basis; ++i) {
    for (auto& w : set.orientation.weights[i]) field(w);
  }
}

/// False for NaN as well.
bool within(double value, double bound) { return std::abs(value) <= bound; }

bool is_unit(const math::Quat& q) { return within(q.squaredNorm() - 1.0, kQuatTolerance); }

bool scalar_in_range(const ScalarPrimitive& s, double bound, int num_basis, bool rhythmic) {
  if (!within(s.start, bound) || !within(s.goal, bound)) return false;
  if (!within(s.start_rate, kMaxRate) || !within(s.drift, rhythmic ? kMaxRate : 0.0)) return false;
  for (int i = 0; i < num_basis; ++i) {
    if (!within(s.weights[i], kMaxWeight)) return false;
  }
  return true;
}

bool orientation_in_range(const OrientationPrimitive& o, int num_basis) {
  if (!is_unit(o.start) || !is_unit(o.goal)) return false;
  for (int k = 0; k < 3; ++k) {
    if (!within(o.start_rate[k], kMaxRate)) return false;
  }
  for (int i = 0; i < num_basis; ++i) {
    for (const float w : o.weights[i]) {
      if (!within(w, kMaxWeight)) return false;
    }
  }
  return true;
}

}  // namespace

Status validate(const PrimitiveSet& set) {
  const bool rhythmic = set.form == PrimitiveForm::rhythmic;
  if (!rhythmic && set.form != PrimitiveForm::discrete) return Status::out_of_range;
  if (set.num_basis < 2 || set.num_basis > kMaxBasis) return Status::out_of_range;
  if (!(set.duration_s >= 0.1 && set.duration_s <= kMaxPrimitiveDuration_s))
    return Status::out_of_range;
  if (!(set.period_s >= 0.1 && set.period_s <= kMaxPrimitiveDuration_s))
    return Status::out_of_range;
  if (!(set.fade_start >= 0.0 && set.fade_start < 1.0)) return Status::out_of_range;
  for (int i = 0; i < kNumScalarPrimitives; ++i) {
    const double bound = i < 3 ? kMaxLength_m : kMaxAngle_rad;
    if (!scalar_in_range(set.scalar[i], bound, set.num_basis, rhythmic))
      return Status::out_of_range;
  }
  return orientation_in_range(set.orientation, set.num_basis) ? Status::ok : Status::out_of_range;
}

std::size_t encoded_size(const PrimitiveSet& set) { return size_for(set.num_basis); }

std::size_t to_bytes(const PrimitiveSet& set, std::span<std::uint8_t> out) {
  if (set.num_basis < 2 || set.num_basis > kMaxBasis || out.size() < encoded_size(set)) return 0;
  ByteWriter writer(out);
  writer(kVersion);
  writer(set.form);
  writer(static_cast<std::uint16_t>(set.num_basis));
  visit_fields(set, [&](const auto& value) { writer(value); });
  return writer.size();
}

Status from_bytes(std::span<const std::uint8_t> bytes, PrimitiveSet& set) {
  ByteReader reader(bytes);
  std::uint8_t version = 0;
  std::uint16_t num_basis = 0;
  reader(version);
  reader(set.form);
  reader(num_basis);
  if (!reader.ok()) return Status::malformed;
  if (version != kVersion) return Status::unsupported;
  if (num_basis < 2 || num_basis > kMaxBasis || bytes.size() != size_for(num_basis))
    return Status::malformed;
  set.num_basis = num_basis;
  visit_fields(set, [&](auto& value) { reader(value); });
  if (!reader.finished()) return Status::out_of_range;  // a number that is not finite
  return validate(set);
}

}  // namespace sanso::policy
