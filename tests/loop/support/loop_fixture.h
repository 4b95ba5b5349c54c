// A session's parts, joined in process for tests of the whole loop.
#pragma once

#include <gtest/gtest.h>

#include <memory>

#include "host/learn/session/session.h"
#include "host/motion/motion.h"
#include "tools/inprocess/inprocess_access.h"

namespace sanso::loop {

/// Robot, planner and motion for single trials.
struct Loop {
  explicit Loop(const std::string& motion_name, const std::string& world = "lab")
      : motion(motion::MotionLibrary().load(motion_name)), access(world) {
    motion.primitives = learn::from_origin(motion.primitives);
    reference = learn::reference_of(motion.primitives);
    setup.primitives = &motion.primitives;
    setup.reference = reference;
    setup.weights = motion.weights;
    setup.layers.middle = false;
    setup.duration_ticks = motion.primitives.duration_ticks();
  }
  inprocess::InProcessRobot& robot() { return access.robot(); }

  /// Places the robot and brings it to hold.
  link::RobotLink& stand(std::uint64_t seed) {
    link = &access.place(reference.front(), seed);
    learn::prepare_trial(*link, setup, settings);
    return *link;
  }
  learn::Episode run(std::uint64_t seed) {
    stand(seed);
    learn::Episode episode = learn::run_trial(*link, upper, setup, settings);
    access.add_measurements(episode);
    return episode;
  }
  /// True height of the trunk [m], from the physics.
  double true_height() { return robot().robot().truth().p_world_base[2]; }
  bool on_its_feet() { return robot().robot().truth().other_contacts == 0 && true_height() > 0.17; }

  motion::Motion motion;
  std::vector<model::State> reference;
  inprocess::InProcessAccess access;
  mpc::UpperLayer upper{mpc::MpcSettings{}, host::AugmentedModel{}};
  learn::TrialSetup setup;
  learn::TrialSettings settings;
  link::RobotLink* link = nullptr;
};

}  // namespace sanso::loop
