// What the questions to a floating base come to: each asks one number, with its own interval, its
// own held-out proof, and the names that it may have.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tools/diagnose/effects/effect.h"
#include "tools/diagnose/verdict/verdict.h"
#include "tools/diagnose/wholebody/kinematics.h"

namespace sanso::diagnose {

/// Values that should all be one number. Those of one group hang together: a recording, or a piece
/// of one.
struct Samples {
  std::vector<double> value, weight;
  std::vector<std::size_t> group;
  /// A value with its weight (1 / variance, but for a factor) and its group.
  void add(double v, double w, std::size_t g) {
    value.push_back(v), weight.push_back(w), group.push_back(g);
  }
  std::size_t groups() const;
};

/// Weighted mean of samples with its 95 % interval (groups resampled), and what it does on every
/// third group when it is fitted to the others. RMS.
struct Measured {
  double value = 0.0, low = 0.0, high = 0.0, sigma = 0.0;
  double before = 0.0, after = 0.0, noise = 0.0;
  double gain = 0.0, gain_low = 0.0;  // share of the squared error that it removes there
  std::size_t groups = 0;
};
/// By what chance is judged.
struct Chance {
  WholeSettings whole;
  DecisionSettings decisions;
  unsigned long seed = 1;
  /// Standard deviations beyond which one of all the numbers that are asked is no chance.
  double deviations() const;
  /// P of a number so many deviations off, among all that are asked.
  double family_wise(double deviations) const;
};

/// Nothing where there are fewer groups than a hold-out needs.
std::optional<Measured> measured(const Samples& samples, double nominal, const Chance& chance);

/// A number that is asked for.
struct Asked {
  std::string effect, family;
  std::vector<std::string> where;
  std::string parameter, unit, regime;
  double nominal = 0.0;
  double tolerance = 0.0;                 // within it nothing is missing
  std::vector<std::string> equally_good;  // other names that the same data allow
  std::string channel;                    // of the held-out score
};

/// The first number of a figure, as the library has it: name, family, parameter, unit, regime. What
/// it stands at, and where, is the question's.
Asked asked_for(WholeFigure figure);

/// "effect.parameter at place": what answers keep a number by.
std::string number_of(const std::string& effect, const std::string& parameter,
                      const std::vector<std::string>& where);

/// Balances whose error a verdict states, held out.
inline constexpr const char* kStanceBalance = "stance";
inline constexpr const char* kWeightBalance = "weight";
inline constexpr const char* kSoleBalance = "sole";
inline constexpr const char* kImuBalance = "imu_acc";

struct WholeAnswers {
  std::vector<Finding> findings;
  std::vector<Untestable> untestable;
  std::vector<Detectable> detectable;
  std::vector<std::string> notes, log;
  std::vector<std::string> disagreements;   // of the notes: what does not hold for all recordings
  bool unnamed = false;                     // something is missing that has no name
  std::vector<LocationCell> locations;      // where it shows, strongest first
  std::map<std::string, FitScore> scores;   // by channel, on data that were not fitted
  std::size_t asked = 0;                    // numbers that these data could answer
  std::map<std::string, Measured> numbers;  // all that were judged, by "effect.parameter at place"

  /// Something that was asked for is missing.
  bool missing() const { return !findings.empty(); }
  void cannot(WholeFigure figure, const std::string& because);
  void cannot(const std::string& effect, const std::string& because);
  /// The same questions with another choice of a term that they do not ask for: intervals take in
  /// what it says, and a name that it does without has `choice` for a rival.
  void widen(const std::string& choice, const WholeAnswers& other, const Chance& chance);
  /// What a later question said, behind what stands here. What one of them names is testable,
  /// whatever another could not tell.
  void take(WholeAnswers later);
};

/// What one number says: a finding where it is further from nominal than its tolerance and chance
/// allow, else a note or the smallest size that would have been seen.
WholeAnswers answer_to(const Asked& asked, const Measured& m, const Chance& chance);

}  // namespace sanso::diagnose
