// Bring-up before the first trial: the robot holds a few poses inside its balance, and what it
// shows by standing gives the model that the planner begins with (model/static_balance.h). Each
// pose is reached from both sides, so that dry friction, which may hold a joint on either side of
// where it belongs, leans both ways.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host/learn/model/model_learner.h"
#include "host/learn/model/static_balance.h"
#include "host/learn/session/trial.h"

namespace sanso::learn {

struct BringUpSettings {
  bool on = true;
  double forward_m = 0.02;
  double side_m = 0.015;
  double squat_m = 0.02;
  double hold_s = 2.0;
  double measure_s = 0.6;
  double still_rad_s = 0.5;
  double lean_limit_rad = 0.35;
  bool refine = true;
  StaticBalanceSettings balance;
  DampingOfMovesSettings moves;

  constexpr void visit(auto&& field) {
    field("on", on, "yes or no", false, true,
          "held poses before trial 1 give the model to begin with; no: the initial one (paper)");
    field("forward_m", forward_m, "m", 0.0, 0.04,
          "the trunk goes forward over feet that stay; soles reach 80 mm there, 30 mm behind");
    field("side_m", side_m, "m", 0.0, 0.03,
          "and to the left and right: less than to the middle of a foot, both stay loaded");
    field("squat_m", squat_m, "m", 0.0, 0.05,
          "and down: knees carry more, which tells stiffness from centre of mass");
    field("hold_s", hold_s, "s", 0.2, 10.0,
          "each pose: without friction a robot sways for 2 s after the way to it");
    field("measure_s", measure_s, "s", 0.05, 5.0, "at the end of it is the mean taken");
    field(
        "still_rad_s", still_rad_s, "rad/s", 0.01, 10.0,
        "root mean square of joint rates and turning above which a pose is not at rest: left out");
    field("lean_limit_rad", lean_limit_rad, "rad", 0.05, 1.0,
          "a trunk that leans more in a pose ends the bring-up: the next might make it fall");
    field("refine", refine, "yes or no", false, true,
          "all parameters are fitted to holds and ways together in the end, from what was found");
    balance.visit(field);
    moves.visit(field);
  }
};

/// A place of the trunk over feet that stay: forward, left, up [m] from the maker's standing pose.
struct TrunkShift {
  double forward_m = 0.0, left_m = 0.0, up_m = 0.0;
};

/// The poses in their order, each but the ends of a line twice.
std::vector<TrunkShift> bring_up_poses(const BringUpSettings& settings);

/// The maker's standing pose with the trunk upright and moved, soles where they were.
model::State shifted_stand(const TrunkShift& shift);

/// What was held; stops early when the robot leans far, falls or leaves the hold, and says why.
struct HeldPoses {
  std::vector<HeldPose> poses;
  std::string stopped;                  // empty: all were held
  std::vector<wire::Observation> seen;  // every 10 ms from the first pose on
};

/// Takes a robot in hold to one pose; returns after `hold_s`, the way included.
void hold_pose(link::RobotLink& robot, const TrunkShift& shift, double hold_s);

/// Arms a robot that was placed in shifted_stand({}), and takes it through the poses. It is left in
/// hold. Throws TrialError when it cannot be armed, StoppedBefore after an emergency stop.
HeldPoses hold_poses(link::RobotLink& robot, const BringUpSettings& settings,
                     const TrialSettings& trial);

/// What became of them.
struct BringUpModel {
  ModelLearner::Start start;  // N-step losses on what was seen from pose to pose
  // on the ways between the poses, in prior deviations; none: nothing moved
  std::optional<double> damping;
  std::optional<double> loss_refined;  // after all parameters were fitted to all that was seen
  double friction_Nm = 0.0;            // that the joints at rest leaned on
  std::vector<StaticFigure> figures;
};

/// The model that fits the poses; `learner` begins with it when it predicts what was seen better,
/// with the damping that the ways between them show, and from there with what fits all of it.
BringUpModel begin_with(const HeldPoses& held, const BringUpSettings& settings,
                        ModelLearner& learner);

/// All of it as JSON, for people; nothing reads it back.
void write_bring_up(const std::filesystem::path& path, const HeldPoses& held,
                    const BringUpModel& model);

}  // namespace sanso::learn
