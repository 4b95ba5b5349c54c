#include "tools/diagnose/search/screen.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "tools/diagnose/constants.h"
#include "tools/diagnose/search/parallel.h"
#include "tools/diagnose/stats/robust.h"
#include "tools/diagnose/stats/significance.h"

namespace sanso::diagnose {
namespace {

/// Signatures: change of the prediction error for a full probe.
Eigen::MatrixXd signatures(const Surroundings& around, const Model& model, const Eigen::VectorXd& r,
                           const std::vector<ProbeScore>& probes) {
  Eigen::MatrixXd S(r.size(), static_cast<Eigen::Index>(probes.size()));
  parallel_for(static_cast<int>(probes.size()), [&](int i) {
    const ProbeScore& probe = probes[static_cast<std::size_t>(i)];
    Model with = model;
    with.effects.push_back({probe.candidate, around.library->candidates[static_cast<std::size_t>(probe.candidate)]
                                                 .probes[static_cast<std::size_t>(probe.probe)]});
    const std::vector<int>& joints = around.library->candidates[static_cast<std::size_t>(probe.candidate)].joints;
    S.col(i) = prediction_error_near(*around.problem, *around.library, with, r, joints) - r;
  });
  return S;
}

/// Nuisances of a linearised model inside their tolerances: argmin |r + A d|^2_M + prior |x + d|^2 with x + d in its
/// box, by coordinate descent. `free`: those not at an end of their box.
struct BoxedNuisances {
  Eigen::VectorXd d;
  std::vector<Eigen::Index> free;
};
BoxedNuisances boxed_nuisances(const Eigen::MatrixXd& gram, const Library& library, const Model& model) {
  const auto n = static_cast<Eigen::Index>(library.nuisances.size());
  const Eigen::Index last = gram.cols() - 1;
  BoxedNuisances out{Eigen::VectorXd::Zero(n), {}};
  Eigen::VectorXd x = Eigen::VectorXd::Zero(n);
  for (std::size_t i = 0; i < model.nuisance.size(); ++i) {
    x[static_cast<Eigen::Index>(i)] = model.nuisance[i] / library.nuisances[i].tolerance;
  }
  constexpr int kSweeps = 300;  // far more than these few, weakly coupled coordinates need
  constexpr double kEdge = 1e-6;
  const double prior = constants::kTolerancePrecision;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (Eigen::Index i = 0; i < n; ++i) {
      const double gradient = gram(i, last) + gram.row(i).head(n).dot(out.d) + prior * (x[i] + out.d[i]);
      const double moved = x[i] + out.d[i] - gradient / (gram(i, i) + prior);
      out.d[i] = std::clamp(moved, -constants::kToleranceReach, constants::kToleranceReach) - x[i];
    }
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    const double at = x[i] + out.d[i];
    if (std::abs(at) < constants::kToleranceReach - kEdge) out.free.push_back(i);
  }
  return out;
}

/// Inner products after eliminating the nuisances that are free to move within their prior: Schur complement. A
/// nuisance at the end of its tolerance explains no more, so that an effect of the same shape keeps its signature.
struct Eliminated {
  Eigen::MatrixXd G;  // probes x probes
  Eigen::VectorXd b;  // probes: s' M r
};
Eliminated eliminate(const Eigen::MatrixXd& gram, const BoxedNuisances& at, Eigen::Index nuisances,
                     Eigen::Index probes) {
  const auto n = static_cast<Eigen::Index>(at.free.size());
  Eigen::MatrixXd H(n, n), cross(n, probes);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Index row = at.free[static_cast<std::size_t>(i)];
    for (Eigen::Index j = 0; j < n; ++j)
      H(i, j) = gram(row, at.free[static_cast<std::size_t>(j)]) + (i == j ? constants::kTolerancePrecision : 0.0);
    cross.row(i) = gram.block(row, nuisances, 1, probes);
  }
  // the free nuisances are at their optimum: they contribute no gradient of their own
  const auto S = gram.block(nuisances, 0, probes, nuisances);
  return {gram.block(nuisances, nuisances, probes, probes) - cross.transpose() * H.ldlt().solve(cross),
          gram.block(nuisances, nuisances + probes, probes, 1) + S * at.d};
}

