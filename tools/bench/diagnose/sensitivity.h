// `sanso bench diagnose --folder DIR --sensitivity`: every setting of the diagnosis halved and
// doubled, one at a time, on the same cases; what changes in the answers is what hangs on it.
#pragma once

#include <string>
#include <vector>

namespace sanso::bench {

struct SensitivityOptions {
  std::string folder;             // of cases, see read_cases
  std::string out;                // sensitivity.json, which a stopped run goes on with
  std::vector<std::string> only;  // settings ("group.name") or groups; empty: all
  bool resume = false;            // answers that are in `out` are not asked for again
};

/// What one case said with one setting scaled.
struct ScaledAnswer {
  std::string setting;  // "group.name"; empty: all as they are
  double factor = 1.0;
  std::string name;  // of the case
  std::string said;  // status and the first of every set, or why there is no answer
  bool right = false;
  int wrong_confirmed = 0;
};

/// Markdown: the answers as they are, the settings on which none hangs, a row for every other one.
/// A factor under which a setting stays what it is (half of one attempt) has no answers, and no
/// difference.
std::string sensitivity_table(const std::vector<ScaledAnswer>& answers);

/// Asks two or more at a time (times mean nothing here); a line on stderr after each, with the time
/// that is left; the table at the end. Throws std::invalid_argument for a setting or group that
/// there is not, files::InputError for cases that cannot be read. Exit code 0.
int bench_sensitivity(const SensitivityOptions& options);

}  // namespace sanso::bench
