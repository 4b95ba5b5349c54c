// Matched filter: z = s' M r / |s|_M of every candidate's signature s, what is known projected out.
// The null law of the largest |z|: normal draws with the signatures' correlation (step-down max-T).
#include "tools/diagnose/fit/screen.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/fit/probe_sums.h"
#include "tools/diagnose/stats/robust.h"
#include "tools/diagnose/stats/significance.h"

namespace sanso::diagnose {
namespace {

/// [nuisances | signatures | error], single precision: thousands of signatures of a robot with many
/// joints fill gigabytes. A signature is the change of the prediction error for a full probe.
Eigen::MatrixXf columns_of(const Surroundings& around, const Eigen::MatrixXd& known,
                           const Model& model, const Eigen::VectorXd& r,
                           const std::vector<ProbeScore>& probes) {
  const Eigen::Index nuisances = known.cols(), count = static_cast<Eigen::Index>(probes.size());
  Eigen::MatrixXf columns(r.size(), nuisances + count + 1);
  columns.leftCols(nuisances) = known.cast<float>();
  columns.rightCols(1) = r.cast<float>();
  const Remembered remembered(around.problem, *around.library, model);
  parallel_for(probes.size(), [&](std::size_t i) {
    const ProbeScore& probe = probes[i];
    const Candidate& candidate = (*around.library)[probe.candidate];
    Model with = model;
    with.effects.push_back({probe.candidate, candidate.probes[probe.probe]});
    columns.col(nuisances + i) = (prediction_error_near(around.problem, *around.library, with, r,
                                                        candidate.joints, {}, &remembered) -
                                  r)
                                     .cast<float>();
  });
  return columns;
}

/// Nuisances of a linearised model inside their tolerances: argmin |r + A d|^2_M + prior |x + d|^2
/// with x + d in its box, by coordinate descent. `free`: those not at an end of their box.
struct BoxedNuisances {
  Eigen::VectorXd d;
  std::vector<Eigen::Index> free;
};
BoxedNuisances boxed_nuisances(const Surroundings& around, const Eigen::MatrixXd& gram,
                               const Model& model, Eigen::Index known) {
  const Library& library = *around.library;
  const double reach = around.settings().tolerances.reach;
  const auto n = static_cast<Eigen::Index>(library.nuisances.size());
  const Eigen::Index last = gram.cols() - 1;
  BoxedNuisances out{Eigen::VectorXd::Zero(n), {}};
  Eigen::VectorXd x = Eigen::VectorXd::Zero(n);
  for (std::size_t i = 0; i < model.nuisance.size(); ++i) {
    x[i] = model.nuisance[i] / library.nuisances[i].tolerance;
  }
  const int sweeps = around.settings().fitting.nuisance_sweeps;
  constexpr double kEdge = 1e-6;
  const double prior = around.settings().tolerances.precision;
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    for (Eigen::Index i = 0; i < n; ++i) {
      const double gradient =
          gram(i, last) + gram.row(i).head(n).dot(out.d) + prior * (x[i] + out.d[i]);
      const double moved = x[i] + out.d[i] - gradient / (gram(i, i) + prior);
      out.d[i] = std::clamp(moved, -reach, reach) - x[i];
    }
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    const double at = x[i] + out.d[i];
    if (std::abs(at) < reach - kEdge) out.free.push_back(i);
  }
  out.d.conservativeResizeLike(Eigen::VectorXd::Zero(known));
  for (Eigen::Index i = n; i < known; ++i) out.free.push_back(i);  // parameters of accepted effects
  return out;
}

/// Inner products after eliminating the nuisances that are free to move within their prior: Schur
/// complement. A nuisance at the end of its tolerance explains no more, so that an effect of the
/// same shape keeps its signature.
struct Eliminated {
  Eigen::MatrixXd G;  // probes x probes
  Eigen::VectorXd b;  // probes: s' M r
};
Eliminated eliminate(const Eigen::MatrixXd& gram, const BoxedNuisances& at, Eigen::Index nuisances,
                     Eigen::Index probes, double precision) {
  const auto n = static_cast<Eigen::Index>(at.free.size());
  Eigen::MatrixXd H(n, n), cross(n, probes);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Index row = at.free[i];
    for (Eigen::Index j = 0; j < n; ++j)
      H(i, j) = gram(row, at.free[j]) + (i == j ? precision : 0.0);
    cross.row(i) = gram.block(row, nuisances, 1, probes);
  }
  // the free nuisances are at their optimum: they contribute no gradient of their own
  const auto S = gram.block(nuisances, 0, probes, nuisances);
  return {
      gram.block(nuisances, nuisances, probes, probes) - cross.transpose() * H.ldlt().solve(cross),
      gram.block(nuisances, nuisances + probes, probes, 1) + S * at.d};
}

