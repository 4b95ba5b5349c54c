// Forward by the largest gain; every step has to predict other recordings and other parts of the
// motion.
#include "tools/diagnose/wholebody/drive_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <set>

#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/stats/random.h"
#include "tools/diagnose/stats/significance.h"
#include "tools/diagnose/wholebody/drive_numbers.h"
#include "tools/diagnose/wholebody/drive_way.h"

namespace sanso::diagnose {
namespace {

class Chooser {
 public:
  Chooser(const Asking& asking, const DriveRows& rows)
      : asking_(asking),
        rows_(rows),
        terms_(drive_terms(asking, rows)),
        nuisances_(drive_nuisances(asking, rows)) {}

  DriveChoice run() {
    const auto most = static_cast<std::size_t>(asking_.stance.maximum_terms);
    Eigen::VectorXd figures = Eigen::VectorXd::Zero(rows_.columns.count());
    for (int round = 0; round < asking_.stance.rounds; ++round) {
      weigh(figures);
      figures = all_->fit(taken_).figures;
      weigh(figures);
      const Terms before = taken_;
      taken_.clear();
      while (taken_.size() < most && forward()) {
      }
      backward();
      figures = all_->fit(taken_).figures;
      if (taken_ == before && round > 0) break;
    }
    return judged();
  }

 private:
  void weigh(const Eigen::VectorXd& figures) {
    groups_ = weighed(rows_, figures, asking_.settings.imu_outlier, asking_.stance);
    all_ = std::make_unique<Eliminated>(groups_.all, nuisances_);
    ways_.clear();
    const auto parts = asking_.settings.parts_of_groups();
    for (const std::vector<Normal>& groups : groups_.by) {
      Way way{&groups, {}};
      for (std::size_t part = 0; part < parts; ++part) {
        Normal fitted(rows_.columns.count());
        for (std::size_t g = 0; g < groups.size(); ++g)
          if (g % parts != part) fitted.add(groups[g]);
        way.fitted.push_back(std::make_unique<Eliminated>(fitted, nuisances_));
      }
      ways_.push_back(std::move(way));
    }
  }

  Gain gain(const Terms& less, const Terms& more) const {
    return gain_in(ways_, less, more, asking_,
                   [](const Way& way, const Terms& terms) { return way.left_out(terms, true); });
  }
  /// The same for a model that is patched with the terms alone.
  Gain gain_of_names(const Terms& less, const Terms& more) const {
    return gain_in(ways_, less, more, asking_,
                   [](const Way& way, const Terms& terms) { return way.left_by_named(terms); });
  }

  /// Without it a figure of the nominal model has to be further off than it may, and with it no
  /// longer.
  bool relieves(const Terms& less, const Terms& more) const {
    const Eliminated::Fit without = all_->fit(less), with = all_->fit(more);
    return without.farthest > asking_.stance.strained &&
           with.strains[without.which] <= asking_.stance.strained;
  }

  /// Beyond chance. A nuisance that may say what the name says (a delay of all goals) takes it up
  /// at the price of its strain, which is little beside what noise scatters: there a model that is
  /// patched with the name alone has to predict better.
  bool proven(const Terms& less, const Terms& more, const Gain& g) const {
    return g.low > 0.0 ||
           (g.share > 0.0 && relieves(less, more) && gain_of_names(less, more).low > 0.0);
  }

  bool open(const DriveTerm& t) const {
    return std::none_of(taken_.begin(), taken_.end(), [&](const DriveTerm* other) {
      const bool links = t.family == Family::mass && other->family == Family::mass;
      return other->where == t.where && (other->effect == t.effect || links);
    });
  }

  /// No limit stops a coefficient, and what is missing is beyond its tolerance.
  bool plausible(const Terms& terms, const DriveTerm& t) const {
    const Eliminated::Fit fit = all_->fit(terms);
    Eigen::Index at = 0;
    for (const DriveTerm* other : terms) {
      if (other == &t) break;
      at += other->size();
    }
    double size = 0.0;
    for (Eigen::Index i = 0; i < t.size(); ++i) {
      const double x = fit.x[at + i];
      const bool nothing = t.low[static_cast<std::size_t>(i)] == 0.0 && x <= 0.0;
      const double low = t.low[static_cast<std::size_t>(i)],
                   high = t.high[static_cast<std::size_t>(i)];
      if (nothing || x >= high || (low < 0.0 && x <= low)) return false;
      size = t.carried && i > 0 ? size : std::hypot(size, x);
    }
    return size > t.tolerance;
  }

  std::vector<const DriveTerm*> by_gain() const {
    const double before = all_->fit(taken_).gain;
    std::vector<double> gains(terms_.size(), 0.0);
    parallel_for(terms_.size(), [&](std::size_t i) {
      if (open(terms_[i])) gains[i] = all_->fit(plus(taken_, &terms_[i])).gain - before;
    });
    std::vector<std::size_t> order(terms_.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return gains[a] > gains[b]; });
    std::vector<const DriveTerm*> out;
    for (const std::size_t i : order) {
      if (!(gains[i] > 0.0) || out.size() >= static_cast<std::size_t>(asking_.decisions.rivals))
        break;
      if (plausible(plus(taken_, &terms_[i]), terms_[i])) out.push_back(&terms_[i]);
    }
    return out;
  }

