// Coupled phase oscillators that drive joint targets around a posture, while a hand holds the robot
// and its motion is recorded [Ijspeert 2008]:
//
//   phi_i' = 2 pi f_i + K sum_j sin((phi_j - lag_j) - (phi_i - lag_i))       oscillator i
//   r''    = a (a / 4 (1 - r) - r'),  a = 8 / rise                           amplitudes grow
//   q_m    = posture_m + r sum_i A_im sin(phi_i)                             target of joint m
//
// Equal frequencies settle at phi_i - phi_j = lag_i - lag_j from any phases but antiphase.
#pragma once

#include <string>
#include <vector>

#include "shared/model/state_layout.h"

namespace sanso::motion {

struct Oscillator {
  double frequency_Hz = 1.0;
  double lag_rad = 0.0;
  model::Input amplitude_rad = model::Input::Zero();  // negative: in antiphase
};

/// A recording's recipe (TOML; kExampleRecordRecipe), which `sanso motions record` reads.
struct RecordRecipe {
  std::string like;         // posture, ground, weights and clauses are this motion's
  bool rhythmic = false;    // whole cycles are cut, else the whole episode is one
  double duration_s = 0.0;  // of the recording; 0: that of `like`
  double coupling = 5.0;    // K, 1/s
  double rise_s = 0.5;
  int cycles = 3;                  // rhythmic: averaged, the last ones
  double basis_per_second = 20.0;  // of the primitives
  double hand = 1.0;               // strength, 0..1
  std::vector<Oscillator> oscillators;
};

extern const char* const kExampleRecordRecipe;

/// `file` names the recipe in messages. Throws files::InputError.
RecordRecipe parse_record_recipe(const std::string& text, const std::string& file);

class Oscillators {
 public:
  /// `phase_rad`: of every oscillator at first; empty: its lag.
  explicit Oscillators(const RecordRecipe& recipe, std::vector<double> phase_rad = {});
  void step(double dt_s);
  /// What is added to the posture [rad].
  model::Input offset() const;
  const std::vector<double>& phase_rad() const { return phase_; }

 private:
  std::vector<Oscillator> oscillators_;
  double coupling_, gain_;
  std::vector<double> phase_;
  double amplitude_ = 0.0, amplitude_rate_ = 0.0;
};

}  // namespace sanso::motion
