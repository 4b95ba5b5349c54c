// The tables of `sanso bench diagnose --folder`.
#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>
#include <set>

#include "tools/bench/diagnose/folder_bench.h"
#include "tools/bench/diagnose/outcome_json.h"
#include "tools/diagnose/stats/robust.h"
#include "tools/diagnose/stats/significance.h"

namespace sanso::bench {
namespace {

using Chosen = std::vector<const CaseOutcome*>;
using Question = std::function<bool(const CaseOutcome&)>;

Chosen choose(const std::vector<CaseOutcome>& all, const Question& wanted) {
  Chosen out;
  for (const CaseOutcome& o : all)
    if (wanted(o)) out.push_back(&o);
  return out;
}

/// "75 % [41, 93] of 8": Wilson's interval, 95 %.
std::string share(const Chosen& cases, const Question& hit) {
  if (cases.empty()) return "-";
  const int n = static_cast<int>(cases.size());
  const int hits = static_cast<int>(
      std::count_if(cases.begin(), cases.end(), [&](const CaseOutcome* o) { return hit(*o); }));
  const diagnose::Interval i = diagnose::wilson_interval(hits, n);
  return fmt::format("{:.0f} % [{:.0f}, {:.0f}] of {}", 100.0 * hits / n, 100 * i.low, 100 * i.high,
                     n);
}

double median_of(const Chosen& cases, const std::function<double(const CaseOutcome&)>& value) {
  std::vector<double> values;
  for (const CaseOutcome* o : cases) values.push_back(value(*o));
  return values.empty() ? 0.0 : diagnose::median(values);
}

double mean_of(const Chosen& cases, const std::function<double(const CaseOutcome&)>& value) {
  double sum = 0.0;
  for (const CaseOutcome* o : cases) sum += value(*o);
  return cases.empty() ? 0.0 : sum / static_cast<double>(cases.size());
}

std::string parameters_row(const Chosen& cases) {
  std::vector<double> errors;
  int covered = 0, intervals = 0;
  for (const CaseOutcome* o : cases) {
    for (const auto& [name, e] : o->said.relative_error) errors.push_back(e);
    for (const auto& [name, c] : o->said.covered) covered += c, ++intervals;
  }
  if (errors.empty()) return "";
  return fmt::format("; parameters {:.1f} % off (median), intervals cover {} of {}",
                     100 * diagnose::median(errors), covered, intervals);
}

std::string proof_row(const Chosen& cases) {
  Chosen proved;
  for (const CaseOutcome* o : cases)
    if (o->proved && o->oracle_explained > 0.0) proved.push_back(o);
  if (proved.empty()) return "";
  return fmt::format(
      "; explained {:.3f}, bounded {:.3f}, of what the truth explains {:.3f} (median)",
      median_of(proved, [](const CaseOutcome& o) { return o.explained; }),
      median_of(proved, [](const CaseOutcome& o) { return o.explained_bounded; }),
      median_of(proved, [](const CaseOutcome& o) { return o.explained / o.oracle_explained; }));
}

std::string family_row(CaseFamily family, const std::string& label, const Chosen& cases) {
  std::string row = fmt::format("{:<10} {:<14} right {}", in_answers(family), label,
                                share(cases, [](const CaseOutcome& o) { return o.said.right; }));
  if (family == CaseFamily::clean)
    return row + fmt::format("; false alarms {}\n",
                             share(cases, [](const CaseOutcome& o) { return o.said.detected; }));
  if (family == CaseFamily::decoy) return row + "\n";
  row += fmt::format("; detected {}",
                     share(cases, [](const CaseOutcome& o) { return o.said.detected; }));
  if (family == CaseFamily::outside) return row + "\n";
  row += fmt::format("; name first {}; in the set {} (mean size {:.2f}); place {}; F1 {:.2f}",
                     share(cases, [](const CaseOutcome& o) { return o.said.named_first; }),
                     share(cases, [](const CaseOutcome& o) { return o.said.in_set; }),
                     mean_of(cases, [](const CaseOutcome& o) { return o.said.set_size; }),
                     share(cases, [](const CaseOutcome& o) { return o.said.place_right; }),
                     mean_of(cases, [](const CaseOutcome& o) { return o.said.f1; }));
  return row + parameters_row(cases) + proof_row(cases) + "\n";
}

std::string families_by_ratio(const std::vector<CaseOutcome>& all,
                              const std::vector<double>& bounds) {
  std::string out = "Family by ratio (change of the positions over noise)\n";
  std::set<CaseFamily> families;
  for (const CaseOutcome& o : all) families.insert(o.family);
  for (const CaseFamily family : families) {
    const auto of_family = [&](const CaseOutcome& o) { return o.family == family; };
    out += family_row(family, "all", choose(all, of_family));
    for (std::size_t k = 0; k < bounds.size(); ++k) {
      const double low = bounds[k];
      const double high = k + 1 < bounds.size() ? bounds[k + 1] : 1e300;
      const Chosen some = choose(all, [&](const CaseOutcome& o) {
        return of_family(o) && o.ratio > 0.0 && o.ratio >= low && o.ratio < high;
      });
      if (some.empty()) continue;
      out += family_row(
          family,
          high < 1e299 ? fmt::format("{:g} to {:g}", low, high) : fmt::format("{:g} and more", low),
          some);
    }
  }
  return out;
}

std::string families_by_robot(const std::vector<CaseOutcome>& all) {
  std::string out = "\nFamily by robot\n";
  std::set<std::pair<CaseFamily, std::string>> groups;
  for (const CaseOutcome& o : all) groups.insert({o.family, o.robot});
  for (const auto& [family, robot] : groups)
    out += family_row(family, robot, choose(all, [&f = family, &r = robot](const CaseOutcome& o) {
                        return o.family == f && o.robot == r;
                      }));
  return out;
}

std::string wrong_answers(const std::vector<CaseOutcome>& all) {
  std::string out = "\nNot right\n";
  for (const CaseOutcome& o : all) {
    if (o.said.right) continue;
    out += fmt::format("  {}: {} {} ratio {:.1f}: {} -> {} {}\n", o.name, in_answers(o.family),
                       o.robot, o.ratio, fmt::join(o.truth, " + "), to_string(o.said.status),
                       fmt::join(o.said.named, " + "));
  }
  return out;
}

std::string times(const std::vector<CaseOutcome>& all) {
  std::string out =
      "\nTime of a diagnosis by robot, s: median, 90th, 99th percentile, largest; of the clock, "
      "then of the processor\n";
  std::map<std::string, std::pair<std::vector<double>, std::vector<double>>> seconds;
  for (const CaseOutcome& o : all) {
    seconds[o.robot].first.push_back(o.seconds);
    seconds[o.robot].second.push_back(o.cpu_seconds);
  }
  const auto distribution = [](const std::vector<double>& s) {
    return fmt::format("{:.1f} {:.1f} {:.1f} {:.1f}", diagnose::median(s),
                       diagnose::quantile(s, 0.9), diagnose::quantile(s, 0.99),
                       diagnose::quantile(s, 1.0));
  };
  for (const auto& [robot, s] : seconds)
    out += fmt::format("  {:<14} {}; {}  ({} cases)\n", robot, distribution(s.first),
                       distribution(s.second), s.first.size());
  return out;
}

}  // namespace

std::string folder_table(const std::vector<CaseOutcome>& outcomes,
                         const std::vector<double>& ratio_bounds) {
  int wrong = 0, findings = 0;
  for (const CaseOutcome& o : outcomes) {
    wrong += o.said.wrong_confirmed;
    findings += static_cast<int>(o.said.named.size());
  }
  return fmt::format("{} cases; intervals of shares are 95 % (Wilson)\n\n", outcomes.size()) +
         families_by_ratio(outcomes, ratio_bounds) + families_by_robot(outcomes) +
         fmt::format("\nCONFIRMED and not there: {} of {} findings\n", wrong, findings) +
         wrong_answers(outcomes) + times(outcomes);
}

std::string folder_json(const std::vector<CaseOutcome>& outcomes) {
  return nlohmann::json(outcomes).dump(2) + "\n";
}

}  // namespace sanso::bench