/// Every shot's entries times its weight.
Eigen::VectorXd by_shot(const Comparison& comparison, const Eigen::VectorXd& weights,
                        Eigen::VectorXd r) {
  for (std::size_t s = 0; s < comparison.shots.size(); ++s) {
    rows_of(r, comparison.shots[s], 0, comparison.channels.size()) *= weights[s];
  }
  return r;
}

/// Overdispersion after the strongest few signatures are taken out, one after the other (orthogonal
/// matching pursuit): the error level of a model large enough, as in ordinary regression.
class Pursuit {
 public:
  /// `known`: nuisances, and what else is no choice. `wanted`: 1 for the entries of the channels
  /// that the model has to be large enough for, else 0.
  Pursuit(const Surroundings& around, const Eigen::MatrixXd& known, const Eigen::MatrixXf& columns,
          const Eigen::VectorXd& weights, const Eigen::VectorXd& wanted)
      : around_(around),
        columns_(columns),
        weights_(weights),
        wanted_(wanted),
        nuisances_(known.cols()),
        count_(columns.cols() - known.cols() - 1),
        taken_(known),
        r_(columns.rightCols(1).cast<double>()) {}

  std::vector<double> overdispersion() {
    std::vector<double> energy(static_cast<std::size_t>(count_)), score(energy.size());
    parallel_for(energy.size(), [&](std::size_t c) {
      const Eigen::VectorXd one = signature(static_cast<Eigen::Index>(c)).cwiseProduct(wanted_);
      energy[c] = around_.starts.energy_by_shot(one).dot(weights_);
    });
    std::vector<std::ptrdiff_t> chosen;
    const int pursuit = around_.settings().fitting.pursuit;
    for (int round = 0;; ++round) {
      const Eigen::VectorXd left = left_by_taken();
      if (round == pursuit || count_ == 0) return diagnose::overdispersion(*around_.problem, left);
      const Eigen::VectorXd weighted =
          by_shot(*around_.problem, weights_, left).cwiseProduct(wanted_);
      parallel_for(energy.size(), [&](std::size_t c) {
        const double b = signature(static_cast<Eigen::Index>(c)).dot(weighted);
        score[c] = b * b / std::max(energy[c], 1e-12);
      });
      const auto best = std::max_element(score.begin(), score.end()) - score.begin();
      if (std::find(chosen.begin(), chosen.end(), best) != chosen.end())
        return diagnose::overdispersion(*around_.problem, left);
      chosen.push_back(best);
      taken_.conservativeResize(Eigen::NoChange, taken_.cols() + 1);
      taken_.rightCols(1) = signature(best);
    }
  }

 private:
  Eigen::VectorXd signature(Eigen::Index c) const {
    return columns_.col(nuisances_ + c).cast<double>();
  }
  /// M times what the nuisances and the signatures taken out so far leave.
  Eigen::VectorXd left_by_taken() const {
    Eigen::MatrixXd both(r_.size(), taken_.cols() + 1);
    both << taken_, r_;
    const Eigen::Index n = taken_.cols();
    const Eigen::MatrixXd gram =
        wanted_.minCoeff() > 0.0 ? around_.starts.gram(both, weights_) : gram_of_wanted(both);
    Eigen::MatrixXd H = gram.topLeftCorner(n, n);
    for (Eigen::Index i = 0; i < n; ++i)
      H(i, i) += i < nuisances_ ? around_.settings().tolerances.precision : 1e-9 * (1.0 + H(i, i));
    return around_.starts.project(r_ - taken_ * H.ldlt().solve(gram.topRightCorner(n, 1)));
  }
  /// Inner products of what the starts leave of the columns, over the entries that are wanted.
  Eigen::MatrixXd gram_of_wanted(Eigen::MatrixXd columns) const {
    const Eigen::VectorXd root = weights_.cwiseSqrt();
    parallel_for(static_cast<std::size_t>(columns.cols()), [&](std::size_t k) {
      auto column = columns.col(static_cast<Eigen::Index>(k));
      column = by_shot(*around_.problem, root, around_.starts.project(column))
                   .cwiseProduct(wanted_)
                   .eval();
    });
    return columns.transpose() * columns;
  }

  const Surroundings& around_;
  const Eigen::MatrixXf& columns_;
  const Eigen::VectorXd &weights_, &wanted_;
  Eigen::Index nuisances_, count_;
  Eigen::MatrixXd taken_;
  Eigen::VectorXd r_;
};

