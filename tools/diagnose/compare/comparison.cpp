// Questions that a comparison answers about itself.
#include "tools/diagnose/compare/comparison.h"

#include <algorithm>
#include <cmath>

namespace sanso::diagnose {

const char* to_string(Signal signal) {
  switch (signal) {
    case Signal::q:
      return "q";
    case Signal::dq:
      return "dq";
    case Signal::tau:
      return "tau";
    case Signal::i:
      return "i";
    case Signal::pwm:
      return "pwm";
  }
  return "q";
}

const std::vector<double>& column(const JointData& data, Signal signal) {
  switch (signal) {
    case Signal::dq:
      return data.dq;
    case Signal::tau:
      return data.tau;
    case Signal::i:
      return data.i;
    case Signal::pwm:
      return data.pwm;
    default:
      return data.q;
  }
}

double measured(const Source& source, const Observed& channel, std::size_t row) {
  return MeasuredColumn(source, channel).at(row);
}

bool near_instant(const Comparison& comparison, const Shot& shot, double t) {
  const std::vector<double>& clock = comparison.sources[shot.source].drive.t;
  const double from = clock[shot.window.first], length = clock[shot.window.last] - from;
  return std::abs(t - from) < 1.5 * length;
}

double longest_recording(const Comparison& comparison) {
  double longest = 0.0;
  for (const Source& s : comparison.sources)
    longest = std::max(longest, s.drive.t.back() - s.drive.t.front());
  return longest;
}

double rows_of_a_joint(const Comparison& comparison) {
  double rows = 0.0;
  for (const Shot& shot : comparison.shots) rows += static_cast<double>(shot.rows);
  return rows;
}

}  // namespace sanso::diagnose
