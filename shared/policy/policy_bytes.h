// The byte form of an upper policy and of a middle-layer table, as uploaded to the controller.
// Numbers travel as 32-bit floats: half the datagrams, and 1e-7 relative is far below an encoder
// count. Whoever predicts with a policy that a controller executes must use the rounded values:
// call round_to_wire() before both.
#pragma once

#include <span>

#include "shared/base/status.h"
#include "shared/policy/policy_types.h"

namespace sanso::policy {

inline constexpr std::size_t kKnotBytes = 4 * (model::kNu + model::kNx + model::kNu * model::kNdx);
inline constexpr std::size_t kUpperHeaderBytes = 20, kMiddleHeaderBytes = 8;
inline constexpr std::size_t kMaxUpperBytes = kUpperHeaderBytes + kMaxUpperKnots * kKnotBytes;
inline constexpr std::size_t kMaxMiddleBytes = kMiddleHeaderBytes + kMaxMiddleKnots * kKnotBytes;

/// Replaces every number by what the controller will read. Idempotent.
void round_to_wire(Knot& knot);
void round_to_wire(UpperPolicy& policy);
void round_to_wire(MiddleTable& table);

/// Bytes written, or `full`.
Result<std::size_t> to_bytes(const UpperPolicy& policy, std::span<std::uint8_t> buffer);
Result<std::size_t> to_bytes(const MiddleTable& table, std::span<std::uint8_t> buffer);

/// ok, or malformed: wrong length, a number that is not finite, a quaternion that is none, no
/// knots, a spacing below one tick. `out` is written in place (it may be large) and is cleared of
/// knots when the bytes are malformed.
Status from_bytes(std::span<const std::uint8_t> data, UpperPolicy& out);
Status from_bytes(std::span<const std::uint8_t> data, MiddleTable& out);

}  // namespace sanso::policy
