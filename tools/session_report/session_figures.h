// The figures of a session's report, each from stored data to SVG.
#pragma once

#include <string>

#include "host/learn/session/session_state.h"

namespace sanso::report {

std::string cost_over_trials(const learn::SessionState& state);
/// rms of u_upper and u_middle, and the norms of their gains, over trials: how the middle layer
/// takes over.
std::string layers_over_trials(const learn::SessionState& state);
std::string gains_over_trials(const learn::SessionState& state);
/// How well the model in use predicted the trials, beside the model the session began with.
std::string model_over_trials(const learn::SessionState& state);
std::string joint_angle(const learn::Episode& episode, int joint);
/// rms over the joints of what each layer adds, over the trial; the lower layer as distance from
/// its first pose.
std::string layer_contributions(const learn::Episode& episode);
std::string base_height(const learn::Episode& episode);
std::string base_tilt(const learn::Episode& episode);
std::string foot_forces(const learn::Episode& episode);
std::string update_times(const learn::SessionState& state);

}  // namespace sanso::report