  /// A small share counts where it relieves a figure of the nominal model.
  bool pays(const Terms& less, const Terms& more) const {
    const Gain g = gain(less, more);
    if (!proven(less, more, g)) return false;
    return g.share >= asking_.decisions.minimum_share || relieves(less, more);
  }

  /// Whether every kind of row scatters by no more than was known beforehand, by a robot that is no
  /// further off than a nominal model may be.
  bool adequate(const Terms& terms, double strained) const {
    const Eliminated::Fit fit = all_->fit(terms);
    const std::vector<double> left =
        left_by_channel(rows_, fit.figures, asking_.settings.imu_outlier);
    return fit.farthest <= strained &&
           std::all_of(left.begin(), left.end(), [](double rms) { return rms <= 1.0; });
  }

  /// A name with fewer numbers says the same with less where it predicts as well, or leaves
  /// nothing that would be looked for.
  bool does_as_well(const DriveTerm* simpler, const DriveTerm* chosen) const {
    const Terms with = plus(taken_, simpler);
    if (simpler->size() >= chosen->size() || !pays(taken_, with)) return false;
    return adequate(with, asking_.stance.strained) || gain(with, plus(taken_, chosen)).low <= 0.0;
  }

  bool forward() {
    if (adequate(taken_, asking_.stance.strained)) return false;
    const std::vector<const DriveTerm*> best = by_gain();
    for (std::size_t i = 0; i < best.size(); ++i) {
      if (!pays(taken_, plus(taken_, best[i]))) continue;
      const DriveTerm* chosen = best[i];
      for (std::size_t k = i + 1; k < best.size(); ++k)
        if (does_as_well(best[k], chosen)) chosen = best[k];
      const Gain g = gain(taken_, plus(taken_, chosen));
      taken_.push_back(chosen);
      log_.push_back(fmt::format("+ {}: {:.1f} % of what is left [{:.1f}]; {}", in_words(*chosen),
                                 100 * g.share, 100 * g.low, left_in_words()));
      return true;
    }
    return false;
  }

  void backward() {
    for (std::size_t i = 0; i < taken_.size();) {
      const DriveTerm* t = taken_[i];
      const Terms less = without(taken_, t);
      if (proven(less, taken_, gain(less, taken_)) && plausible(taken_, *t)) {
        ++i;
        continue;
      }
      log_.push_back("- " + in_words(*t));
      taken_.erase(taken_.begin() + static_cast<std::ptrdiff_t>(i)), i = 0;
    }
  }

  /// Coefficients when whole groups are drawn anew, the way that scatters more.
  Eigen::VectorXd deviations(const Eigen::VectorXd& x) const {
    Eigen::VectorXd out = Eigen::VectorXd::Zero(x.size());
    const int draws = asking_.decisions.bootstrap;
    for (const Way& way : ways_) {
      const std::size_t n = way.groups->size();
      std::vector<Eigen::VectorXd> squares(static_cast<std::size_t>(draws));
      parallel_for(static_cast<std::size_t>(draws), [&](std::size_t d) {
        Random random(asking_.seed, 1000 + d);
        std::vector<double> times(n, 0.0);
        for (std::size_t k = 0; k < n; ++k) times[random.below(n)] += 1.0;
        Normal drawn(rows_.columns.count());
        for (std::size_t g = 0; g < times.size(); ++g)
          if (times[g] > 0.0) drawn.add((*way.groups)[g], times[g]);
        squares[d] = (Eliminated(drawn, nuisances_).fit(taken_).x - x).cwiseAbs2();
      });
      Eigen::VectorXd mean = Eigen::VectorXd::Zero(x.size());
      for (const Eigen::VectorXd& s : squares) mean += s / draws;
      out =
          out.cwiseMax((mean * static_cast<double>(n) / std::max(1.0, static_cast<double>(n) - 1.0))
                           .cwiseSqrt());
    }
    return out.cwiseMax(all_->deviations(taken_));
  }

  std::string left_in_words() const {
    const Eliminated::Fit fit = all_->fit(taken_);
    std::string left;
    for (const double x : left_by_channel(rows_, fit.figures, asking_.settings.imu_outlier))
      left += fmt::format(" {:.2f}", x);
    const auto which = static_cast<std::size_t>(fit.which);
    return fmt::format("left in deviations:{}; farthest off: {}, {:.1f} tolerances", left,
                       fit.which < 0 ? "nothing" : nuisances_.names[which], fit.farthest);
  }

