// A floating robot simulated from a recorded state, for people to look at: the joints move as
// recorded, the base as momentum, gravity and a hard ground have it. No verdict rests on it.
#pragma once

#include <vector>

#include "tools/diagnose/wholebody/contacts.h"
#include "tools/diagnose/wholebody/questions.h"

namespace sanso::diagnose {

/// Base poses in the recording's axes and lengths, one a row of the shot.
struct BaseMotion {
  std::vector<V3> p;
  std::vector<M3> R;
};

class BaseRollOut {
 public:
  /// Keeps both; throws files::InputError for an effect that a floating base cannot have.
  BaseRollOut(const WholeBody& body, const WholeRecording& recording);

  /// Whether base pose and shapes are there to begin with.
  static bool possible(const WholeBody& body, const WholeRecording& recording);

  /// From the recorded state of the shot's first row. Rows of a shot belong to one piece.
  BaseMotion from(const Span& shot) const;
  /// Of the ground, in the recording's axes and lengths, m.
  double ground() const { return known_.pose_scale * ground_; }

 private:
  struct State;
  struct Contact;
  struct Inertia;
  State start(const Span& shot) const;
  void step(State& s, const Eigen::VectorXd& q, const Eigen::VectorXd& q_next, double h) const;
  std::vector<Contact> contacts(const State& s, const BodyKinematics& now,
                                const BodyKinematics& later, double h) const;
  void push(State& s, std::vector<Contact>& touching, const Inertia& whole) const;
  double lowest(const BodyKinematics& kinematics) const;
  double ground_height() const;

  WholeBody body_;  // with the masses of its effects
  Known known_;
  const WholeRecording& recording_;
  std::vector<TouchPoint> points_;
  std::vector<double> friction_;  // by point
  V3 gravity_, normal_;           // in the poses' axes
  double ground_ = 0.0;           // along the normal, m
  double restitution_ = 0.0;
};

}  // namespace sanso::diagnose
