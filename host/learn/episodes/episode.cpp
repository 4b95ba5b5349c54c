// One visit function for writing and reading; counts are bounded before memory is taken for
// them.
#include "host/learn/episodes/episode.h"

#include <fmt/format.h>

#include "host/learn/episodes/stored_knot.h"
#include "shared/files/framed.h"
#include "shared/files/hash.h"

namespace sanso::learn {
namespace {

constexpr char kEpisodeMagic[] = "SANSOEPI";
constexpr std::uint32_t kEpisodeVersion = 3;

/// One list of the fields for both directions: `io` is called with every field in the stored order.
void visit_fields(auto& o, auto&& io) {
  io(o.tick), io(o.time), io(o.trial_tick), io(o.trial_id), io(o.state), io(o.fault), io(o.limits),
      io(o.contact);
  io(o.pose_age_ticks), io(o.x), io(o.current_raw), io(o.imu_acc), io(o.imu_gyro), io(o.voltage_V);
  io(o.max_temperature_C), io(o.upper_sequence), io(o.upper_age_ticks), io(o.upper_weight),
      io(o.u_upper);
  io(o.u_middle), io(o.u_lower), io(o.u_out), io(o.bus_lost), io(o.bus_corrupt),
      io(o.datagrams_dropped);
}

/// What depends on the machine's speed: stored, but no part of the digest.
void visit_timing(auto& o, auto&& io) { io(o.tick_cpu_ns), io(o.late_ticks); }

void visit_header(auto& e, auto&& io) {
  io(e.trial), io(e.seed), io(e.end), io(e.fault), io(e.cost);
}

void visit_plan(auto& p, auto&& io) {
  io(p.observed_tick), io(p.cost_before), io(p.cost_after), io(p.gain_norm), io(p.late);
  io(p.policy.sequence), io(p.policy.trial_id), io(p.policy.first_tick),
      io(p.policy.ticks_per_knot);
}

template <class Visit>
void put_all(files::FramedWriter& out, const auto& items, Visit visit) {
  out.put(static_cast<std::uint32_t>(items.size()));
  for (const auto& item : items) visit(item);
}

/// The stored count, refused when so many items of at least one byte cannot follow.
std::uint32_t read_count(files::FramedReader& in) {
  const auto n = in.read<std::uint32_t>();
  if (n > in.left()) in.fail();
  return n;
}

void put_observation(files::FramedWriter& out, const wire::Observation& o) {
  visit_fields(o, [&](const auto& v) { out.put(v); });
}

void put_plan(files::FramedWriter& out, const PlanRecord& plan) {
  const auto put = [&](const auto& v) { out.put(v); };
  visit_plan(plan, put);
  put_all(out, plan.policy.knots, [&](const policy::Knot& k) { visit_knot(k, put); });
}

PlanRecord get_plan(files::FramedReader& in) {
  PlanRecord plan;
  const auto get = [&](auto& v) { in.get(v); };
  visit_plan(plan, get);
  if (!plan.policy.knots.try_resize(read_count(in))) in.fail();
  for (policy::Knot& k : plan.policy.knots) visit_knot(k, get);
  return plan;
}

}  // namespace

const char* to_string(TrialEnd end) {
  switch (end) {
    case TrialEnd::completed:
      return "completed";
    case TrialEnd::cost_limit:
      return "cost above the limit";
    case TrialEnd::tilt:
      return "leaned too far";
    case TrialEnd::low_base:
      return "base too low";
    case TrialEnd::fault:
      return "controller fault";
    case TrialEnd::link_lost:
      return "no observations";
    case TrialEnd::ended_early:
      return "ended early by the controller";
    case TrialEnd::fell_before:
      return "fell before the trial";
  }
  return "unknown";
}

const policy::UpperPolicy* executed_policy(const Episode& episode,
                                           const wire::Observation& observation) {
  if (observation.upper_sequence == 0 || observation.upper_weight <= 0.0f) return nullptr;
  for (auto plan = episode.plans.rbegin(); plan != episode.plans.rend(); ++plan)
    if (plan->policy.sequence == observation.upper_sequence) return &plan->policy;
  return nullptr;
}

std::uint64_t digest(const Episode& episode) {
  files::FramedWriter out;
  const auto put = [&](const auto& v) { out.put(v); };
  visit_header(episode, put);
  put_all(out, episode.cost_terms, put);
  put_all(out, episode.ticks, [&](const wire::Observation& o) { put_observation(out, o); });
  put_all(out, episode.plans, [&](const PlanRecord& p) { put_plan(out, p); });
  return files::fnv1a(out.bytes());
}

std::filesystem::path trial_file(const std::filesystem::path& session, std::uint32_t trial) {
  return session / fmt::format("trial_{:04d}.episode", trial);
}

void save_episode(const std::filesystem::path& path, const Episode& episode) {
  files::FramedWriter out;
  const auto put = [&](const auto& v) { out.put(v); };
  visit_header(episode, put);
  put_all(out, episode.cost_terms, put);
  put_all(out, episode.ticks, [&](const wire::Observation& o) {
    put_observation(out, o);
    visit_timing(o, put);
  });
  put_all(out, episode.plans, [&](const PlanRecord& p) {
    put_plan(out, p);
    out.put(p.update_ms);
  });
  put_all(out, episode.truth,
          [&](const TrueSample& s) { put(s.x), put(s.foot_load_N), put(s.foot_clearance_m); });
  put_all(out, episode.reference, put);
  put_all(out, episode.before, [&](const wire::Observation& o) {
    put_observation(out, o);
    visit_timing(o, put);
  });
  out.put(static_cast<std::uint8_t>(episode.quiet_at_start));
  files::save_framed(path, kEpisodeMagic, kEpisodeVersion, out.bytes());
}

Episode load_episode(const std::filesystem::path& path) {
  files::FramedReader in = files::load_framed(path, kEpisodeMagic, kEpisodeVersion);
  const auto get = [&](auto& v) { in.get(v); };
  Episode episode;
  visit_header(episode, get);
  episode.cost_terms.resize(read_count(in));
  for (double& v : episode.cost_terms) get(v);
  episode.ticks.resize(read_count(in));
  for (wire::Observation& o : episode.ticks) {
    visit_fields(o, get);
    visit_timing(o, get);
  }
  for (std::uint32_t n = read_count(in); n > 0; --n) {
    episode.plans.push_back(get_plan(in));
    in.get(episode.plans.back().update_ms);
  }
  episode.truth.resize(read_count(in));
  for (TrueSample& s : episode.truth) get(s.x), get(s.foot_load_N), get(s.foot_clearance_m);
  episode.reference.resize(read_count(in));
  for (auto& v : episode.reference) get(v);
  episode.before.resize(read_count(in));
  for (wire::Observation& o : episode.before) {
    visit_fields(o, get);
    visit_timing(o, get);
  }
  episode.quiet_at_start = in.read<std::uint8_t>() != 0;
  return episode;
}

}  // namespace sanso::learn
