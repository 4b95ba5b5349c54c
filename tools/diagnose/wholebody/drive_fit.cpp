// Figures are those of the terms, C x, and of the nuisances, B off (B their columns, P their
// precision). The nuisances are eliminated once (Schur complement); a fit then has a few unknowns:
//
//   min over x, off of  figures'G figures - 2 c'figures + off'P off,  figures = C x + B off
#include "tools/diagnose/wholebody/drive_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "tools/diagnose/stats/robust.h"
#include "tools/diagnose/torque/bounded_least_squares.h"

namespace sanso::diagnose {
double Normal::loss(const Eigen::VectorXd& figures) const {
  return std::max(0.0, yy - 2.0 * c.dot(figures) + figures.dot(G * figures));
}

Eliminated::Eliminated(const Normal& normal, const DriveNuisances& nuisances)
    : G_(normal.G), c_(normal.c), nuisances_(&nuisances) {
  // back = (B'G B + P)^-1 B',  off = back (c - G C x) is the minimum over off;
  // schur = G - G B back G,  reduced = c - G B back c
  const Eigen::MatrixXd GN = G_ * nuisances.columns;
  Eigen::MatrixXd A = nuisances.columns.transpose() * GN;
  A.diagonal() += nuisances.precision;
  const Eigen::LLT<Eigen::MatrixXd> root(A);
  back_ = root.solve(nuisances.columns.transpose());
  spread_ = root.solve(Eigen::MatrixXd::Identity(A.rows(), A.cols()));
  schur_ = G_ - GN * (back_ * G_);
  reduced_ = c_ - GN * (back_ * c_);
}

Eigen::MatrixXd Eliminated::columns_of(const std::vector<const DriveTerm*>& active,
                                       Eigen::Index figures) {
  Eigen::Index size = 0;
  for (const DriveTerm* t : active) size += t->size();
  Eigen::MatrixXd C(figures, size);
  Eigen::Index at = 0;
  for (const DriveTerm* t : active) C.middleCols(at, t->size()) = t->columns, at += t->size();
  return C;
}

Eliminated::Fit Eliminated::fit(const std::vector<const DriveTerm*>& active) const {
  const Eigen::MatrixXd C = columns_of(active, G_.rows());
  Eigen::VectorXd low(C.cols()), high(C.cols());
  Eigen::Index at = 0;
  for (const DriveTerm* t : active) {
    for (Eigen::Index i = 0; i < t->size(); ++i, ++at)
      low[at] = t->low[static_cast<std::size_t>(i)],
      high[at] = t->high[static_cast<std::size_t>(i)];
  }
  // x = argmin x'S x / 2 - r'x within its bounds,  S = C' schur C,  r = C' reduced
  const Eigen::MatrixXd S = C.transpose() * schur_ * C;
  const Eigen::VectorXd r = C.transpose() * reduced_;
  Fit out;
  out.x = C.cols() > 0 ? bounded_least_squares(S, r, low, high) : Eigen::VectorXd(0);
  out.gain = 2.0 * r.dot(out.x) - out.x.dot(S * out.x);
  // what the nuisances make of the rest, and how far off they would have to be
  out.named = C * out.x;
  const Eigen::VectorXd off = back_ * (c_ - G_ * out.named);
  const Eigen::VectorXd squares = off.cwiseAbs2().cwiseProduct(nuisances_->precision);
  out.strained = squares.sum(), out.strains = squares.cwiseSqrt();
  if (squares.size() > 0) out.farthest = std::sqrt(squares.maxCoeff(&out.which));
  out.figures = out.named + nuisances_->columns * off;
  return out;
}

/// By coefficient and nuisance: what a nuisance within a term's own figures adds to it.
Eigen::MatrixXd Eliminated::own_of(const std::vector<const DriveTerm*>& active) const {
  const Eigen::MatrixXd& N = nuisances_->columns;
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(columns_of(active, G_.rows()).cols(), N.cols());
  Eigen::Index at = 0;
  for (const DriveTerm* t : active) {
    const Eigen::MatrixXd& C = t->columns;
    const Eigen::VectorXd figures = C.rowwise().norm();
    // own = (C'C)^-1 C' n  of the nuisances n that move no figure but those of C
    const Eigen::MatrixXd onto = (C.transpose() * C).ldlt().solve(C.transpose());
    for (Eigen::Index k = 0; k < N.cols(); ++k) {
      const bool elsewhere = (figures.array() == 0.0 && N.col(k).array() != 0.0).any();
      if (!elsewhere) out.block(at, k, t->size(), 1) = onto * N.col(k);
    }
    at += t->size();
  }
  return out;
}

Eigen::VectorXd Eliminated::deviations(const std::vector<const DriveTerm*>& active) const {
  const Eigen::MatrixXd C = columns_of(active, G_.rows());
  if (C.cols() == 0) return Eigen::VectorXd(0);
  const Eigen::MatrixXd S = C.transpose() * schur_ * C;
  // as if no bound held:  x of covariance S^-1;  nuisances n = -back G C x + what (B'G B + P)^-1
  // leaves of them;  V that of x + own n
  const Eigen::MatrixXd own = own_of(active);
  const Eigen::MatrixXd with =
      Eigen::MatrixXd::Identity(S.rows(), S.cols()) - own * (back_ * (G_ * C));
  const Eigen::MatrixXd V =
      with * S.ldlt().solve(with.transpose()) + own * spread_ * own.transpose();
  return V.diagonal().cwiseMax(0.0).cwiseSqrt();
}

std::vector<double> scatter_by_channel(const DriveRows& rows, const Eigen::VectorXd& figures,
                                       double least) {
  const Eigen::VectorXd left = rows.y - rows.X * figures;
  std::vector<std::vector<double>> by(rows.channels);
  for (std::size_t i = 0; i < rows.channel.size(); ++i)
    by[rows.channel[i]].push_back(std::abs(left[static_cast<Eigen::Index>(i)]));
  std::vector<double> out;
  out.reserve(by.size());
  for (const auto& x : by)
    out.push_back(std::max(least, x.empty() ? 1.0 : kSigmaOfMedian * median(x)));
  return out;
}

std::vector<double> left_by_channel(const DriveRows& rows, const Eigen::VectorXd& figures,
                                    double outlier) {
  const Eigen::VectorXd left = rows.y - rows.X * figures;
  std::vector<double> squares(rows.channels, 0.0), counts = squares;
  for (std::size_t i = 0; i < rows.channel.size(); ++i) {
    const std::size_t c = rows.channel[i];
    const double size = std::min(outlier, std::abs(left[static_cast<Eigen::Index>(i)]));
    squares[c] += size * size, counts[c] += 1.0;
  }
  for (std::size_t c = 0; c < squares.size(); ++c)
    squares[c] = std::sqrt(squares[c] / std::max(counts[c], 1.0));
  return squares;
}

DriveGroups weighed(const DriveRows& rows, const Eigen::VectorXd& figures, double outlier,
                    const StanceSettings& stance) {
  const Eigen::VectorXd left = rows.y - rows.X * figures;
  const std::vector<double> scatter = scatter_by_channel(rows, figures, stance.least_scatter);
  const std::size_t recordings =
      *std::max_element(rows.recording.begin(), rows.recording.end()) + 1;
  const std::size_t pieces = *std::max_element(rows.piece.begin(), rows.piece.end()) + 1;
  const bool whole = recordings >= static_cast<std::size_t>(stance.fewest_recordings);
  const Eigen::Index P = rows.X.cols();
  DriveGroups out;
  out.all = Normal(P);
  out.by.assign(whole ? 2 : 1, {});
  out.by.back().assign(pieces, Normal(P));
  if (whole) out.by.front().assign(recordings, Normal(P));
  // rows of one piece of one recording are together
  for (std::size_t first = 0; first < rows.channel.size();) {
    std::size_t last = first;
    while (last < rows.channel.size() && rows.recording[last] == rows.recording[first] &&
           rows.piece[last] == rows.piece[first])
      ++last;
    const auto a = static_cast<Eigen::Index>(first), n = static_cast<Eigen::Index>(last - first);
    // rows times sqrt(min(1, outlier / size)) / s,  size = |left| / s,  s the channel's scatter
    Eigen::MatrixXd X = rows.X.middleRows(a, n);
    Eigen::VectorXd y = rows.y.segment(a, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const double s = scatter[rows.channel[first + static_cast<std::size_t>(i)]];
      const double size = std::abs(left[a + i]) / s;
      const double weight = std::sqrt(size > outlier ? outlier / size : 1.0) / s;
      X.row(i) *= weight, y[i] *= weight;
    }
    // G = X'X,  c = X'y,  yy = y'y
    Normal here(P);
    here.G.selfadjointView<Eigen::Lower>().rankUpdate(X.transpose());
    here.G = Eigen::MatrixXd(here.G.selfadjointView<Eigen::Lower>());
    here.c = X.transpose() * y, here.yy = y.squaredNorm();
    out.all.add(here);
    out.by.back()[rows.piece[first]].add(here);
    if (whole) out.by.front()[rows.recording[first]].add(here);
    first = last;
  }
  return out;
}

}  // namespace sanso::diagnose
