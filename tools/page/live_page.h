// The live page of a running session or of a watched controller: takes observations from whoever
// has them, adds what only the host knows, and sends a frame thirty times a second to whoever
// looks. Nobody who controls anything ever waits for it.
#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <shared_mutex>
#include <string>
#include <thread>
#include <vector>

#include "host/learn/session/watcher.h"
#include "shared/wire/messages.h"
#include "tools/page/layer_parts.h"
#include "tools/page/server.h"

namespace sanso::page {

struct LivePageSettings {
  int port = 0;          // 0: any
  bool control = false;  // the buttons work
  nlohmann::json scene;  // scene_of(), and "robot", "faults", "motions"
  // a person has interrupted the program: a paused session then ends
  std::function<bool()> interrupted = [] { return false; };
};

/// Normal force under the right and the left foot [N].
using FootLoads = std::array<double, 2>;

class LivePage : public learn::SessionWatcher {
 public:
  explicit LivePage(LivePageSettings settings);
  ~LivePage() override;

  std::string address() const { return server_->address(); }
  Broadcast& broadcast() { return server_->broadcast(); }

  /// The newest counts. Never waits: an observation that comes while a frame is being made is left
  /// out.
  void observe(const wire::Observation& observation);
  void observe(const wire::Observation& observation, const FootLoads& loads);

  /// What the button `name` does; answers in words, throws to refuse. Called by a thread of the
  /// server. An empty function takes it away: when this returns, nobody is in it any more.
  void set_button(const std::string& name, std::function<std::string()> action);
  /// Holds the session between two trials until somebody presses start.
  void pause(bool on);
  /// A viewer's emergency stop: pauses, and is remembered until the trial that it meets has ended.
  void emergency_stop_pressed();
  /// The motion that somebody asked for since the last call; empty: none.
  std::string take_next_motion();

  // learn::SessionWatcher
  void session_begins(const std::string& motion, int trials,
                      const std::vector<learn::TrialSummary>& done) override;
  void trial_begins(const learn::TrialSetup& setup) override;
  void planned(double update_ms) override;
  void judged(double cost_so_far) override;
  void trial_ended(const learn::TrialSummary& summary) override;
  bool ends_session() override;
  bool stopped_by_viewer() override;

 private:
  using Pose = std::array<float, kShown>;
  /// What the host knows of the trial under way.
  struct Known {
    std::shared_ptr<const std::vector<Pose>> reference;
    double cost = 0;
    double update_ms = 0;  // since the last frame; 0: none
  };

  void run();
  std::string frame(const wire::Observation& o, const FootLoads* loads, const Known& known);
  std::string scene() const;
  std::vector<std::string> greeting() const;
  std::string control(const std::string& json);
  std::string next_motion(const nlohmann::json& asked);
  nlohmann::json session_json() const;

  LivePageSettings settings_;
  std::mutex newest_mutex_;
  wire::Observation newest_;
  FootLoads loads_{};
  bool fresh_ = false, has_loads_ = false;
  std::mutex known_mutex_;
  Known known_;
  mutable std::mutex session_mutex_;  // words: motion and trials
  std::string motion_, next_motion_;
  int total_ = 0;
  nlohmann::json trials_ = nlohmann::json::array();
  // shared by those who press a button, for as long as it acts
  mutable std::shared_mutex buttons_mutex_;
  std::map<std::string, std::function<std::string()>> buttons_;
  std::atomic<bool> paused_{false}, stop_{false}, viewer_stopped_{false};
  std::unique_ptr<Server> server_;
  std::thread thread_;
};

}  // namespace sanso::page
