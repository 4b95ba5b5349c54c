// Writes and reads the layers as floats in a fixed order; a reader refuses sizes and numbers
// that no writer makes.
#include "shared/policy/policy_bytes.h"

#include <cmath>

#include "shared/base/byte_io.h"

namespace sanso::policy {
namespace {

// One float; a value beyond the range of a float saturates instead of becoming infinite.
double rounded(double v) {
  constexpr double kLargest = 3.0e38;
  if (!(v < kLargest)) v = kLargest;
  if (!(v > -kLargest)) v = -kLargest;
  return static_cast<double>(static_cast<float>(v));
}

template <class Matrix>
void round_all(Matrix& m) {
  for (int i = 0; i < m.size(); ++i) m.data()[i] = rounded(m.data()[i]);
}

template <class Matrix>
void write_all(ByteWriter& ar, const Matrix& m) {
  for (int i = 0; i < m.size(); ++i) ar(static_cast<float>(rounded(m.data()[i])));
}

template <class Matrix>
void read_all(ByteReader& ar, Matrix& m) {
  for (int i = 0; i < m.size(); ++i) {
    float v = 0;
    ar(v);
    m.data()[i] = static_cast<double>(v);
  }
}

// u, x, then K column by column (Eigen's memory order).
void write_knot(ByteWriter& ar, const Knot& knot) {
  write_all(ar, knot.u);
  write_all(ar, knot.x);
  write_all(ar, knot.K);
}

void read_knot(ByteReader& ar, Knot& knot) {
  read_all(ar, knot.u);
  read_all(ar, knot.x);
  read_all(ar, knot.K);
  ar.require(std::abs(knot.x.segment<4>(model::kXQuat).norm() - 1.0) < 1e-3);
}

template <class Knots>
void read_knots(ByteReader& ar, std::uint32_t count, Knots& knots) {
  knots.clear();
  ar.require(count >= 1 && ar.left() == count * kKnotBytes && knots.try_resize(count));
  for (std::uint32_t i = 0; i < count && ar.ok(); ++i) read_knot(ar, knots[i]);
  if (!ar.finished()) knots.clear();
}

}  // namespace

void round_to_wire(Knot& knot) {
  round_all(knot.u);
  round_all(knot.x);
  round_all(knot.K);
}

void round_to_wire(UpperPolicy& policy) {
  for (Knot& knot : policy.knots) round_to_wire(knot);
}

void round_to_wire(MiddleTable& table) {
  for (Knot& knot : table.knots) round_to_wire(knot);
}

Result<std::size_t> to_bytes(const UpperPolicy& policy, std::span<std::uint8_t> buffer) {
  ByteWriter ar(buffer);
  ar(policy.sequence);
  ar(policy.trial_id);
  ar(policy.first_tick);
  ar(policy.ticks_per_knot);
  ar(static_cast<std::uint32_t>(policy.knots.size()));
  for (const Knot& knot : policy.knots) write_knot(ar, knot);
  if (!ar.ok()) return Status::full;
  return ar.size();
}

Result<std::size_t> to_bytes(const MiddleTable& table, std::span<std::uint8_t> buffer) {
  ByteWriter ar(buffer);
  ar(table.trial_id);
  ar(static_cast<std::uint32_t>(table.knots.size()));
  for (const Knot& knot : table.knots) write_knot(ar, knot);
  if (!ar.ok()) return Status::full;
  return ar.size();
}

Status from_bytes(std::span<const std::uint8_t> data, UpperPolicy& out) {
  ByteReader ar(data);
  std::uint32_t count = 0;
  ar(out.sequence);
  ar(out.trial_id);
  ar(out.first_tick);
  ar(out.ticks_per_knot);
  ar(count);
  ar.require(out.ticks_per_knot >= 1 && out.ticks_per_knot <= 1000);
  read_knots(ar, count, out.knots);
  return ar.finished() ? Status::ok : Status::malformed;
}

Status from_bytes(std::span<const std::uint8_t> data, MiddleTable& out) {
  ByteReader ar(data);
  std::uint32_t count = 0;
  ar(out.trial_id);
  ar(count);
  read_knots(ar, count, out.knots);
  return ar.finished() ? Status::ok : Status::malformed;
}

}  // namespace sanso::policy
