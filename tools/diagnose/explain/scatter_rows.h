// Squared errors and expected scatter, row by row: how much of the one is the other.
//
// x: squares of the rough part of the error, channel c's mean square m_c; v: expected scatter at
// one size, less its mean over the channel. Where the errors hold a share A of that scatter,
// E[x] = const + A v, and A by weighted least squares over shots and channels is
//
//   A = sum v (x - m_c) / m_c^2  /  sum v^2 / m_c^2
//
// Under independence the same sum over its deviation, sum 2 v^2 / m_c^2, is the score.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "tools/diagnose/compare/problem.h"

namespace sanso::diagnose {

/// A stretch in which rows follow each other: one channel of one shot.
struct Piece {
  std::size_t shot, channel;
};
/// Shot by shot, channel by channel: the order of stacked entries.
std::vector<Piece> pieces_of(const Comparison& comparison);

/// Variance of every entry over draws, at least two.
Eigen::VectorXd variance_of(const std::vector<Eigen::VectorXd>& draws);

/// Second differences within every shot and channel, (x[k] - (x[k-1] + x[k+1]) / 2); 0 at a piece's
/// ends. Slow errors of a model vanish in it.
Eigen::VectorXd rough_part(const Comparison& comparison, const Eigen::VectorXd& x);

/// No single row decides: a jump of the command that is simulated a fraction of a millisecond off
/// makes a large error where nearly every effect scatters most. Caps at
/// ChanceSettings::capped_share of the channel's rows from above.
Eigen::VectorXd capped(const Comparison& comparison, const std::vector<Piece>& pieces,
                       const Eigen::VectorXd& x);

/// Sum over channels of the covariance between squared error and expected scatter, each channel in
/// units of its own mean square, over its deviation for independent normal errors.
double scatter_score(const Comparison& comparison, const std::vector<Piece>& pieces,
                     const Eigen::VectorXd& squares, const Eigen::VectorXd& expected);

/// Numerator and denominator of A, by shot.
struct ScatterShare {
  std::vector<double> covariance, variance;
  /// A over some shots, with repetition; 0 when nothing is expected to scatter.
  double over(const std::vector<std::size_t>& shots) const;
};
/// `expected` is a variance over `draws` draws; its own error is taken out of the denominator.
ScatterShare scatter_share(const Comparison& comparison, const std::vector<Piece>& pieces,
                           const Eigen::VectorXd& squares, const Eigen::VectorXd& expected,
                           int draws);

/// The size at which the expected scatter is what is seen, by interpolation between the tried sizes
/// (in logarithms): the share falls from above 1 to below 1 as the size grows.
double size_at_unit_share(const std::vector<double>& sizes, const std::vector<double>& share);

}  // namespace sanso::diagnose