/// Overdispersion after the strongest few signatures are taken out, one after the other (orthogonal matching pursuit):
/// the error level of a model large enough, as in ordinary regression.
std::vector<double> saturated_overdispersion(const Surroundings& around, const Eigen::MatrixXd& S,
                                             const Eigen::VectorXd& r, const Eigen::MatrixXd& gram) {
  const Eigen::Index a = around.A.cols(), k = S.cols();
  std::vector<Eigen::Index> chosen;
  Eigen::VectorXd coefficients;
  constexpr int kPursuit = 5;
  for (int round = 0; round <= kPursuit; ++round) {
    const auto m = static_cast<Eigen::Index>(chosen.size());
    Eigen::MatrixXd H(a + m, a + m);
    Eigen::VectorXd g(a + m);
    const auto index = [&](Eigen::Index i) { return i < a ? i : a + chosen[static_cast<std::size_t>(i - a)]; };
    for (Eigen::Index i = 0; i < a + m; ++i) {
      for (Eigen::Index j = 0; j < a + m; ++j) H(i, j) = gram(index(i), index(j));
      H(i, i) += i < a ? constants::kTolerancePrecision : 1e-9 * (1.0 + H(i, i));
      g[i] = gram(index(i), a + k);
    }
    coefficients = -H.ldlt().solve(g);
    if (round == kPursuit) break;
    Eigen::Index best = -1;
    double strongest = 0.0;
    for (Eigen::Index c = 0; c < k; ++c) {
      double b = gram(a + c, a + k);
      for (Eigen::Index i = 0; i < a + m; ++i) b += gram(a + c, index(i)) * coefficients[i];
      const double score = b * b / std::max(gram(a + c, a + c), 1e-12);
      if (score > strongest) strongest = score, best = c;
    }
    if (best < 0 || std::find(chosen.begin(), chosen.end(), best) != chosen.end()) break;
    chosen.push_back(best);
  }
  Eigen::VectorXd left = r + around.A * coefficients.head(a);
  for (std::size_t i = 0; i < chosen.size() && a + static_cast<Eigen::Index>(i) < coefficients.size(); ++i) {
    left += S.col(chosen[i]) * coefficients[a + static_cast<Eigen::Index>(i)];
  }
  return overdispersion(*around.problem, around.starts.project(left));
}

/// Divides every channel's rows by the square root of its overdispersion; the scale never falls below the channel's
/// floor.
void rescale(const Problem& problem, const std::vector<double>& phi, Eigen::MatrixXd& columns,
             std::vector<double>& sigma) {
  for (std::size_t c = 0; c < problem.channels.size(); ++c) {
    const Observed& channel = problem.channels[c];
    sigma.push_back(std::max(channel.floor, channel.sigma * std::sqrt(phi[c])));
    for (const Shot& shot : problem.shots) {
      columns.middleRows(static_cast<Eigen::Index>(shot.offset + c * shot.rows),
                         static_cast<Eigen::Index>(shot.rows)) *= channel.sigma / sigma.back();
    }
  }
}

/// Symmetric square root by eigenvalues: draws with this covariance are root * standard normals, also when it is
/// singular.
Eigen::MatrixXd square_root(const Eigen::MatrixXd& correlation) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(correlation);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

void family_wise(Screening& out, const std::vector<char>& one_sided_probe, const Random& random) {
  const auto k = static_cast<Eigen::Index>(out.probes.size());
  const Eigen::MatrixXd root = square_root(out.correlation);
  Random generator = random;
  Eigen::MatrixXd normals(k, constants::kNullDraws);
  for (Eigen::Index c = 0; c < normals.cols(); ++c) {
    for (Eigen::Index i = 0; i < k; ++i) normals(i, c) = generator.normal();
  }
  Eigen::MatrixXd draws = root * normals;
  std::vector<double> statistic(out.probes.size()), maxima;
  for (std::size_t i = 0; i < out.probes.size(); ++i) {
    statistic[i] = out.probes[i].score;
    if (one_sided_probe[i] == 0)
      draws.row(static_cast<Eigen::Index>(i)) = draws.row(static_cast<Eigen::Index>(i)).cwiseAbs();
  }
  const std::vector<double> p = step_down_max_t(statistic, constants::kNullDraws, [&](int b, std::span<double> draw) {
    for (Eigen::Index i = 0; i < k; ++i) draw[static_cast<std::size_t>(i)] = draws(i, b);
  });
  for (std::size_t i = 0; i < p.size(); ++i) out.probes[i].p_family = p[i];
  for (Eigen::Index b = 0; b < draws.cols(); ++b) maxima.push_back(draws.col(b).maxCoeff());
  out.critical = quantile(maxima, 1.0 - constants::kFamilyWise);
}

}  // namespace

