// Walks the settings' visit(): one assignment, one comparison or one line of the page a setting.
#include "host/app/learn_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <numeric>
#include <stdexcept>
#include <type_traits>

namespace sanso::app {
namespace {

/// Calls see(full name, value, unit, low, high, reason) for every setting.
void for_each_setting(LearnSettings& settings, auto&& see) {
  settings.visit([&](const char* section, auto& group) {
    group.visit([&](const char* key, auto& value, const char* unit, auto low, auto high,
                    const char* reason) {
      see(fmt::format("{}.{}", section, key), value, unit, low, high, reason);
    });
  });
}

template <class Value>
std::string text_of(const Value& value) {
  return fmt::format("{}", value);  // shortest text that reads back to the same number
}

template <class Value>
std::string range_of(Value low, Value high) {
  if constexpr (std::is_same_v<Value, bool>)
    return "true or false";
  else
    return fmt::format("{} .. {}", low, high);
}

/// False when `text` is not a value of this kind inside the range.
template <class Value>
bool read(const std::string& text, Value low, Value high, Value& value) {
  if constexpr (std::is_same_v<Value, bool>) {
    value = text == "true";
    return text == "true" || text == "false";
  } else {
    Value given{};
    const char* const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, given);
    if (error != std::errc{} || stop != end || !(given >= low && given <= high)) return false;
    value = given;
    return true;
  }
}

/// Edits (insert, delete, replace a letter) from one word to the other [Levenshtein 1966].
std::size_t edits(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] != b[j - 1] ? 1 : 0);
      diagonal = row[j];
      row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

std::string nearest_of(const std::string& name, const std::vector<std::string>& names) {
  return *std::min_element(
      names.begin(), names.end(),
      [&](const std::string& a, const std::string& b) { return edits(name, a) < edits(name, b); });
}

/// Whoever leaves the section out means the setting of that name.
std::string nearest_setting(const std::string& name) {
  LearnSettings all;
  std::vector<std::string> names;
  std::string same_key;
  for_each_setting(all, [&](const std::string& full, auto&, auto...) {
    names.push_back(full);
    if (full.substr(full.find('.') + 1) == name) same_key = full;
  });
  return same_key.empty() ? nearest_of(name, names) : same_key;
}

}  // namespace

const std::vector<Profile>& profiles() {
  static const std::vector<Profile> all = {
      {"ours", "the defaults", {}},
      {"paper",
       "what the paper prints, where the defaults differ",
       {{"middle.start_at_reference=false", "\"initialized with the initial state of the robot\""},
        {"middle.gain_rate_factor=1", "\"also obtained by the same learning rule\""},
        {"middle.max_gain_norm=1000", "no limit of the gain is printed"},
        {"middle.first_knots_follow=false", "no rule for knots before the first plan is printed"},
        {"mpc.gain_norm_limit=1000", "no limit of the gain is printed"},
        {"mpc.input_limit_rad=3.2", "no limit of the input is printed"},
        {"mpc.horizon=12", "\"N = 12\""},
        {"mpc.dt_s=0.06", "\"60 ms\""},
        {"mpc.warm_start=false", "\"no warm start technique was used\""},
        {"mpc.one_noise_channel=true", "F is a vector and w has unit covariance: w is a number"},
        {"mpc.noise_over_root_dt=true", "F is divided by the root of dt, and w by nothing"},
        {"mpc.one_step_prediction=true", "x_k is f(x_k-1, u_k-1), one step"},
        {"mpc.inputs_at_knots=true", "u_k is the input at knot k, first-order hold between"},
        {"bring_up.on=false", "initial parameters are \"from CAD or by hand\""},
        {"session.learn_model_every=10", "\"trained every 10 iterations\""},
        {"session.learn_first_after=0", "no other occasion is printed"},
        {"session.learn_after_failures=0", "no other occasion is printed"},
        {"session.sigma_by_trials=false", "it depends \"on the accuracy\" of a trained model"},
        {"session.input_share_floor=1", "W_u is one number"},
        {"model.newest_episodes=1000000", "data \"are added to the motion dataset\": all of them"},
        {"model.tilt_limit_rad=3.2", "all of them: falls too"},
        {"model.flight_ticks=0", "all of them, through landings"},
        {"model.failures_teach=false", "trajectories of N steps; a hold is no motion data"},
        {"model.held_out_decides=false", "nothing is held out"},
        {"model.trust_by_trials=false", "the network is used as trained"},
        {"model.set_up=false", "theta are masses, inertias, servos and friction"},
        {"identify.refine_steps=0", "the search is by samples"},
        {"identify.prior_weight=0", "only the N-step loss is minimised"}}}};
  return all;
}

