// Random effects by the scatter that they make. For each candidate, draws of the effect give the
// variance v of every row; what is left of the error is asked for a share A of it (scatter_rows.h),
// and p counts how often the largest score of all candidates is as large under either null law
// (null_errors.h). Size is where A = 1.
#include "tools/diagnose/explain/scatter.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>

#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/explain/null_errors.h"
#include "tools/diagnose/explain/scatter_rows.h"
#include "tools/diagnose/stats/robust.h"

namespace sanso::diagnose {
namespace {

using Eigen::VectorXd;

/// Scatter that draws of an effect make: variances by entry, of the rough part and of everything.
struct Expected {
  VectorXd rough, whole;
};
Expected scatter_of(const Surroundings& around, const Model& model, std::size_t candidate,
                    double size, int draws, Random random) {
  const Problem& problem = around.problem;
  Model with = model;
  std::vector<double> theta = (*around.library)[candidate].probes.front();
  theta.front() = size;
  with.effects.push_back({candidate, std::move(theta)});
  std::vector<std::uint64_t> seeds;
  seeds.reserve(static_cast<std::size_t>(draws));
  for (int m = 0; m < draws; ++m) seeds.push_back(random.bits() | 1U);
  std::vector<VectorXd> rough(seeds.size()), whole(seeds.size());
  parallel_for(draws, [&](std::size_t m) {
    const VectorXd r = drawn_prediction_error(problem, *around.library, with, seeds[m]);
    rough[m] = rough_part(*problem, r);
    whole[m] = around.starts.project(r);
  });
  return {variance_of(rough), variance_of(whole)};
}

/// The search's shots, begun and fitted anew.
struct Anew {
  Surroundings around;
  FitResult final;
};

/// Every joint scatters for itself; what is lost at all of them at once is found one by one.
bool scatters(const Candidate& c) { return c.random && c.joints.size() < 2; }

class Judge {
 public:
  Judge(const Surroundings& around, const FitResult& final, double least_energy, Random random)
      : around_(around),
        final_(final),
        least_energy_(least_energy),
        random_(random),
        pieces_(pieces_of(*around.problem)),
        rough_(rough_part(*around.problem, final.r)),
        squares_(capped(*around.problem, pieces_, rough_.cwiseAbs2())) {
    const std::vector<Candidate>& all = around.library->candidates;
    const auto random_ones =
        std::count_if(all.begin(), all.end(), [](const Candidate& c) { return scatters(c); });
    draws_ =
        std::clamp(chance().all_draws / static_cast<int>(std::max<std::ptrdiff_t>(1, random_ones)),
                   chance().least_draws, chance().draws);
  }

  std::vector<ScatterScore> all() {
    const std::vector<Candidate>& candidates = around_.library->candidates;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      if (!scatters(candidates[i]) || final_.model.has(i)) continue;
      ScatterScore s;
      s.candidate = i;
      expected_.push_back(scatter_of(around_, final_.model, s.candidate,
                                     candidates[i].probes.front().front(), draws_,
                                     Random(random_.bits(), i)));
      expected_.back().rough = capped(*around_.problem, pieces_, expected_.back().rough);
      s.score = scatter_score(*around_.problem, pieces_, squares_, expected_.back().rough);
      scores_.push_back(std::move(s));
    }
    if (scores_.empty()) return {};
    family_wise();
    for (ScatterScore& s : scores_) {
      if (s.p_family < around_.settings().decisions.family_wise) s = measured(std::move(s));
    }
    std::stable_sort(
        scores_.begin(), scores_.end(),
        [](const ScatterScore& a, const ScatterScore& b) { return a.score > b.score; });
    return std::move(scores_);
  }

 private:
  const ChanceSettings& chance() const { return around_.settings().chance; }
  /// The largest score of one draw of the error.
  double largest(const VectorXd& squares) const {
    double out = -INFINITY;
    for (const Expected& e : expected_)
      out = std::max(out, scatter_score(*around_.problem, pieces_, squares, e.rough));
    return out;
  }

  std::vector<double> maxima(int draws, const std::function<VectorXd(Random&)>& draw) {
    std::vector<double> out(draws);
    const std::uint64_t key = random_.bits();
    parallel_for(draws, [&](std::size_t i) {
      Random own(key, static_cast<std::uint64_t>(i));
      out[i] = largest(draw(own));
    });
    return out;
  }

  void family_wise() {
    const Problem& problem = around_.problem;
    const std::vector<double> shifts =
        maxima(around_.settings().decisions.null_draws,
               [&](Random& r) { return shifted(*problem, pieces_, squares_, r); });
    const std::vector<double> readings = maxima(chance().parametric_draws, [&](Random& r) {
      return capped(*problem, pieces_,
                    rough_part(*problem, simulated_error(problem, final_.r, r)).cwiseAbs2());
    });
    const auto p = [](const std::vector<double>& null, double score) {
      const auto above =
          std::count_if(null.begin(), null.end(), [score](double x) { return x >= score; });
      return (static_cast<double>(above) + 1.0) / (static_cast<double>(null.size()) + 1.0);
    };
    for (ScatterScore& s : scores_) s.p_family = std::max(p(shifts, s.score), p(readings, s.score));
  }

