// One visit function for writing and reading; the frame around the bytes is that of
// shared/files/framed.h.
#include "host/learn/session/session_state.h"

#include <algorithm>
#include <cmath>

#include "host/learn/episodes/stored_knot.h"
#include "shared/files/framed.h"
#include "shared/files/hash.h"

namespace sanso::learn {
namespace {

constexpr char kSessionMagic[] = "SANSOSES";
constexpr std::uint32_t kSessionVersion = 8;

void visit_summary(auto& s, auto&& io) {
  io(s.trial), io(s.cost), io(s.end), io(s.fault), io(s.duration_s), io(s.sigma), io(s.input_share),
      io(s.lifted_share), io(s.model_loss), io(s.model_loss_analytical);
  io(s.model_loss_initial), io(s.residual_share), io(s.u_upper_rms);
  io(s.u_middle_rms), io(s.gain_upper), io(s.gain_middle), io(s.late_updates), io(s.bus_lost),
      io(s.bus_corrupt);
  io(s.quiet_at_start), io(s.cost_true), io(s.digest), io(s.wall_s);
}

std::vector<std::uint8_t> primitive_bytes(const policy::PrimitiveSet& set) {
  std::vector<std::uint8_t> bytes(policy::kMaxPrimitiveBytes);
  bytes.resize(policy::to_bytes(set, bytes));
  return bytes;
}

void put_learned(files::FramedWriter& out, const SessionState& state) {
  const std::vector<std::uint8_t> primitives = primitive_bytes(state.primitives);
  out.put(static_cast<std::uint32_t>(primitives.size()));
  for (std::uint8_t byte : primitives) out.put(byte);
  out.put(static_cast<std::uint32_t>(state.middle.knots.size()));
  for (const policy::Knot& knot : state.middle.knots)
    visit_knot(knot, [&](const auto& v) { out.put(v); });
}

void get_learned(files::FramedReader& in, SessionState& state) {
  std::vector<std::uint8_t> primitives(in.read<std::uint32_t>());
  for (std::uint8_t& byte : primitives) in.get(byte);
  if (policy::from_bytes(primitives, state.primitives) != Status::ok) in.fail();
  if (!state.middle.knots.try_resize(in.read<std::uint32_t>())) in.fail();
  for (policy::Knot& knot : state.middle.knots) visit_knot(knot, [&](auto& v) { in.get(v); });
}

}  // namespace

std::string how_it_ended(const TrialSummary& trial) {
  std::string text = to_string(trial.end);
  if (trial.fault != 0) text += " F" + std::to_string(trial.fault);
  return text;
}

TrialSummary summarize(const Episode& episode, const policy::MiddleTable& middle) {
  TrialSummary s;
  s.trial = episode.trial;
  s.cost = episode.cost;
  s.end = episode.end;
  s.fault = episode.fault;
  s.quiet_at_start = episode.quiet_at_start;
  s.digest = digest(episode);
  double upper = 0, middle_u = 0;
  for (const wire::Observation& o : episode.ticks) {
    upper += o.u_upper.squaredNorm();
    middle_u += o.u_middle.squaredNorm();
  }
  const double n =
      model::kNumJoints * static_cast<double>(std::max<std::size_t>(episode.ticks.size(), 1));
  s.u_upper_rms = std::sqrt(upper / n);
  s.u_middle_rms = std::sqrt(middle_u / n);
  for (const PlanRecord& plan : episode.plans) {
    s.gain_upper += plan.policy.knots[0].K.norm() / static_cast<double>(episode.plans.size());
    s.late_updates += plan.late;
    s.update_ms.push_back(static_cast<float>(plan.update_ms));
  }
  for (const policy::Knot& knot : middle.knots)
    s.gain_middle += knot.K.norm() / static_cast<double>(middle.knots.size());
  if (!episode.ticks.empty()) {
    s.duration_s = to_seconds(kTickPeriod) * episode.ticks.back().trial_tick;
    s.bus_lost = episode.ticks.back().bus_lost - episode.ticks.front().bus_lost;
    s.bus_corrupt = episode.ticks.back().bus_corrupt - episode.ticks.front().bus_corrupt;
  }
  return s;
}

void save_state(const std::filesystem::path& path, const SessionState& state) {
  files::FramedWriter out;
  out.put(state.identity);
  out.put(state.next_trial);
  out.put(state.sigma);
  out.put(state.input_share);
  out.put(state.model_rounds);
  out.put(state.residual.share);
  out.put(state.residual.ceiling);
  put_learned(out, state);
  out.put(static_cast<std::uint32_t>(state.robot.size()));
  for (double v : state.robot) out.put(v);
  out.put(static_cast<std::uint32_t>(state.history.size()));
  for (const TrialSummary& s : state.history) {
    visit_summary(s, [&](const auto& v) { out.put(v); });
    out.put(static_cast<std::uint32_t>(s.update_ms.size()));
    for (float v : s.update_ms) out.put(v);
    out.put(static_cast<std::uint32_t>(s.broken_clauses.size()));
    for (const std::string& clause : s.broken_clauses) out.put(clause);
  }
  files::save_framed(path, kSessionMagic, kSessionVersion, out.bytes());
}

void load_state(const std::filesystem::path& path, SessionState& state) {
  files::FramedReader in = files::load_framed(path, kSessionMagic, kSessionVersion);
  in.get(state.identity);
  in.get(state.next_trial);
  in.get(state.sigma);
  in.get(state.input_share);
  in.get(state.model_rounds);
  in.get(state.residual.share);
  in.get(state.residual.ceiling);
  get_learned(in, state);
  state.robot.resize(in.read<std::uint32_t>());
  for (double& v : state.robot) in.get(v);
  state.history.resize(in.read<std::uint32_t>());
  for (TrialSummary& s : state.history) {
    visit_summary(s, [&](auto& v) { in.get(v); });
    s.update_ms.resize(in.read<std::uint32_t>());
    for (float& v : s.update_ms) in.get(v);
    s.broken_clauses.resize(in.read<std::uint32_t>());
    for (std::string& clause : s.broken_clauses) in.get(clause);
  }
}

std::uint64_t learned_digest(const SessionState& state) {
  files::FramedWriter out;
  put_learned(out, state);
  return files::fnv1a(out.bytes());
}

}  // namespace sanso::learn
