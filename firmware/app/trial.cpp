// Takes uploads at the start of a tick, so that one tick sees one set of layers; the sum itself
// is shared/policy/layer_sum.h.
#include "firmware/app/trial.h"

#include <algorithm>

namespace sanso::firmware {

void Trial::take_uploads(Handover& handover, bool running) {
  if (!running) {
    if (handover.primitives.update()) {
      primitives_ = &handover.primitives.front();
      first_pose_ = model::joints(primitives_->start_state());
      first_lean_ = lean_of(primitives_->start_state());
      has_primitives_ = true;
    }
    if (handover.middle.update()) middle_ = &handover.middle.front();
  }
  if (handover.upper.update()) take_upper(handover.upper.front());
}

void Trial::take_upper(const policy::UpperPolicy& policy) {
  const bool running = tick_ >= 0;
  if (running && policy.trial_id != id_) {
    ++stale_policies_;
    return;
  }
  // for a later trial
  if (any_sequence_ && has_next_ && next_.trial_id != policy.trial_id) any_sequence_ = false;
  const bool newer =
      !any_sequence_ || static_cast<std::int32_t>(policy.sequence - newest_sequence_) > 0;
  if (!newer) {
    ++stale_policies_;
    return;
  }
  newest_sequence_ = policy.sequence;
  any_sequence_ = true;
  next_ = policy;
  has_next_ = true;
}

Refusal Trial::check(const wire::Command& command) const {
  if (!has_primitives_) return Refusal::no_primitives;
  const bool uses_middle = policy::LayerSwitches::from_mask(command.layers).middle;
  if (uses_middle && middle_ != nullptr && middle_->trial_id != command.trial_id)
    return Refusal::stale_table;
  return Refusal::none;
}

void Trial::start(const wire::Command& command) {
  id_ = command.trial_id;
  set_layers(command.layers);
  duration_ticks_ =
      command.duration_ticks > 0 ? command.duration_ticks : primitives_->duration_ticks();
  player_.reset(*primitives_);
  has_upper_ = false;
  if (has_next_ && next_.trial_id != id_) {
    has_next_ = false;
    any_sequence_ = false;
  }
  if (!has_next_) any_sequence_ = false;
  first_advance_ = true;
  tick_ = -1;
}

void Trial::advance() {
  ++tick_;
  if (!first_advance_) player_.step();
  first_advance_ = false;
}

void Trial::end() {
  tick_ = -1;
  has_upper_ = has_next_ = any_sequence_ = false;
}

policy::LayerOutputs Trial::layers(const model::State& x) {
  if (has_next_ && tick_ >= next_.first_tick) {
    upper_ = next_;
    has_upper_ = true;
    has_next_ = false;
  }
  return policy::layer_outputs(has_upper_ ? &upper_ : nullptr, middle_, player_.input(),
                               first_pose_, tick_, x, on_, reflex_, scratch_);
}

model::Input Trial::middle_at_start(const model::State& x) {
  if (!on_.middle || middle_ == nullptr) return model::Input::Zero();
  // the origin of the trial will be under the robot: no error of place or heading
  model::State here = x;
  here.segment<2>(model::kXPos).setZero();
  const double yaw = math::yaw_of(model::base_quat(x));
  const math::Quat quat_turn_back(std::cos(0.5 * yaw), 0.0, 0.0, -std::sin(0.5 * yaw));
  here.segment<4>(model::kXQuat) = math::quat_multiply(quat_turn_back, model::base_quat(x));
  here.segment<3>(model::kXVel) =
      math::rotation_matrix(quat_turn_back) * x.segment<3>(model::kXVel);
  policy::sample_middle(*middle_, 0.0, scratch_);
  return policy::affine(scratch_, here);
}

std::int16_t Trial::upper_age_ticks() const {
  if (!has_upper_ || tick_ < 0) return -1;
  return static_cast<std::int16_t>(
      std::clamp(tick_ - policy::last_tick(upper_), -30000.0, 30000.0));
}

}  // namespace sanso::firmware