  /// Expected scatter as shares of what is seen, by size.
  struct Sized {
    std::vector<double> sizes;
    std::vector<ScatterShare> share;
    double size_of(const std::vector<std::size_t>& shots) const {
      std::vector<double> all;
      for (const ScatterShare& one : share) all.push_back(one.over(shots));
      return size_at_unit_share(sizes, all);
    }
  };
  Sized sized(const Surroundings& around, const FitResult& final, std::size_t candidate, int draws,
              std::uint64_t key) const {
    const double largest = candidate_of(candidate).parameters.front().high;
    const VectorXd squares = rough_part(*around.problem, final.r).cwiseAbs2();
    Sized out;
    const int sizes = chance().sizes;
    for (int i = 0; i < sizes; ++i) {
      out.sizes.push_back(
          largest * std::pow(chance().smallest, static_cast<double>(i - sizes + 1) / (sizes - 1)));
      const Expected e =
          scatter_of(around, final.model, candidate, out.sizes.back(), draws, Random(key));
      out.share.push_back(scatter_share(*around.problem, pieces_, squares, e.rough, draws));
    }
    return out;
  }
  const Candidate& candidate_of(std::size_t i) const { return (*around_.library)[i]; }

  /// The same shots, from where they begin when a candidate of that size says how well readings are
  /// known; empty: where they begin already.
  std::optional<Anew> anew_with(std::size_t candidate, double size) const {
    Model model = final_.model;
    model.effects.push_back({candidate, candidate_of(candidate).probes.front()});
    model.effects.back().theta.front() = size;
    const std::vector<double> jitter = jitter_of(*around_.problem, *around_.library, model);
    if (jitter == jitter_of(*around_.problem, *around_.library, final_.model)) return std::nullopt;
    const Problem problem = resmoothed(around_.problem, jitter);
    Surroundings around{problem, around_.library,
                        StartElimination(problem, *around_.library, final_.model), around_.A};
    const VectorXd r = prediction_error(problem, *around_.library, final_.model);
    around.set_shot_scale(around.starts.energy_by_shot(r));
    FitResult fitted = fit(around, final_.model, chance().steps_anew);
    return Anew{std::move(around), std::move(fitted)};
  }

  /// `s` with size, interval and expected energy of a candidate that stands out. A few draws first:
  /// most that stand out are a systematic error that scatters too, and leave far more than noise.
  ScatterScore measured(ScatterScore s) {
    const double largest = candidate_of(s.candidate).parameters.front().high;
    const std::uint64_t key = random_.bits();
    if (scatter_of(around_, final_.model, s.candidate, largest, chance().least_draws, Random(key))
            .whole.sum() < least_energy_)
      return s;
    std::vector<std::size_t> shots(around_.problem->shots.size());
    for (std::size_t i = 0; i < shots.size(); ++i) shots[i] = i;
    std::optional<Anew> anew;
    const auto around = [&]() -> const Surroundings& { return anew ? anew->around : around_; };
    const auto final = [&]() -> const FitResult& { return anew ? anew->final : final_; };
    const auto expect = [&](const Sized& tried, int draws) {
      s.size = tried.size_of(shots);
      s.beyond = tried.share.back().over(shots) > chance().beyond;
      if (!anew) anew = anew_with(s.candidate, s.size);
      s.expected =
          scatter_of(around(), final_.model, s.candidate, s.size, draws, Random(key)).whole;
      s.energy = s.expected.sum();
      s.left = position_error_level(around(), final().r, s.expected);
    };
    expect(sized(around(), final(), s.candidate, chance().least_draws, key), chance().least_draws);
    if (s.left > chance().margin * around_.settings().decisions.adequate) return s;
    const Sized tried = sized(around(), final(), s.candidate, 2 * draws_, key);
    expect(tried, draws_);
    std::vector<double> resampled;
    for (int b = 0; b < around_.settings().decisions.bootstrap; ++b) {
      std::vector<std::size_t> drawn = shots;
      for (std::size_t& i : drawn) i = random_.below(shots.size());
      resampled.push_back(tried.size_of(drawn));
    }
    s.low = quantile(resampled, 0.025);
    s.high = quantile(resampled, 0.975);
    return s;
  }

  const Surroundings& around_;
  const FitResult& final_;
  double least_energy_;
  Random random_;
  int draws_ = 0;
  std::vector<Piece> pieces_;
  VectorXd rough_, squares_;  // squares_: capped
  std::vector<Expected> expected_;
  std::vector<ScatterScore> scores_;
};

}  // namespace

std::vector<double> jitter_of(const Comparison& comparison, const Library& library,
                              const Model& model) {
  SimParams params = comparison.sources.front().nominal;
  library.apply(model, params);
  std::vector<double> out;
  for (const JointParams& joint : params.joints) out.push_back(joint.jitter);
  return out;
}

std::vector<ScatterScore> judge_scatter(const Surroundings& around, const FitResult& final,
                                        double least_energy, Random random) {
  return Judge(around, final, least_energy, random).all();
}

}  // namespace sanso::diagnose
