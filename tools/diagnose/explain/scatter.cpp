#include "tools/diagnose/explain/scatter.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/stats/robust.h"

namespace sanso::diagnose {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// The stretches in which rows follow each other: [from, from + rows) of one channel of one
/// recording's shot.
struct Piece {
  Index from, rows;
  std::size_t channel, shot;
};
std::vector<Piece> pieces_of(const Problem& problem) {
  std::vector<Piece> out;
  for (std::size_t s = 0; s < problem.shots.size(); ++s) {
    const Shot& shot = problem.shots[s];
    for (std::size_t c = 0; c < problem.channels.size(); ++c) {
      out.push_back(
          {static_cast<Index>(shot.offset + c * shot.rows), static_cast<Index>(shot.rows), c, s});
    }
  }
  return out;
}

/// Scatter that draws of an effect make: variances by entry, of the rough part and of everything.
struct Expected {
  VectorXd rough, whole;
};
Expected scatter_of(const Surroundings& around, const Model& model, int candidate, double size,
                    int draws, Random random) {
  const Problem& problem = *around.problem;
  Model with = model;
  std::vector<double> theta =
      around.library->candidates[static_cast<std::size_t>(candidate)].probes.front();
  theta.front() = size;
  with.effects.push_back({candidate, std::move(theta)});
  std::vector<std::uint64_t> seeds;
  for (int m = 0; m < draws; ++m) seeds.push_back(random.bits() | 1U);
  std::vector<VectorXd> rough(seeds.size()), whole(seeds.size());
  parallel_for(draws, [&](int m) {
    const auto k = static_cast<std::size_t>(m);
    const VectorXd r = drawn_prediction_error(problem, *around.library, with, seeds[k]);
    rough[k] = rough_part(problem, r);
    whole[k] = around.starts.project(r);
  });
  const auto variance = [draws](const std::vector<VectorXd>& all) {
    VectorXd sum = VectorXd::Zero(all.front().size()), square = sum;
    for (const VectorXd& x : all) sum += x, square += x.cwiseAbs2();
    return VectorXd((square - sum.cwiseAbs2() / draws).cwiseMax(0.0) / (draws - 1.0));
  };
  return {variance(rough), variance(whole)};
}

/// No single row decides: a jump of the command that is simulated a fraction of a millisecond off
/// makes a large error where nearly every effect scatters most. Caps at a share of the channel's
/// rows from above.
VectorXd capped(const Problem& problem, const std::vector<Piece>& pieces, const VectorXd& x) {
  VectorXd out = x;
  for (std::size_t c = 0; c < problem.channels.size(); ++c) {
    std::vector<double> values;
    for (const Piece& p : pieces) {
      if (p.channel == c)
        values.insert(values.end(), x.data() + p.from, x.data() + p.from + p.rows);
    }
    const double cap = quantile(values, 1.0 - problem.settings.chance.capped_share);
    for (const Piece& p : pieces) {
      if (p.channel == c) out.segment(p.from, p.rows) = out.segment(p.from, p.rows).cwiseMin(cap);
    }
  }
  return out;
}

/// Mean of a channel's entries, by channel.
std::vector<double> means(const Problem& problem, const std::vector<Piece>& pieces,
                          const VectorXd& x) {
  std::vector<double> sum(problem.channels.size(), 0.0), count(problem.channels.size(), 0.0);
  for (const Piece& p : pieces) {
    sum[p.channel] += x.segment(p.from, p.rows).sum();
    count[p.channel] += static_cast<double>(p.rows);
  }
  for (std::size_t c = 0; c < sum.size(); ++c) sum[c] /= std::max(count[c], 1.0);
  return sum;
}

/// Sum over channels of the covariance between squared error and expected scatter, each channel in
/// units of its own mean square, over its deviation for independent normal errors.
double score_of(const Problem& problem, const std::vector<Piece>& pieces, const VectorXd& squares,
                const VectorXd& expected) {
  const std::vector<double> square = means(problem, pieces, squares),
                            scatter = means(problem, pieces, expected);
  double covariance = 0.0, variance = 0.0;
  for (const Piece& p : pieces) {
    const double mean = square[p.channel];
    if (!(mean > 0.0)) continue;
    const auto v = expected.segment(p.from, p.rows).array() - scatter[p.channel];
    // a channel counts by its precision: scatter of a noisy channel says little
    covariance += (v * (squares.segment(p.from, p.rows).array() / mean - 1.0)).sum() / mean;
    variance += 2.0 * v.square().sum() / (mean * mean);
  }
  return variance > 0.0 ? covariance / std::sqrt(variance) : 0.0;
}

/// Errors against time, shifted: every recording's rows of a channel by the same number, around its
/// end.
VectorXd shifted(const Problem& problem, const std::vector<Piece>& pieces, const VectorXd& x,
                 Random& random) {
  VectorXd out = x;
  std::size_t from = 0;
  while (from < pieces.size()) {
    const int source = problem.shots[pieces[from].shot].source;
    std::size_t until = from;
    while (until < pieces.size() && problem.shots[pieces[until].shot].source == source) ++until;
    const double share = random.uniform();
    for (std::size_t c = 0; c < problem.channels.size(); ++c) {
      std::vector<Index> at;
      for (std::size_t i = from; i < until; ++i) {
        if (pieces[i].channel != c) continue;
        for (Index k = 0; k < pieces[i].rows; ++k) at.push_back(pieces[i].from + k);
      }
      const auto by = static_cast<std::size_t>(share * static_cast<double>(at.size()));
      for (std::size_t k = 0; k < at.size(); ++k) out[at[k]] = x[at[(k + by) % at.size()]];
    }
    from = until;
  }
  return out;
}

/// Errors that the fitted model's own readings would have: noise, and the quantisation of the
/// predicted value.
VectorXd simulated_error(const Problem& problem, const VectorXd& r, Random& random) {
  VectorXd out(r.size());
  for (const Shot& shot : problem.shots) {
    const Source& source = problem.sources[static_cast<std::size_t>(shot.source)];
    for (std::size_t c = 0; c < problem.channels.size(); ++c) {
      const Observed& channel = problem.channels[c];
      const double step = channel.quantum;
      const double noise =
          std::sqrt(std::max(0.0, channel.noise * channel.noise - step * step / 12.0));
      for (std::size_t k = 0; k < shot.rows; ++k) {
        const auto at = static_cast<Index>(shot.offset + c * shot.rows + k);
        const std::size_t row = shot.window.first + (k + 1) * static_cast<std::size_t>(shot.stride);
        const double reading = measured(source, channel, row);
        if (!std::isfinite(reading)) {
          out[at] = 0.0;
          continue;
        }
        const double predicted = reading - channel.sigma * r[at];
        double drawn = predicted + noise * random.normal();
        if (step > 0.0) drawn = step * std::round(drawn / step);
        out[at] = (drawn - predicted) / channel.sigma;
      }
    }
  }
  return out;
}

/// Share of `size`'s scatter that the squared errors hold: weighted regression on [1, expected] by
/// channel, pooled.
struct Share {
  std::vector<double> covariance, variance;  // by shot
};
Share shares(const Problem& problem, const std::vector<Piece>& pieces, const VectorXd& squares,
             const VectorXd& expected, int draws) {
  const std::vector<double> square = means(problem, pieces, squares),
                            scatter = means(problem, pieces, expected);
  Share out{std::vector<double>(problem.shots.size(), 0.0),
            std::vector<double>(problem.shots.size(), 0.0)};
  for (const Piece& p : pieces) {
    const double mean = square[p.channel];
    if (!(mean > 0.0)) continue;
    const auto v = expected.segment(p.from, p.rows).array() - scatter[p.channel];
    out.covariance[p.shot] +=
        (v * (squares.segment(p.from, p.rows).array() - mean)).sum() / (mean * mean);
    // squares of a variance from few draws are too large by (draws + 1) / (draws - 1)
    const double centre = scatter[p.channel], honest = (draws - 1.0) / (draws + 1.0);
    out.variance[p.shot] += (honest * expected.segment(p.from, p.rows).squaredNorm() -
                             static_cast<double>(p.rows) * centre * centre) /
                            (mean * mean);
  }
  return out;
}

double ratio(const Share& s, const std::vector<std::size_t>& shots) {
  double covariance = 0.0, variance = 0.0;
  for (const std::size_t i : shots) covariance += s.covariance[i], variance += s.variance[i];
  return variance > 0.0 ? covariance / variance : 0.0;
}

/// The size at which the expected scatter is what is seen, by interpolation between the tried sizes
/// (in logarithms):
/// the share falls from above 1 to below 1 as the size grows.
double size_at_unit_share(const std::vector<double>& sizes, const std::vector<double>& share) {
  // variance ~ size^2
  if (share.front() <= 1.0) return sizes.front() * std::sqrt(std::max(0.0, share.front()));
  for (std::size_t i = 1; i < sizes.size(); ++i) {
    if (share[i] > 1.0) continue;
    const double low = std::log(share[i - 1]), high = std::log(std::max(share[i], 1e-3));
    const double t = low / std::max(low - high, 1e-9);
    return sizes[i - 1] * std::pow(sizes[i] / sizes[i - 1], t);
  }
  return sizes.back();
}

/// What a candidate is measured on: the search's shots and fit, or the same begun and fitted anew.
struct Ground {
  std::shared_ptr<Problem> own_problem;
  std::shared_ptr<Surroundings> own_around;
  const Surroundings* around = nullptr;
  const FitResult* final = nullptr;
  std::shared_ptr<FitResult> own_final = nullptr;
};

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
        std::count_if(all.begin(), all.end(), [](const Candidate& c) { return c.random; });
    draws_ =
        std::clamp(chance().all_draws / static_cast<int>(std::max<std::ptrdiff_t>(1, random_ones)),
                   chance().least_draws, chance().draws);
  }

  std::vector<ScatterScore> all() {
    const std::vector<Candidate>& candidates = around_.library->candidates;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      if (!candidates[i].random || final_.model.has(static_cast<int>(i))) continue;
      ScatterScore s;
      s.candidate = static_cast<int>(i);
      expected_.push_back(scatter_of(around_, final_.model, s.candidate,
                                     candidates[i].probes.front().front(), draws_,
                                     Random(random_.bits(), i)));
      expected_.back().rough = capped(*around_.problem, pieces_, expected_.back().rough);
      s.score = score_of(*around_.problem, pieces_, squares_, expected_.back().rough);
      scores_.push_back(std::move(s));
    }
    if (scores_.empty()) return {};
    family_wise();
    for (ScatterScore& s : scores_) {
      if (s.p_family < around_.settings().decisions.family_wise) measure(s);
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
      out = std::max(out, score_of(*around_.problem, pieces_, squares, e.rough));
    return out;
  }

  std::vector<double> maxima(int draws, const std::function<VectorXd(Random&)>& draw) {
    std::vector<double> out(static_cast<std::size_t>(draws));
    const std::uint64_t key = random_.bits();
    parallel_for(draws, [&](int i) {
      Random own(key, static_cast<std::uint64_t>(i));
      out[static_cast<std::size_t>(i)] = largest(draw(own));
    });
    return out;
  }

  void family_wise() {
    const Problem& problem = *around_.problem;
    const std::vector<double> shifts =
        maxima(around_.settings().decisions.null_draws,
               [&](Random& r) { return shifted(problem, pieces_, squares_, r); });
    const std::vector<double> readings = maxima(chance().parametric_draws, [&](Random& r) {
      return capped(problem, pieces_,
                    rough_part(problem, simulated_error(problem, final_.r, r)).cwiseAbs2());
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
    std::vector<Share> share;
    double size_of(const std::vector<std::size_t>& shots) const {
      std::vector<double> all;
      for (const Share& one : share) all.push_back(ratio(one, shots));
      return size_at_unit_share(sizes, all);
    }
  };
  Sized sized(const Ground& ground, int candidate, int draws, std::uint64_t key) const {
    const double largest = candidate_of(candidate).parameters.front().high;
    const VectorXd squares = rough_part(*ground.around->problem, ground.final->r).cwiseAbs2();
    Sized out;
    const int sizes = chance().sizes;
    for (int i = 0; i < sizes; ++i) {
      out.sizes.push_back(largest *
                          std::pow(12.0, static_cast<double>(i - sizes + 1) / (sizes - 1)));
      const Expected e = scatter_of(*ground.around, ground.final->model, candidate,
                                    out.sizes.back(), draws, Random(key));
      out.share.push_back(shares(*ground.around->problem, pieces_, squares, e.rough, draws));
    }
    return out;
  }
  const Candidate& candidate_of(int i) const {
    return around_.library->candidates[static_cast<std::size_t>(i)];
  }

  /// The same shots, from where they begin when a candidate of that size says how well readings are
  /// known.
  Ground ground_with(int candidate, double size) const {
    Model model = final_.model;
    model.effects.push_back({candidate, candidate_of(candidate).probes.front()});
    model.effects.back().theta.front() = size;
    const std::vector<double> jitter = jitter_of(*around_.problem, *around_.library, model);
    if (jitter == jitter_of(*around_.problem, *around_.library, final_.model))
      return {nullptr, nullptr, &around_, &final_};
    Ground out;
    out.own_problem = std::make_shared<Problem>(*around_.problem);
    resmooth(*out.own_problem, jitter);
    out.own_around = std::make_shared<Surroundings>(Surroundings{
        out.own_problem.get(), around_.library,
        StartElimination(*out.own_problem, *around_.library, final_.model), around_.A});
    const VectorXd r = prediction_error(*out.own_problem, *around_.library, final_.model);
    out.own_around->set_shot_scale(out.own_around->starts.energy_by_shot(r));
    out.own_final =
        std::make_shared<FitResult>(fit(*out.own_around, final_.model, chance().steps_anew));
    out.around = out.own_around.get();
    out.final = out.own_final.get();
    return out;
  }

  /// Size, interval and expected energy of a candidate that stands out. A few draws first: most
  /// that stand out are a systematic error that scatters too, and leave far more than noise.
  void measure(ScatterScore& s) {
    const double largest = candidate_of(s.candidate).parameters.front().high;
    const std::uint64_t key = random_.bits();
    if (scatter_of(around_, final_.model, s.candidate, largest, chance().least_draws, Random(key))
            .whole.sum() < least_energy_)
      return;
    std::vector<std::size_t> shots(around_.problem->shots.size());
    for (std::size_t i = 0; i < shots.size(); ++i) shots[i] = i;
    Ground ground{nullptr, nullptr, &around_, &final_};
    const auto expect = [&](const Sized& tried, int draws) {
      s.size = tried.size_of(shots);
      s.beyond = ratio(tried.share.back(), shots) > chance().beyond;
      if (ground.own_problem == nullptr) ground = ground_with(s.candidate, s.size);
      s.expected =
          scatter_of(*ground.around, final_.model, s.candidate, s.size, draws, Random(key)).whole;
      s.energy = s.expected.sum();
      s.left = position_error_level(*ground.around, ground.final->r, s.expected);
    };
    expect(sized(ground, s.candidate, chance().least_draws, key), chance().least_draws);
    if (s.left > chance().margin * around_.settings().decisions.adequate) return;
    const Sized tried = sized(ground, s.candidate, 2 * draws_, key);
    expect(tried, draws_);
    std::vector<double> resampled;
    for (int b = 0; b < around_.settings().decisions.bootstrap; ++b) {
      std::vector<std::size_t> drawn = shots;
      for (std::size_t& i : drawn)
        i = static_cast<std::size_t>(random_.below(static_cast<int>(shots.size())));
      resampled.push_back(tried.size_of(drawn));
    }
    s.low = quantile(resampled, 0.025);
    s.high = quantile(resampled, 0.975);
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

std::vector<double> jitter_of(const Problem& problem, const Library& library, const Model& model) {
  SimParams params = problem.sources.front().nominal;
  library.apply(model, params);
  std::vector<double> out;
  for (const JointParams& joint : params.joints) out.push_back(joint.jitter);
  return out;
}

VectorXd rough_part(const Problem& problem, const VectorXd& x) {
  VectorXd out = VectorXd::Zero(x.size());
  for (const Piece& p : pieces_of(problem)) {
    if (p.rows < 3) continue;
    const Index inner = p.rows - 2;
    out.segment(p.from + 1, inner) =
        x.segment(p.from + 1, inner) -
        0.5 * (x.segment(p.from, inner) + x.segment(p.from + 2, inner));
  }
  return out;
}

std::vector<ScatterScore> judge_scatter(const Surroundings& around, const FitResult& final,
                                        double least_energy, Random random) {
  return Judge(around, final, least_energy, random).all();
}

}  // namespace sanso::diagnose