void apply_setting(const std::string& assignment, LearnSettings& settings) {
  const std::size_t equals = assignment.find('=');
  const std::string name = assignment.substr(0, equals);
  if (equals == std::string::npos)
    throw std::runtime_error(
        fmt::format("--set {}: expected NAME=VALUE, as in mpc.horizon=12", assignment));
  const std::string text = assignment.substr(equals + 1);
  bool known = false;
  for_each_setting(settings, [&](const std::string& full, auto& value, const char* unit, auto low,
                                 auto high, const char*) {
    if (full != name) return;
    known = true;
    using Value = std::decay_t<decltype(value)>;
    if (!read<Value>(text, low, high, value))
      throw std::runtime_error(fmt::format("--set {}: {} is '{}', expected {} ({})", assignment,
                                           full, text, range_of<Value>(low, high), unit));
  });
  if (!known)
    throw std::runtime_error(
        fmt::format("--set {}: there is no setting '{}'; the nearest is '{}' (all of them: "
                    "docs/settings-learn.md, or --settings)",
                    assignment, name, nearest_setting(name)));
}

void apply_profile(const std::string& name, LearnSettings& settings) {
  std::vector<std::string> names;
  for (const Profile& profile : profiles()) {
    names.emplace_back(profile.name);
    if (name != profile.name) continue;
    for (const ProfileEntry& entry : profile.entries) apply_setting(entry.setting, settings);
    settings.session.profile = name;
    return;
  }
  throw std::runtime_error(fmt::format("--profile {}: expected one of {}", name,
                                       fmt::join(names.begin(), names.end(), ", ")));
}

std::string changed_settings(LearnSettings defaults, LearnSettings settings) {
  std::vector<std::string> before;
  for_each_setting(defaults, [&](const std::string&, auto& value, auto...) {
    before.push_back(text_of(value));
  });
  std::string changed;
  std::size_t i = 0;
  for_each_setting(settings, [&](const std::string& full, auto& value, const char* unit, auto...) {
    const std::string now = text_of(value), &then = before[i++];
    if (now == then || std::string(unit) == "threads" || full == "mpc.pin_threads") return;
    changed += fmt::format("{}{}={}", changed.empty() ? "" : " ", full, now);
  });
  return changed;
}

std::string learn_settings_page() {
  std::string page =
      "# Settings of planner and session\n\n"
      "Made from the `visit` of their structs (`host/mpc/mpc_settings.h`, `host/learn`) by "
      "`sanso-learn-settings-page`; a test compares.\n`sanso learn --set NAME=VALUE` sets any of "
      "them (more than once), after `--profile` and the motion's file. What differs from the\n"
      "defaults stands in `summary.json` and must agree to resume. The controller's settings: "
      "[settings](settings.md).\n";
  LearnSettings settings;
  settings.visit([&](const char* section, auto& group) {
    page += fmt::format(
        "\n## {}\n\n| name | default | range | unit | why |\n|---|---|---|---|---|\n", section);
    group.visit([&](const char* key, auto& value, const char* unit, auto low, auto high,
                    const char* reason) {
      using Value = std::decay_t<decltype(value)>;
      page += fmt::format("| `{}.{}` | {} | {} | {} | {} |\n", section, key, text_of(value),
                          range_of<Value>(low, high), unit, reason);
    });
  });
  for (const Profile& profile : profiles()) {
    if (profile.entries.empty()) continue;
    page += fmt::format("\n## --profile {}\n\n{}.\n\n| setting | why |\n|---|---|\n", profile.name,
                        profile.meaning);
    for (const ProfileEntry& entry : profile.entries)
      page += fmt::format("| `{}` | {} |\n", entry.setting, entry.reason);
  }
  return page;
}

}  // namespace sanso::app
