// How a clause reads in a report, and which failures count: a clause that is waived does not.
#include "host/motion/success.h"

#include <algorithm>
#include <cstdio>
#include <stdexcept>

#include "host/motion/measures.h"

namespace sanso::motion {

std::string ClauseResult::text() const {
  char buffer[160];
  std::string out = clause.measure;
  std::snprintf(buffer, sizeof buffer, " %.4g", value);
  out += value == value ? buffer : " not measured";
  if (clause.at_least) {
    std::snprintf(buffer, sizeof buffer, ", at least %.4g", *clause.at_least);
    out += buffer;
  }
  if (clause.at_most) {
    std::snprintf(buffer, sizeof buffer, ", at most %.4g", *clause.at_most);
    out += buffer;
  }
  return out + (holds ? ": holds" : clause.waived.empty() ? ": failed" : ": waived");
}

bool Verdict::succeeded() const {
  return std::none_of(clauses.begin(), clauses.end(),
                      [](const ClauseResult& c) { return c.counts_against(); });
}

std::vector<std::string> Verdict::failures() const {
  std::vector<std::string> texts;
  for (const auto& c : clauses) {
    if (c.counts_against()) texts.push_back(c.text());
  }
  return texts;
}

std::vector<MeasureInfo> known_measures() {
  std::vector<MeasureInfo> infos;
  for (const Measure& m : measures()) infos.push_back({m.name, m.meaning});
  return infos;
}

Verdict evaluate(const std::vector<Clause>& clauses, const MotionEpisode& episode,
                 const Trajectory& reference, const Window& window, const model::Ground& ground) {
  const MeasureInput input{episode, reference, window, ground};
  Verdict verdict;
  for (const Clause& clause : clauses) {
    const Measure* measure = find_measure(clause.measure);
    if (!measure) throw std::invalid_argument("no measure named '" + clause.measure + "'");
    ClauseResult result{clause, EpisodeSample::kUnknown, false};
    if (!episode.samples.empty() && !reference.x.empty()) result.value = measure->of(input);
    result.holds = result.value == result.value &&
                   (!clause.at_least || result.value >= *clause.at_least) &&
                   (!clause.at_most || result.value <= *clause.at_most);
    verdict.clauses.push_back(result);
  }
  return verdict;
}

}  // namespace sanso::motion