/// Error levels of models large enough for the positions, and for all channels: the lower one of
/// every channel. Efforts are many and loud in units of their floors; where they alone choose what
/// is taken out, positions keep an error that names could remove, and count for little from then
/// on.
std::vector<double> saturated_overdispersion(const Surroundings& around,
                                             const Eigen::MatrixXd& known,
                                             const Eigen::MatrixXf& columns,
                                             const Eigen::VectorXd& weights) {
  const Comparison& comparison = *around.problem;
  Eigen::VectorXd all = Eigen::VectorXd::Ones(columns.rows()), positions = all;
  for (const Shot& shot : comparison.shots) {
    for (std::size_t c = 0; c < comparison.channels.size(); ++c)
      if (comparison.channels[c].signal != Signal::q) rows_of(positions, shot, c).setZero();
  }
  std::vector<double> out, alone;
  parallel_for(positions == all ? 1 : 2, [&](std::size_t i) {
    (i == 0 ? out : alone) =
        Pursuit(around, known, columns, weights, i == 0 ? all : positions).overdispersion();
  });
  if (alone.empty()) return out;
  for (std::size_t c = 0; c < out.size(); ++c) out[c] = std::min(out[c], alone[c]);
  return out;
}

/// Signatures told in `from` (by channel), told in `to`.
Eigen::MatrixXf rescaled(const Comparison& comparison, Eigen::MatrixXf columns, const Scales& from,
                         const Scales& to) {
  for (const Shot& shot : comparison.shots) {
    for (std::size_t c = 0; c < comparison.channels.size(); ++c)
      block_of(columns, shot, c) *= static_cast<float>(from.sigma[c] / to.sigma[c]);
  }
  return columns;
}

/// Square root: draws with this covariance are root * standard normals. Cholesky is much faster
/// than eigenvalues for thousands of probes; signatures that are alike make the matrix singular, so
/// a hundred-thousandth of independent noise on each keeps the factor real and moves no draw
/// visibly. Where rounding spoils even that, eigenvalues.
Eigen::MatrixXd square_root(const Eigen::MatrixXd& correlation) {
  Eigen::MatrixXd regular = correlation;
  regular.diagonal().array() += 1e-5;
  const Eigen::LLT<Eigen::MatrixXd> cholesky(regular);
  if (cholesky.info() == Eigen::Success) return cholesky.matrixL();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(correlation);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

/// The screening with p over all of its probes, and what their maximum exceeds by chance.
Screening with_family_wise(const DecisionSettings& settings, Screening out,
                           const std::vector<char>& one_sided_probe, const Random& random) {
  const auto k = static_cast<Eigen::Index>(out.probes.size());
  const Eigen::MatrixXd root = square_root(out.correlation);
  Random generator = random;
  Eigen::MatrixXd normals(k, settings.null_draws);
  for (Eigen::Index c = 0; c < normals.cols(); ++c) {
    for (Eigen::Index i = 0; i < k; ++i) normals(i, c) = generator.normal();
  }
  Eigen::MatrixXd draws = root * normals;
  std::vector<double> statistic(out.probes.size()), maxima;
  for (std::size_t i = 0; i < out.probes.size(); ++i) {
    statistic[i] = out.probes[i].score;
    // what cannot be seen cannot be mistaken for something either
    if (out.probes[i].signature == 0.0) draws.row(i).setZero();
    if (one_sided_probe[i] == 0) draws.row(i) = draws.row(i).cwiseAbs();
  }
  const std::vector<double> p =
      step_down_max_t(statistic, settings.null_draws, [&](int b, std::span<double> draw) {
        for (Eigen::Index i = 0; i < k; ++i) draw[i] = draws(i, b);
      });
  for (std::size_t i = 0; i < p.size(); ++i) out.probes[i].p_family = p[i];
  for (Eigen::Index b = 0; b < draws.cols(); ++b) maxima.push_back(draws.col(b).maxCoeff());
  out.critical = quantile(maxima, 1.0 - settings.family_wise);
  return out;
}

/// Every probe of the candidates; of those screened earlier two of each.
std::vector<ProbeScore> probes_of(const Library& library, const std::vector<std::size_t>& which,
                                  const Screening* earlier) {
  std::vector<ProbeScore> out;
  for (const std::size_t candidate : which) {
    const std::vector<std::size_t> again =
        earlier != nullptr ? earlier->two_probes(candidate) : std::vector<std::size_t>{};
    for (std::size_t p = 0; p < library[candidate].probes.size(); ++p) {
      if (earlier != nullptr && std::find(again.begin(), again.end(), p) == again.end()) continue;
      out.push_back({candidate, p});
    }
  }
  return out;
}

/// The screening with scores and correlations from what is left of the inner products. `energy`: of
/// the signatures before the nuisances took their share.
Screening scored(const Eliminated& e, const Eigen::VectorXd& energy,
                 const std::vector<char>& signed_probe, Screening out) {
  const Eigen::Index count = energy.size();
  out.correlation.resize(count, count);
  // a signature below rounding says nothing
  const auto says_something = [&](Eigen::Index i) {
    constexpr double kRounding = 1e-10;
    return e.G(i, i) > std::max(1e-12, kRounding * energy[i]);
  };
  for (Eigen::Index i = 0; i < count; ++i) {
    ProbeScore& probe = out.probes[i];
    const double norm = says_something(i) ? std::sqrt(e.G(i, i)) : 0.0;
    probe.signature = norm;
    if (norm > 0.0) probe.z = -e.b[i] / norm, probe.amount = -e.b[i] / (norm * norm);
    probe.score = signed_probe[i] != 0 ? std::max(probe.z, 0.0) : std::abs(probe.z);
    for (Eigen::Index j = 0; j < count; ++j) {
      const double scale = std::sqrt(e.G(i, i) * e.G(j, j));
      out.correlation(i, j) = i == j                                   ? 1.0
                              : says_something(i) && says_something(j) ? e.G(i, j) / scale
                                                                       : 0.0;
    }
  }
  return out;
}

}  // namespace

