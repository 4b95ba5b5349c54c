// Tables of stored outcomes: by family and ratio, beside simpler methods, confusions, times.
#include "tools/bench/diagnose/diagnose_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <set>

#include "tools/diagnose/effects/effect.h"
#include "tools/diagnose/stats/robust.h"
#include "tools/diagnose/stats/significance.h"

namespace sanso::bench {
namespace {

/// A proportion that grows case by case.
struct Count {
  int hits = 0, trials = 0;
  void add(bool hit) { hits += hit, ++trials; }
  std::string text() const {
    if (trials == 0) return "-";
    const diagnose::Interval i = diagnose::wilson_interval(hits, trials);
    return fmt::format("{:5.1f} % [{:.1f}, {:.1f}] of {}", 100.0 * hits / trials, 100 * i.low,
                       100 * i.high, trials);
  }
};

/// Scores of one family at one ratio (or of all ratios when `ratio` < 0).
void print_row(const std::vector<Outcome>& all, CaseFamily family, double ratio) {
  Count right, detected, named, in_set, where, refused, unnamed, covered;
  std::vector<double> errors, sizes, f1;
  for (const Outcome& o : all) {
    const DiagnoseScore& s = o.score;
    if (s.family != family || (ratio >= 0.0 && s.ratio != ratio)) continue;
    right.add(s.right), detected.add(s.detected), named.add(s.named_first), in_set.add(s.in_set),
        where.add(s.where_exact);
    refused.add(s.refused_by_name), unnamed.add(s.unnamed);
    sizes.push_back(s.set_size), f1.push_back(s.f1);
    for (const auto& [name, e] : s.relative_error) errors.push_back(e);
    for (const auto& [name, c] : s.covered) covered.add(c);
  }
  if (right.trials == 0) return;
  fmt::print("{:<10} {:>5} right {}", to_string(family),
             ratio < 0.0 ? "all" : fmt::format("{:g}", ratio), right.text());
  if (family == CaseFamily::clean) fmt::print("   false alarms {}", detected.text());
  if (family == CaseFamily::decoy) fmt::print("   refused by name {}", refused.text());
  if (family == CaseFamily::outside)
    fmt::print("   unnamed {}   place {}", unnamed.text(), where.text());
  if (family == CaseFamily::single || family == CaseFamily::pair ||
      family == CaseFamily::ambiguous) {
    fmt::print(
        "   detected {}   name first {}   in set {} (mean size {:.2f})   place {}   f1 {:.2f}",
        detected.text(), named.text(), in_set.text(), diagnose::mean(sizes), where.text(),
        diagnose::mean(f1));
    if (!errors.empty())
      fmt::print("   parameter error, median {:.1f} %, covered {}", 100 * diagnose::median(errors),
                 covered.text());
  }
  fmt::print("\n");
}

void print_table(const std::vector<Outcome>& all) {
  for (const CaseFamily family : {CaseFamily::clean, CaseFamily::decoy, CaseFamily::single,
                                  CaseFamily::pair, CaseFamily::outside, CaseFamily::ambiguous}) {
    print_row(all, family, -1.0);
    for (const double ratio : {0.3, 1.0, 3.0, 10.0, 30.0}) print_row(all, family, ratio);
  }
}

/// Exactly the true effects and nothing else; for a clean case nothing.
bool exact(const Names& named, const std::vector<std::string>& truth) {
  return std::set<std::string>(named.begin(), named.end()) ==
         std::set<std::string>(truth.begin(), truth.end());
}

void print_baselines(const std::vector<Outcome>& all) {
  fmt::print("\nexactly the true effects named, at ratio 3 and more\n{:<20} {:<34} {:<34} {:<34}\n",
             "", "clean: nothing", "single", "pair");
  const auto row = [&](const std::string& method,
                       const std::function<Names(const Outcome&)>& names) {
    std::map<CaseFamily, Count> counts;
    for (const Outcome& o : all) {
      if (o.score.family != CaseFamily::clean && o.score.ratio < 3.0) continue;
      counts[o.score.family].add(exact(names(o), o.score.truth));
    }
    fmt::print("{:<20} {:<34} {:<34} {:<34}\n", method, counts[CaseFamily::clean].text(),
               counts[CaseFamily::single].text(), counts[CaseFamily::pair].text());
  };
  row("diagnose", [](const Outcome& o) { return o.score.named; });
  for (const char* method :
       {"largest score", "fit everything", "sparse regression", "friction ladder"}) {
    row(method, [method](const Outcome& o) {
      return o.baselines.contains(method) ? o.baselines.at(method) : Names{};
    });
  }
}

/// Of floating bases: the share of a balance's error beyond what a nominal model may be wrong by,
/// on recordings held out.
void print_explained_whole(const std::vector<Outcome>& all) {
  std::vector<double> of_truth;
  for (const Outcome& o : all) {
    if (!o.network.ran && o.explained_by_truth > 0.0)
      of_truth.push_back(o.explained / o.explained_by_truth);
  }
  if (of_truth.empty()) return;
  fmt::print(
      "\nexplained on recordings held out (ratio 3 and more), of what the true effects explain: "
      "median {:.3f}, mean {:.3f} over {} cases\n",
      diagnose::median(of_truth), diagnose::mean(of_truth), of_truth.size());
}

/// The share of the error beyond noise that is explained 0.5 s ahead on recordings held out,
/// against a residual network.
void print_explained(const std::vector<Outcome>& all) {
  fmt::print(
      "\nexplained on recordings held out, 0.5 s ahead, median (ratio 3 and more)\n{:<10} {:>5} "
      "{:>10} {:>17}   {}\n",
      "", "cases", "diagnose", "residual network", "network says mismatch");
  for (const CaseFamily family : {CaseFamily::clean, CaseFamily::single, CaseFamily::pair,
                                  CaseFamily::outside, CaseFamily::ambiguous}) {
    std::vector<double> diagnosed, network, of_truth;
    Count says;
    for (const Outcome& o : all) {
      const bool counts =
          o.score.family == family && (o.score.family == CaseFamily::clean || o.score.ratio >= 3.0);
      if (!counts || !o.proved || !o.network.ran) continue;
      diagnosed.push_back(o.explained), network.push_back(o.network.explained),
          says.add(o.network.mismatch);
      if (o.explained_by_truth > 0.0) of_truth.push_back(o.explained / o.explained_by_truth);
    }
    if (diagnosed.empty()) continue;
    fmt::print("{:<10} {:>5} {:>8.1f} % {:>15.1f} %   {}", to_string(family), diagnosed.size(),
               100 * diagnose::median(diagnosed), 100 * diagnose::median(network), says.text());
    if (!of_truth.empty()) {
      fmt::print("   of what the true structure explains: median {:.3f} over {} cases",
                 diagnose::median(of_truth), of_truth.size());
    }
    fmt::print("\n");
  }
}

/// A twin of one of the true effects.
bool names_twin(const std::string& name, const std::vector<std::string>& truth) {
  return std::any_of(truth.begin(), truth.end(),
                     [&](const std::string& id) { return diagnose::documented_twin(name, id); });
}

void print_left_out(const std::vector<Outcome>& all) {
  Count right;
  for (const Outcome& o : all) {
    if (!o.without_status || o.score.ratio < 10.0) continue;
    const bool twins =
        !o.without_named.empty() &&
        std::all_of(o.without_named.begin(), o.without_named.end(),
                    [&](const std::string& n) { return names_twin(n, o.score.truth); });
    right.add(o.without_status == diagnose::VerdictStatus::present_unnamed || twins);
    fmt::print("  without {}: {} {}\n", joined(o.score.truth), to_string(*o.without_status),
               joined(o.without_named));
  }
  fmt::print("left out of the library, ratio 10 and more: unnamed or a documented twin {}\n",
             right.text());
}

void print_confusions(const std::vector<Outcome>& all) {
  std::map<std::string, int> pairs;
  for (const Outcome& o : all) {
    if (!o.score.right)
      ++pairs[joined(o.score.truth) + " -> " + o.score.status + ": " + joined(o.score.named)];
  }
  fmt::print("\nconfusions (truth -> said)\n");
  for (const auto& [pair, count] : pairs) fmt::print("  {} x {}\n", count, pair);
  fmt::print("failures, by seed\n");
  for (const Outcome& o : all) {
    if (o.score.right) continue;
    fmt::print("  seed {}: {} ratio {:g}: {} -> {} {}\n", o.seed, to_string(o.score.family),
               o.score.ratio, joined(o.score.truth), o.score.status, joined(o.score.named));
  }
}

/// From ratio 3 on, and where there is nothing to name.
void print_confirmed(const std::vector<Outcome>& all) {
  int wrong = 0, confirmed = 0;
  for (const Outcome& o : all) {
    const bool nothing_there =
        o.score.family == CaseFamily::clean || o.score.family == CaseFamily::decoy;
    if (!nothing_there && o.score.ratio < 3.0) continue;
    wrong += o.score.wrong_confirmed, confirmed += o.score.confirmed;
  }
  fmt::print("\nCONFIRMED and not there, at ratio 3 and more: {} of {}\n", wrong, confirmed);
}

void print_times(const std::vector<Outcome>& all) {
  std::vector<double> seconds(all.size());
  std::transform(all.begin(), all.end(), seconds.begin(),
                 [](const Outcome& o) { return o.seconds; });
  if (seconds.empty()) return;
  fmt::print("time of a diagnosis: median {:.1f}, 90 % {:.1f}, 99 % {:.1f}, largest {:.1f} s\n",
             diagnose::median(seconds), diagnose::quantile(seconds, 0.9),
             diagnose::quantile(seconds, 0.99), diagnose::quantile(seconds, 1.0));
}

}  // namespace

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& n : names) text += (text.empty() ? "" : " + ") + n;
  return text.empty() ? "nothing" : text;
}

void print_scores(const std::vector<Outcome>& all, bool left_out) {
  print_table(all);
  print_confirmed(all);
  print_baselines(all);
  print_explained(all);
  print_explained_whole(all);
  print_confusions(all);
  if (left_out) print_left_out(all);
  print_times(all);
}

}  // namespace sanso::bench
