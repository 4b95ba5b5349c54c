// All of the recorded time, positions only: where errors that stand alone are looked for. The
// search thins fast and long recordings, and half of what happens now and then may lie where it
// does not look.
#pragma once

#include <vector>

#include "tools/diagnose/compare/candidate.h"
#include "tools/diagnose/compare/problem.h"
#include "tools/diagnose/explain/events.h"
#include "tools/diagnose/fit/fit.h"

namespace sanso::diagnose {

/// Events that a model leaves, and the energy of all its error (noise energies, starts taken out).
struct EventsLeft {
  std::vector<Event> events;  // strongest first
  double energy = 0.0;
};

class WholeTime {
 public:
  /// `search`: how the search cuts its shots; here they are as long, and none is left out.
  WholeTime(const std::vector<Source>& sources, const std::vector<NoiseLevel>& noise,
            const ProblemOptions& search, const Settings& settings);

  const Problem& problem() const { return problem_; }
  const Comparison& comparison() const { return *problem_; }
  /// Of the calibrated nominal model.
  const EventsLeft& nominal() const { return nominal_; }
  /// The nominal model's events repeat, and are more than what matters.
  bool nominal_matters() const;
  /// `search`, with instants and joints of the nominal model's events: what happens there is
  /// compared in every recording.
  ProblemOptions with_instants(ProblemOptions search) const;

  EventsLeft left_by(const Library& library, const Model& model) const;

 private:
  Problem problem_;
  EventsLeft nominal_;
};

}  // namespace sanso::diagnose
