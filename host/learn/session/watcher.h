// Somebody who watches a session: told what the controller does not know, asked between two trials
// whether to go on.
#pragma once

#include <string>
#include <vector>

namespace sanso::learn {

struct TrialSetup;
struct TrialSummary;

class SessionWatcher {
 public:
  virtual ~SessionWatcher() = default;
  /// Before the first trial of this run: what has been done already, and how many there shall be.
  virtual void session_begins(const std::string& motion, int trials,
                              const std::vector<TrialSummary>& done) = 0;
  /// The three below are called by the thread that plans: none of them may wait for anybody.
  virtual void trial_begins(const TrialSetup& setup) = 0;
  virtual void planned(double update_ms) = 0;
  virtual void judged(double cost_so_far) = 0;
  virtual void trial_ended(const TrialSummary& summary) = 0;
  /// Called between two trials; may wait, as a person may. True: the session ends here.
  virtual bool ends_session() = 0;
  /// True once after a viewer's emergency stop: one that met the robot before its trial began is no
  /// reason to end the session. ends_session() then waits until the viewer goes on.
  virtual bool stopped_by_viewer() { return false; }
};

}  // namespace sanso::learn