Screening screen(const Surroundings& around, const Model& model, const Eigen::VectorXd& r,
                 const std::vector<std::size_t>& which, Random random, const Screening* earlier,
                 const Eigen::MatrixXd& accepted, bool keep_groups) {
  Eigen::MatrixXd known(r.size(), around.A.cols() + accepted.cols());
  known.leftCols(around.A.cols()) = around.A;
  if (accepted.cols() > 0) known.rightCols(accepted.cols()) = accepted;
  Screening out;
  out.probes = probes_of(*around.library, which, earlier);
  std::vector<char> signed_probe;
  for (const ProbeScore& probe : out.probes)
    signed_probe.push_back(!(*around.library)[probe.candidate].two_sided);
  const auto count = static_cast<Eigen::Index>(out.probes.size());
  Eigen::MatrixXf columns = columns_of(around, known, model, r, out.probes);
  // a shot that runs away (a joint that sticks at its start in one world and not in the other) does
  // not decide alone
  const Eigen::VectorXd weights = around.weights(around.starts.energy_by_shot(r));
  out.scales =
      overdispersed(around.problem, saturated_overdispersion(around, known, columns, weights));
  columns = rescaled(*around.problem, std::move(columns), around.problem.scales, out.scales);
  if (count == 0) {  // every candidate is in the model already
    out.critical = INFINITY;
    return out;
  }
  std::vector<Eigen::MatrixXd> groups = around.starts.gram_by_group(columns, weights);
  Eigen::MatrixXd gram = groups.front();
  for (std::size_t g = 1; g < groups.size(); ++g) gram += groups[g];
  if (keep_groups) out.by_group = std::move(groups), out.known = known.cols();
  const Eliminated e = eliminate(gram, boxed_nuisances(around, gram, model, known.cols()),
                                 known.cols(), count, around.settings().tolerances.precision);
  out = scored(e, gram.diagonal().segment(known.cols(), count), signed_probe, std::move(out));
  out = with_sums(around.settings().decisions, *around.library, std::move(out));
  return with_family_wise(around.settings().decisions, std::move(out), signed_probe, random);
}

double Screening::mean_square() const {
  double square = 0.0;
  for (const ProbeScore& p : probes) square += p.z * p.z;
  return probes.empty() ? 1.0 : square / static_cast<double>(probes.size());
}

std::vector<std::size_t> Screening::ranking() const {
  std::vector<std::pair<double, std::size_t>> order;
  for (const ProbeScore& p : probes) {
    if (best(p.candidate) == &p) order.emplace_back(p.together, p.candidate);
  }
  std::stable_sort(order.begin(), order.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<std::size_t> out;
  out.reserve(order.size());
  for (const auto& [score, candidate] : order) out.push_back(candidate);
  return out;
}

const ProbeScore* Screening::best(std::size_t candidate) const {
  const ProbeScore* found = nullptr;
  for (const ProbeScore& p : probes) {
    if (p.candidate == candidate && (found == nullptr || p.score > found->score)) found = &p;
  }
  return found;
}

std::vector<std::size_t> Screening::two_probes(std::size_t candidate) const {
  const ProbeScore* strongest = best(candidate);
  if (strongest == nullptr) return {};
  const ProbeScore* different = strongest;
  double least = 2.0;
  for (const ProbeScore& p : probes) {
    if (p.candidate != candidate) continue;
    const double alike = std::abs(correlation(&p - probes.data(), strongest - probes.data()));
    if (alike < least) least = alike, different = &p;
  }
  return {strongest->probe, different->probe};
}

double Screening::similarity(std::size_t a, std::size_t b) const {
  const ProbeScore *pa = best(a), *pb = best(b);
  if (pa == nullptr || pb == nullptr) return 0.0;
  return std::abs(correlation(pa - probes.data(), pb - probes.data()));
}

}  // namespace sanso::diagnose
