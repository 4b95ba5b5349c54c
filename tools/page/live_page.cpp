// Three locks, each held for a copy of a few hundred bytes: the newest observation, what the host
// knows of the trial, and the words of the session. Whoever controls only tries them.
#include "tools/page/live_page.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "host/learn/session/session_state.h"
#include "host/learn/session/trial.h"

namespace sanso::page {
namespace {

using nlohmann::json;
constexpr auto kFramePeriod = std::chrono::milliseconds(33);
constexpr auto kLookAgain = std::chrono::milliseconds(50);

template <class Numbers>
std::string list(const Numbers& numbers, std::size_t count) {
  std::string out = "[";
  for (std::size_t i = 0; i < count; ++i) {
    const auto v = static_cast<double>(numbers[static_cast<int>(i)]);
    out += fmt::format("{}{:.4f}", i > 0 ? "," : "", std::isfinite(v) ? v : 0.0);
  }
  return out + "]";
}

json trial_json(const learn::TrialSummary& t) {
  return {{"n", t.trial + 1},
          {"cost", t.cost},
          {"failed", t.failed()},
          {"end", learn::to_string(t.end)}};
}

}  // namespace

LivePage::LivePage(LivePageSettings settings) : settings_(std::move(settings)) {
  ServerContents contents;
  contents.scene = [this] { return scene(); };
  contents.greeting = [this] { return greeting(); };
  if (settings_.control) {
    contents.control = [this](const std::string& asked) { return control(asked); };
    buttons_["stop"] = [this] {
      pause(true);
      return std::string("waits after the trial under way");
    };
    buttons_["start"] = [this] {
      pause(false);
      return std::string("goes on");
    };
  }
  server_ = std::make_unique<Server>(settings_.port, std::move(contents));
  thread_ = std::thread([this] { run(); });
}

LivePage::~LivePage() {
  stop_ = true;
  thread_.join();
  server_.reset();
}

void LivePage::observe(const wire::Observation& observation) {
  const std::unique_lock lock(newest_mutex_, std::try_to_lock);
  if (!lock) return;
  newest_ = observation;
  fresh_ = true;
}

void LivePage::observe(const wire::Observation& observation, const FootLoads& loads) {
  const std::unique_lock lock(newest_mutex_, std::try_to_lock);
  if (!lock) return;
  newest_ = observation;
  loads_ = loads;
  fresh_ = has_loads_ = true;
}

void LivePage::set_button(const std::string& name, std::function<std::string()> action) {
  const std::unique_lock lock(buttons_mutex_);
  if (action)
    buttons_[name] = std::move(action);
  else
    buttons_.erase(name);
}

void LivePage::emergency_stop_pressed() {
  viewer_stopped_ = true;
  pause(true);  // a session that clears the fault and goes on is not what a person means
}

void LivePage::pause(bool on) {
  paused_ = on;
  const json session = session_json();
  if (session.at("of") != 0) broadcast().publish(event("session", session.dump()), false);
}

std::string LivePage::take_next_motion() {
  const std::lock_guard lock(session_mutex_);
  return std::exchange(next_motion_, {});
}

// --- what the session tells ----------------------------------------------------------------------

void LivePage::session_begins(const std::string& motion, int trials,
                              const std::vector<learn::TrialSummary>& done) {
  {
    const std::lock_guard lock(session_mutex_);
    motion_ = motion;
    total_ = trials;
    trials_ = json::array();
    for (const learn::TrialSummary& t : done) trials_.push_back(trial_json(t));
  }
  broadcast().publish(event("session", session_json().dump()), false);
}

void LivePage::trial_begins(const learn::TrialSetup& setup) {
  auto poses = std::make_shared<std::vector<Pose>>();
  poses->reserve(setup.reference.size());
  for (const model::State& x : setup.reference) {
    Pose& pose = poses->emplace_back();
    for (std::size_t i = 0; i < kShown; ++i) pose[i] = static_cast<float>(x[static_cast<int>(i)]);
  }
  const std::lock_guard lock(known_mutex_);
  known_ = {std::move(poses), 0.0, 0.0};
}

void LivePage::planned(double update_ms) {
  const std::unique_lock lock(known_mutex_, std::try_to_lock);
  if (lock) known_.update_ms = std::max(known_.update_ms, update_ms);
}

void LivePage::judged(double cost_so_far) {
  const std::unique_lock lock(known_mutex_, std::try_to_lock);
  if (lock) known_.cost = cost_so_far;
}

void LivePage::trial_ended(const learn::TrialSummary& summary) {
  viewer_stopped_ = false;
  const json trial = trial_json(summary);
  {
    const std::lock_guard lock(session_mutex_);
    trials_.push_back(trial);
  }
  broadcast().publish(event("trial", trial.dump()), false);
}

bool LivePage::stopped_by_viewer() {
  if (!viewer_stopped_.exchange(false)) return false;
  pause(true);  // pressed while it was already going on again
  return true;
}

bool LivePage::ends_session() {
  for (;;) {
    {
      const std::lock_guard lock(session_mutex_);
      if (!next_motion_.empty()) return true;
    }
    if (!paused_ || settings_.interrupted()) return false;
    std::this_thread::sleep_for(kLookAgain);
  }
}

// --- what viewers get ----------------------------------------------------------------------------

void LivePage::run() {
  auto next = std::chrono::steady_clock::now();
  while (!stop_) {
    next += kFramePeriod;
    std::this_thread::sleep_until(next);
    wire::Observation o;
    FootLoads loads;
    bool fresh = false, has_loads = false;
    {
      const std::lock_guard lock(newest_mutex_);
      o = newest_;
      loads = loads_;
      fresh = std::exchange(fresh_, false);
      has_loads = has_loads_;
    }
    if (!fresh || broadcast().viewers() == 0) continue;
    Known known;
    {
      const std::lock_guard lock(known_mutex_);
      known = known_;
      known_.update_ms = 0.0;
    }
    broadcast().publish(event("frame", frame(o, has_loads ? &loads : nullptr, known)), true);
  }
}

std::string LivePage::frame(const wire::Observation& o, const FootLoads* loads,
                            const Known& known) {
  std::string reference = "null";
  model::Input rest = model::joints(o.x);
  if (known.reference && !known.reference->empty() && o.trial_tick >= 0) {
    const std::size_t k =
        std::min(static_cast<std::size_t>(o.trial_tick), known.reference->size() - 1);
    reference = list((*known.reference)[k], kShown);
    for (int j = 0; j < model::kNumJoints; ++j)
      rest[j] = known.reference->front()[static_cast<std::size_t>(model::kXJoint + j)];
  }
  const std::string forces =
      loads ? fmt::format("[[0,0,{:.2f}],[0,0,{:.2f}]]", (*loads)[0], (*loads)[1]) : "null";
  const std::array<double, 3> parts = layer_parts(o, rest);
  const std::string update = known.update_ms > 0 ? fmt::format("{:.2f}", known.update_ms) : "null";
  return fmt::format(
      R"({{"t":{:.3f},"tick":{},"s":{},"f":{},"tt":{},"n":{},"x":{},"r":{},"F":{},"c":{},)"
      R"("lim":{},"u":{},"cost":{:.4f},"up":{},"bus":[{},{}],"late":{},"cpu":{},"V":{:.2f},)"
      R"("T":{:.1f},"paused":{}}})",
      to_seconds(o.time), o.tick, static_cast<int>(o.state), o.fault, o.trial_tick, o.trial_id,
      list(o.x, kShown), reference, forces, o.contact, o.limits,
      fmt::format("[{:.4f},{:.4f},{:.4f}]", parts[0], parts[1], parts[2]), known.cost, update,
      o.bus_lost, o.bus_corrupt, o.late_ticks, o.tick_cpu_ns / 1000, o.voltage_V,
      o.max_temperature_C, paused_.load());
}

std::string LivePage::scene() const {
  json scene = settings_.scene;
  scene["control"] = settings_.control;
  {
    const std::lock_guard lock(session_mutex_);
    scene["motion"] = motion_;
  }
  scene["can"] = json::array();
  const std::shared_lock lock(buttons_mutex_);
  for (const auto& [name, action] : buttons_) scene["can"].push_back(name);
  return scene.dump();
}

json LivePage::session_json() const {
  const std::lock_guard lock(session_mutex_);
  return {{"motion", motion_}, {"of", total_}, {"trials", trials_}, {"paused", paused_.load()}};
}

std::vector<std::string> LivePage::greeting() const {
  const json session = session_json();
  if (session.at("of") == 0) return {};
  return {event("session", session.dump())};
}

// --- what viewers ask ----------------------------------------------------------------------------

std::string LivePage::next_motion(const json& asked) {
  const auto name = asked.at("motion").get<std::string>();
  const json& known = settings_.scene.at("motions");
  if (std::find(known.begin(), known.end(), name) == known.end())
    throw std::runtime_error("there is no motion '" + name + "'");
  const std::lock_guard lock(session_mutex_);
  next_motion_ = name;
  return "after the trial under way";
}

std::string LivePage::control(const std::string& text) {
  json asked = json::parse(text, nullptr, false);
  if (!asked.is_object() || !asked.contains("do") || !asked.at("do").is_string())
    throw std::runtime_error("expected {\"do\": \"estop\"} or the name of another button");
  const auto name = asked.at("do").get<std::string>();
  const std::shared_lock lock(buttons_mutex_);
  const auto found = buttons_.find(name);
  if (found == buttons_.end()) throw std::runtime_error("there is no button '" + name + "' here");
  return name == "next" ? next_motion(asked) : found->second();
}

}  // namespace sanso::page