  DriveChoice judged() {
    DriveChoice out;
    std::vector<JudgedDriveTerm> terms = judged_terms();
    for (std::size_t i = 0; (i = least_sure(terms)) < terms.size(); terms = judged_terms()) {
      out.spare.push_back(terms[i]);
      log_.push_back("- " + in_words(*taken_[i]) + ": not surely there, and not needed");
      taken_.erase(taken_.begin() + static_cast<std::ptrdiff_t>(i));
    }
    out.terms = std::move(terms);
    out.adequate = adequate(taken_, asking_.stance.torn);
    const Eliminated::Fit fit = all_->fit(taken_);
    out.figures = fit.figures, out.named = fit.named, out.farthest = fit.farthest;
    out.eased = 1.0 - fit.strained / std::max(all_->fit({}).strained, 1e-300);
    log_.push_back(left_in_words());
    out.log = log_;
    const double rows = static_cast<double>(rows_.channel.size());
    const Way& way = ways_.front();
    out.before = std::sqrt(sum(way.left_by_named({})) / rows);
    out.after = std::sqrt(sum(way.left_by_named(taken_)) / rows);
    out.least = std::sqrt(sum(way.left_out(taken_, false)) / rows);
    return out;
  }

  std::vector<JudgedDriveTerm> judged_terms() const {
    std::vector<JudgedDriveTerm> out;
    const Eliminated::Fit fit = all_->fit(taken_);
    const Eigen::VectorXd sigma = deviations(fit.x);
    Eigen::Index at = 0;
    for (const DriveTerm* t : taken_) {
      const Eigen::VectorXd x = fit.x.segment(at, t->size()), s = sigma.segment(at, t->size());
      at += t->size();
      JudgedDriveTerm j = with_numbers(*t, x, s);
      const Gain g = gain(without(taken_, t), taken_);
      j.share = g.share, j.share_low = g.low;
      std::set<std::string> names;
      for (const DriveTerm* other : others_for(*t)) {
        j.rivals.push_back(*other);
        if (other->effect == t->effect)
          j.other_places.push_back(in_words(*other));
        else
          names.insert(other->effect);
      }
      if (const auto twin = twin_of(*t, j)) names.insert(name_of(*twin));
      j.equally_good.assign(names.begin(), names.end());
      out.push_back(std::move(j));
    }
    return out;
  }

  /// Place of the term that is least surely there, of those that need not be; else past the last.
  std::size_t least_sure(const std::vector<JudgedDriveTerm>& terms) const {
    std::size_t out = terms.size();
    for (std::size_t i = 0; i < terms.size(); ++i) {
      if (surely_there(asking_, terms[i]) ||
          !adequate(without(taken_, taken_[i]), asking_.stance.torn))
        continue;
      const auto beyond = [&](std::size_t k) { return terms[k].size - terms[k].term.tolerance; };
      if (out == terms.size() || beyond(i) * terms[out].sigma < beyond(out) * terms[i].sigma)
        out = i;
    }
    return out;
  }

  /// With these a figure of the nominal model is still off by what has no name, and with what was
  /// taken none is off by what would be looked for.
  bool leaves_more(const Terms& other) const {
    return all_->fit(taken_).farthest <= asking_.stance.strained &&
           all_->fit(other).farthest > asking_.stance.torn;
  }

  /// What takes the place of t and is not beyond chance worse, and does most of what t does.
  Terms others_for(const DriveTerm& t) const {
    const Terms rest = without(taken_, &t);
    const double all = all_->fit(taken_).gain, none = all_->fit(rest).gain;
    std::vector<char> found(terms_.size(), 0);
    parallel_for(terms_.size(), [&](std::size_t i) {
      const DriveTerm& r = terms_[i];
      if (&r == &t || r.size() > t.size() ||
          std::find(taken_.begin(), taken_.end(), &r) != taken_.end())
        return;
      const Terms other = plus(rest, &r);
      const double does = all_->fit(other).gain - none;
      if (does < asking_.decisions.stand_in_share * (all - none) || !plausible(other, r)) return;
      // what a nominal model would have to be off by counts as well as what left-out rows say
      const double sure = asking_.chance().deviations();
      if (all - none - does > asking_.stance.surely_worse * sure * sure || leaves_more(other))
        return;
      found[i] = gain(other, taken_).low <= 0.0 ? 1 : 0;
    });
    Terms out;
    for (std::size_t i = 0; i < found.size(); ++i)
      if (found[i]) out.push_back(&terms_[i]);
    return out;
  }

  const Asking& asking_;
  const DriveRows& rows_;
  std::vector<DriveTerm> terms_;
  DriveNuisances nuisances_;
  DriveGroups groups_;
  std::unique_ptr<Eliminated> all_;
  std::vector<Way> ways_;
  Terms taken_;
  std::vector<std::string> log_;
};

}  // namespace

DriveChoice choose_drive_terms(const Asking& asking, const DriveRows& rows) {
  return Chooser(asking, rows).run();
}

bool surely_there(const Asking& asking, const JudgedDriveTerm& term) {
  return term.size > term.term.tolerance + asking.chance().deviations() * term.sigma;
}

std::string in_words(const DriveTerm& term) {
  std::string places;
  for (const std::string& w : term.where) places += (places.empty() ? "" : ", ") + w;
  return term.effect + " at " + places;
}

}  // namespace sanso::diagnose
