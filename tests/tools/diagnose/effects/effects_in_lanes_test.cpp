// Effects in lanes: what a window becomes and what a joint remembers is what it would be alone.
#include <gtest/gtest.h>

#include "tests/tools/diagnose/effects/small_trials.h"
#include "tools/diagnose/sim/follow.h"
#include "tools/diagnose/sim/lane_simulation.h"
#include "tools/diagnose/sim/memory.h"

namespace sanso::diagnose {
namespace {

using namespace test;

bool alike(const InnerState& a, const InnerState& b) {
  // a profile that is not set is set anew before it is used
  const bool profile =
      !a.profile_set || (a.profile == b.profile && a.profile_speed == b.profile_speed);
  return profile && a.profile_set == b.profile_set && a.motor_offset == b.motor_offset &&
         a.motor_speed_offset == b.motor_speed_offset && a.bristle == b.bristle &&
         std::equal(a.slip, std::end(a.slip), b.slip) && a.integral == b.integral &&
         a.filtered == b.filtered && a.rest_time == b.rest_time && a.heat == b.heat &&
         a.velocity_channel == b.velocity_channel;
}
bool remembers_alike(const std::vector<std::vector<InnerStates>>& a,
                     const std::vector<std::vector<InnerStates>>& b, std::size_t joints) {
  for (std::size_t r = 0; r < a.size(); ++r) {
    if (a[r].size() != b[r].size()) return false;
    for (std::size_t w = 0; w < a[r].size(); ++w) {
      if (!std::equal(a[r][w].begin(), a[r][w].begin() + static_cast<std::ptrdiff_t>(joints),
                      b[r][w].begin(), alike))
        return false;
    }
  }
  return true;
}

class EveryEffectInLanes : public testing::TestWithParam<std::string> {
 protected:
  const Effect& effect_ = *find_effect(GetParam());
};

/// Windows that begin and end apart, on an unsteady clock, with commands that pause: each is what
/// it is alone, on every instruction set.
TEST_P(EveryEffectInLanes, MovesEveryWindowAsItMovesAlone) {
  for (Trial trial : trials()) {
    for (std::size_t row = 1; row + 1 < trial.drive.rows(); ++row)
      trial.drive.t[row] += 0.002 * std::sin(3.0 * static_cast<double>(row * row));
    for (JointData& joint : trial.drive.joints)
      std::fill_n(joint.command.begin() + 30, 8, std::nan(""));
    trial.windows.push_back(trial.windows.front());
    for (const std::size_t first : {3u, 17u, 31u, 33u, 34u, 50u, 70u, 71u})
      trial.windows.push_back({first, first + 9, trial.windows[0].q, trial.windows[0].dq});
    std::stable_sort(trial.windows.begin(), trial.windows.end(),
                     [](const Window& a, const Window& b) { return a.first < b.first; });
    for (const Values& theta : scaled_probes(effect_, trial.scale)) {
      SimParams params = trial.with(effect_, theta);
      params.joints.back().nominal.command_delay_s += 0.0031;  // one joint's commands alone
      SimOptions options;
      options.motion = &trial.motion;
      options.unit = &lane_units().back();
      const auto alone = simulate(params, trial.drive, trial.windows, options);
      for (const LaneUnit& unit : lane_units()) {
        options.unit = unit.runs_here() ? &unit : nullptr;
        EXPECT_TRUE(identical(alone, simulate(params, trial.drive, trial.windows, options)))
            << trial.name << ' ' << unit.name;
      }
    }
  }
}

/// Recordings of several lengths and clocks, with commands that pause: what a joint remembers at
/// any row is what it would be if its recording were followed alone, on every instruction set.
TEST_P(EveryEffectInLanes, RemembersInStepWhatItRemembersAlone) {
  for (const Trial& trial : trials()) {
    std::vector<Trial> recordings(5, trial);
    for (std::size_t r = 0; r < recordings.size(); ++r) {
      Trial& own = recordings[r];
      const double k = static_cast<double>(r);
      for (std::size_t row = 0; row < own.drive.rows(); ++row) {
        own.drive.t[row] = 0.3 * k + (1.0 + 0.4 * k) * own.drive.t[row] +
                           0.002 * std::sin((3.0 + k) * static_cast<double>(row * row));
      }
      for (JointData& joint : own.drive.joints)
        std::fill_n(joint.command.begin() + 30 + 5 * static_cast<int>(r), 8, std::nan(""));
      own.windows.resize(1);
      own.windows.front().first = 0;
      for (const std::size_t first : {0u, 7u, 33u, 34u, 45u, 60u}) {
        if (first + 8 * r < 90) own.windows.push_back({first + 8 * r, 99, {}, {}});
      }
    }
    for (const Values& theta : scaled_probes(effect_, trial.scale)) {
      std::vector<SimParams> params(recordings.size(), trial.with(effect_, theta));
      std::vector<Followed> all;
      for (std::size_t r = 0; r < recordings.size(); ++r) {
        for (JointParams& joint : params[r].joints) {  // gains are registers, others every time
          joint.nominal.p_gain *= 1.0 + 0.2 * static_cast<double>(r);
          joint.nominal.kp *= 1.0 + 0.2 * static_cast<double>(r);
        }
        BodyInertia& tip = params[r].tree.joints.back().body;
        tip.mass *= 1.0 + 0.1 * static_cast<double>(r);
        const double from_s = r % 2 == 0 ? -kNone : recordings[r].drive.t[25 + 7 * r];
        if (r > 1) params[r].late_payloads.push_back({0, tip, from_s});
        const Trial& own = recordings[r];
        all.push_back({&params[r], &own.drive, &own.motion, own.windows});
      }
      for (const double recalled_s : {kNone, 0.08}) {
        for (Followed& r : all) r.recalled_s = recalled_s;
        SimOptions options;
        options.unit = &lane_units().back();
        std::vector<std::vector<InnerStates>> alone;
        alone.reserve(all.size());
        for (const Followed& r : all) alone.push_back(follow({&r, 1}, options).front());
        for (const LaneUnit& unit : lane_units()) {
          options.unit = unit.runs_here() ? &unit : nullptr;
          EXPECT_TRUE(remembers_alike(alone, follow(all, options), trial.drive.joints.size()))
              << trial.name << ' ' << unit.name << ' ' << recalled_s;
        }
      }
    }
  }
}

/// Another effect beside this one either changes nothing that is remembered, bit for bit, or is not
/// said to remember alike.
TEST_P(EveryEffectInLanes, RemembersAlikeBesideWhatHasNoPartInIt) {
  for (const Trial& trial : trials()) {
    const SimParams own = trial.with(effect_, scaled_probes(effect_, trial.scale).front());
    const auto remembered = [&](const SimParams& params) {
      return follow({{{&params, &trial.drive, &trial.motion, trial.windows}}}, {});
    };
    const std::vector<std::vector<InnerStates>> alone = remembered(own);
    for (const Effect& other : library()) {
      if (!other.apply) continue;
      for (const Values& theta : scaled_probes(other, trial.scale)) {
        SimParams both = own;
        if (other.scope == Scope::robot) other.apply(both, -1, theta);
        for (std::size_t j = 0; other.scope != Scope::robot && j < both.size(); ++j)
          other.apply(both, static_cast<int>(j), theta);
        if (!remember_alike(own, both)) continue;
        EXPECT_TRUE(remembers_alike(alone, remembered(both), trial.drive.joints.size()))
            << trial.name << ' ' << other.id;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Library, EveryEffectInLanes, testing::ValuesIn(simulated_ids()),
                         [](const auto& p) { return p.param; });

}  // namespace
}  // namespace sanso::diagnose
