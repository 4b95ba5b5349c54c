// together^2 = z' C^-1 z - (n - 1), over the n probes of a candidate that differ in sizes alone, C
// the correlation of their signatures: what a fit of all of them takes out, less what chance does.
#include "tools/diagnose/fit/probe_sums.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <vector>

namespace sanso::diagnose {
namespace {

/// Alike in all that is not a size.
bool of_one_shape(const Candidate& c, const std::vector<double>& a, const std::vector<double>& b) {
  for (std::size_t i = 0; i < c.parameters.size(); ++i)
    if (c.parameters[i].structural && a[i] != b[i]) return false;
  return true;
}

/// z' C^-1 z of these probes, in the directions that they have.
double explained_by(const DecisionSettings& decisions, const Screening& screening,
                    const std::vector<std::size_t>& probes) {
  const auto n = static_cast<Eigen::Index>(probes.size());
  Eigen::MatrixXd C(n, n);
  Eigen::VectorXd z(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    z[i] = screening.probes[probes[i]].z;
    for (Eigen::Index k = 0; k < n; ++k) C(i, k) = screening.correlation(probes[i], probes[k]);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(C);
  double sum = 0.0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double along = eigen.eigenvectors().col(i).dot(z);
    if (eigen.eigenvalues()[i] > decisions.one_signature)
      sum += along * along / eigen.eigenvalues()[i];
  }
  return sum;
}

}  // namespace

Screening with_sums(const DecisionSettings& decisions, const Library& library, Screening out) {
  for (ProbeScore& p : out.probes) {
    p.together = p.score;
    const Candidate& c = library[p.candidate];
    if (!c.two_sided) continue;
    std::vector<std::size_t> all;
    for (std::size_t i = 0; i < out.probes.size(); ++i) {
      const ProbeScore& other = out.probes[i];
      if (other.candidate == p.candidate && other.signature > 0.0 &&
          of_one_shape(c, c.probes[other.probe], c.probes[p.probe]))
        all.push_back(i);
    }
    if (all.size() < 2) continue;
    const double square = explained_by(decisions, out, all) - static_cast<double>(all.size() - 1);
    p.together = std::sqrt(std::max(square, p.score * p.score));
  }
  return out;
}

}  // namespace sanso::diagnose
