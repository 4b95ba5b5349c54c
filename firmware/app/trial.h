// A trial: its clock, the uploaded layers, and their sum at every tick. Uploads of primitives and
// tables are taken up between trials only; upper policies at any time, each used from its first
// tick on.
#pragma once

#include "firmware/exchange/faults.h"
#include "firmware/exchange/handover.h"
#include "firmware/lower/balance.h"
#include "shared/policy/layer_sum.h"

namespace sanso::firmware {

class Trial {
 public:
  explicit Trial(const policy::ReflexSettings& reflex) : reflex_(reflex) {}

  /// Takes what the link has put into the mailboxes. `running`: a trial is under way.
  void take_uploads(Handover& handover, bool running);

  /// none, or why this trial cannot start.
  Refusal check(const wire::Command& command) const;
  /// Trial tick 0 is the next call of advance().
  void start(const wire::Command& command);
  /// Moves the trial clock to the next tick.
  void advance();
  void end();

  bool over() const { return tick_ + 1 >= duration_ticks_; }
  std::int32_t tick() const { return tick_; }
  std::uint32_t id() const { return id_; }

  /// Sum of the layers at this tick and state x.
  policy::LayerOutputs layers(const model::State& x);

  bool has_primitives() const { return has_primitives_; }
  /// Joint angles in which the uploaded motion begins [rad].
  const model::Input& first_pose() const { return first_pose_; }
  /// How its trunk leans there.
  const Lean& first_lean() const { return first_lean_; }
  /// What the middle layer adds at the start of the trial, for a robot that stands at x (place and
  /// heading ignored).
  model::Input middle_at_start(const model::State& x);
  model::Input reflex(const model::State& x) const {
    return on_.reflex ? policy::reflex(x, reflex_) : model::Input::Zero();
  }
  void set_layers(std::uint8_t mask) { on_ = policy::LayerSwitches::from_mask(mask); }

  // for the observation
  std::uint32_t upper_sequence() const { return has_upper_ ? upper_.sequence : 0; }
  std::int16_t upper_age_ticks() const;
  bool upper_wanted() const { return on_.upper; }
  bool has_upper() const { return has_upper_; }
  std::uint32_t stale_policies() const { return stale_policies_; }

 private:
  void take_upper(const policy::UpperPolicy& policy);

  policy::ReflexSettings reflex_;
  policy::LayerSwitches on_;
  std::uint32_t id_ = 0;
  std::int32_t tick_ = -1;
  std::int32_t duration_ticks_ = 0;
  bool first_advance_ = false;

  bool has_primitives_ = false;
  const policy::PrimitiveSet* primitives_ = nullptr;
  policy::PrimitivePlayer player_;
  model::Input first_pose_ = model::Input::Zero();
  Lean first_lean_;

  const policy::MiddleTable* middle_ = nullptr;

  policy::UpperPolicy upper_, next_;
  bool has_upper_ = false, has_next_ = false;
  std::uint32_t newest_sequence_ = 0;
  bool any_sequence_ = false;
  std::uint32_t stale_policies_ = 0;
  policy::Knot scratch_;
};

}  // namespace sanso::firmware