Screening screen(const Surroundings& around, const Model& model, const Eigen::VectorXd& r,
                 const std::vector<int>& which, Random random, const Screening* earlier) {
  Screening out;
  std::vector<char> signed_probe;
  for (int candidate : which) {
    const Candidate& c = around.library->candidates[static_cast<std::size_t>(candidate)];
    const std::vector<int> again = earlier != nullptr ? earlier->two_probes(candidate) : std::vector<int>{};
    for (std::size_t p = 0; p < c.probes.size(); ++p) {
      if (earlier != nullptr && std::find(again.begin(), again.end(), static_cast<int>(p)) == again.end()) continue;
      out.probes.push_back({candidate, static_cast<int>(p)});
      signed_probe.push_back(!c.two_sided);
    }
  }
  const Eigen::MatrixXd S = signatures(around, model, r, out.probes);
  Eigen::MatrixXd all(r.size(), around.A.cols() + S.cols() + 1);
  all << around.A, S, r;
  // a shot that runs away (a joint that sticks at its start in one world and not in the other) does not decide alone
  const Eigen::VectorXd weights = around.weights(around.starts.energy_by_shot(r));
  const std::vector<double> phi = saturated_overdispersion(around, S, r, around.starts.gram(all, weights));
  rescale(*around.problem, phi, all, out.channel_sigma);
  const Eigen::MatrixXd gram = around.starts.gram(all, weights);
  const Eliminated e = eliminate(gram, boxed_nuisances(gram, *around.library, model), around.A.cols(), S.cols());
  out.correlation.resize(S.cols(), S.cols());
  for (Eigen::Index i = 0; i < S.cols(); ++i) {
    ProbeScore& probe = out.probes[static_cast<std::size_t>(i)];
    const double norm = std::sqrt(std::max(e.G(i, i), 0.0));
    probe.signature = norm;
    // a signature below rounding says nothing
    if (norm > 1e-6) probe.z = -e.b[i] / norm, probe.amount = -e.b[i] / (norm * norm);
    probe.score = signed_probe[static_cast<std::size_t>(i)] != 0 ? std::max(probe.z, 0.0) : std::abs(probe.z);
    for (Eigen::Index j = 0; j < S.cols(); ++j) {
      const double scale = std::sqrt(std::max(e.G(i, i), 0.0) * std::max(e.G(j, j), 0.0));
      out.correlation(i, j) = i == j ? 1.0 : scale > 1e-12 ? e.G(i, j) / scale : 0.0;
    }
  }
  family_wise(out, signed_probe, random);
  return out;
}

double Screening::mean_square() const {
  double square = 0.0;
  for (const ProbeScore& p : probes) square += p.z * p.z;
  return probes.empty() ? 1.0 : square / static_cast<double>(probes.size());
}

std::vector<int> Screening::ranking() const {
  std::vector<std::pair<double, int>> order;
  for (const ProbeScore& p : probes) {
    if (best(p.candidate) == &p) order.emplace_back(p.score, p.candidate);
  }
  std::stable_sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<int> out;
  for (const auto& [score, candidate] : order) out.push_back(candidate);
  return out;
}

const ProbeScore* Screening::best(int candidate) const {
  const ProbeScore* found = nullptr;
  for (const ProbeScore& p : probes) {
    if (p.candidate == candidate && (found == nullptr || p.score > found->score)) found = &p;
  }
  return found;
}

std::vector<int> Screening::two_probes(int candidate) const {
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

double Screening::similarity(int a, int b) const {
  const ProbeScore *pa = best(a), *pb = best(b);
  if (pa == nullptr || pb == nullptr) return 0.0;
  return std::abs(correlation(pa - probes.data(), pb - probes.data()));
}

}  // namespace sanso::diagnose
