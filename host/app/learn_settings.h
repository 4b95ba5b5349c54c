// Every setting of the planner and of a session under one name a setting, "mpc.horizon": what
// `sanso learn --set` takes, what a profile is made of, and docs/settings-learn.md.
#pragma once

#include <string>
#include <vector>

#include "host/learn/session/session.h"
#include "host/mpc/mpc_settings.h"

namespace sanso::app {

struct LearnSettings {
  mpc::MpcSettings mpc;
  learn::SessionSettings session;

  /// section(name, struct with a visit of its own)
  void visit(auto&& section) {
    section("mpc", mpc);
    section("session", session);
    section("trial", session.trial);
    section("bring_up", session.bring_up);
    section("middle", session.middle);
    section("goals", session.goals);
    section("model", session.model);
    section("identify", session.model.identify);
    section("residual", session.model.residual);
  }
};

/// A set of settings with a name, each with what the paper says of it, or why.
struct ProfileEntry {
  const char* setting;  // "key=value"
  const char* reason;
};
struct Profile {
  const char* name;
  const char* meaning;
  std::vector<ProfileEntry> entries;
};
const std::vector<Profile>& profiles();

/// Throws std::runtime_error that names the value, what was expected, and the nearest name.
void apply_setting(const std::string& assignment, LearnSettings& settings);
void apply_profile(const std::string& name, LearnSettings& settings);

/// "key=value ..." of what differs from `defaults`, in the order of the list. Threads change no
/// number and are left out.
std::string changed_settings(LearnSettings defaults, LearnSettings settings);

/// The text of docs/settings-learn.md.
std::string learn_settings_page();

}  // namespace sanso::app
