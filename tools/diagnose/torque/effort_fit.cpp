// The regression of the missing effort, target = X x + noise: columns are means over a row's
// instants, and all that a fit needs of a block is kept, so that a fit on other blocks is a sum.
#include "tools/diagnose/torque/effort_fit.h"

#include <algorithm>
#include <cmath>

#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/model_folder/joint_units.h"
#include "tools/diagnose/stats/robust.h"
#include "tools/diagnose/torque/bounded_least_squares.h"

namespace sanso::diagnose {
namespace {

/// The term's columns, rows x its parameters, N m a unit of each:
///
///   X(i, c) = 1 / (last - first) * sum over k in [first, last) of column c at instant k
///
/// Zero in rows of joints whose effort the term does not change. An instant is evaluated once.
Eigen::MatrixXd columns_of(const EffortRows& rows, const EffortTerm& term) {
  const std::size_t n = term.size();
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(rows.rows.size()),
                                              static_cast<Eigen::Index>(n));
  for (std::size_t r = 0; r < rows.recordings.size(); ++r) {
    const EffortRecording& recording = rows.recordings[r];
    const std::size_t joints = recording.channels.size();
    const ColumnsAt at = term.columns(recording);
    std::vector<std::vector<double>> instants(recording.t.size());
    for (std::size_t i = 0; i < rows.rows.size(); ++i) {
      const EffortRow& row = rows.rows[i];
      const bool concerned =
          std::find(term.joints.begin(), term.joints.end(), row.joint) != term.joints.end();
      if (row.recording != r || !concerned) continue;
      for (std::size_t k = row.first; k < row.last; ++k) {
        if (instants[k].empty()) {
          instants[k].assign(joints * n, 0.0);
          at(recording.motion[k], recording.nominal_needs[k], instants[k]);
        }
        for (std::size_t c = 0; c < n; ++c)
          out(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(c)) +=
              instants[k][row.joint * n + c] / static_cast<double>(row.last - row.first);
      }
    }
  }
  return out;
}

}  // namespace

EffortDesign::EffortDesign(const EffortRows& rows) : rows_(&rows) {
  const auto n = static_cast<Eigen::Index>(rows.rows.size());
  target_.resize(n);
  // target = effort - nominal, means of the row
  for (Eigen::Index i = 0; i < n; ++i) {
    const EffortRow& row = rows.rows[static_cast<std::size_t>(i)];
    target_[i] = row.effort - row.nominal;
  }
  weights_ = Eigen::VectorXd::Ones(n);
  X_.resize(n, 0);
  gain_.assign(rows.recordings.front().channels.size(), 1.0);
  from_zero_.assign(gain_.size(), 0);
}

void EffortDesign::hold(std::size_t term, const std::string& unit) {
  EffortTerm& held = terms_[term];
  held.low.assign(held.low.size(), 0.0), held.high.assign(held.high.size(), 0.0);
  for (EffortTerm& other : terms_) {
    if (other.joints.size() != 1 || other.joints != held.joints) continue;
    for (std::string& told : other.units) told = with_effort_in(std::move(told), unit);
  }
}

double EffortDesign::recorded(std::size_t row) const {
  const EffortRow& r = rows_->rows[row];
  return gain_[r.joint] * r.effort;
}

std::string EffortDesign::unit(std::size_t j) const {
  const EffortRecording& first = rows_->recordings.front();
  if (from_zero_[j] != 0) return first.channels[j].unit;
  return at_joint("N m", first.nominal.tree.joints[j].prismatic);
}

std::size_t EffortDesign::append(std::vector<EffortTerm> terms) {
  const std::size_t before = terms_.size();
  std::vector<Eigen::MatrixXd> columns(terms.size());
  parallel_for(terms.size(), [&](std::size_t t) { columns[t] = columns_of(*rows_, terms[t]); });
  Eigen::Index total = X_.cols();
  for (const EffortTerm& term : terms) total += static_cast<Eigen::Index>(term.size());
  Eigen::Index at = X_.cols();
  X_.conservativeResize(Eigen::NoChange, total);
  for (std::size_t t = 0; t < terms.size(); ++t) {
    first_column_.push_back(at);
    X_.middleCols(at, columns[t].cols()) = columns[t];
    at += columns[t].cols();
    terms_.push_back(std::move(terms[t]));
  }
  form_blocks();
  return before;
}

void EffortDesign::scale(std::size_t joint, double gain, bool from_zero) {
  gain_[joint] = gain;
  from_zero_[joint] = from_zero ? 1 : 0;
  // target = gain * effort - nominal, or gain * effort alone
  for (std::size_t i = 0; i < rows_->rows.size(); ++i) {
    const EffortRow& row = rows_->rows[i];
    if (row.joint == joint)
      target_[static_cast<Eigen::Index>(i)] = gain * row.effort - (from_zero ? 0.0 : row.nominal);
  }
  form_blocks();
}

void EffortDesign::set_weights(const Eigen::VectorXd& weights) {
  weights_ = weights;
  form_blocks();
}

void EffortDesign::form_blocks() {
  const std::size_t blocks = rows_->blocks;
  std::vector<std::vector<Eigen::Index>> members(blocks);
  for (std::size_t i = 0; i < rows_->rows.size(); ++i)
    members[rows_->rows[i].block].push_back(static_cast<Eigen::Index>(i));
  block_.resize(blocks);
  // of block b, W its rows' weights:  G = X'WX,  c = X'W target,  yy = target'W target
  parallel_for(blocks, [&](std::size_t b) {
    const std::vector<Eigen::Index>& rows = members[b];
    Eigen::MatrixXd X(static_cast<Eigen::Index>(rows.size()), X_.cols());
    Eigen::VectorXd y(X.rows());
    for (Eigen::Index k = 0; k < X.rows(); ++k) {
      const Eigen::Index i = rows[static_cast<std::size_t>(k)];
      const double root = std::sqrt(weights_[i]);
      X.row(k) = root * X_.row(i);
      y[k] = root * target_[i];
    }
    Normal& normal = block_[b];
    normal.G.noalias() = X.transpose() * X;
    normal.c.noalias() = X.transpose() * y;
    normal.yy = y.squaredNorm();
  });
}

EffortValues EffortDesign::fit(const std::vector<std::size_t>& active,
                               const BlockCounts& counts) const {
  // place of the active columns in X, with bounds and priors
  std::vector<Eigen::Index> index;
  std::vector<double> low, high, precision;
  for (const std::size_t t : active) {
    const EffortTerm& term = terms_[t];
    for (std::size_t c = 0; c < term.size(); ++c) {
      index.push_back(first_column(t) + static_cast<Eigen::Index>(c));
      low.push_back(term.low[c]);
      high.push_back(term.high[c]);
      precision.push_back(term.precision);
    }
  }
  const auto n = static_cast<Eigen::Index>(index.size());
  // G = sum over b of counts[b] G_b + diag(precision),  c = sum over b of counts[b] c_b
  Eigen::MatrixXd G = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd c = Eigen::VectorXd::Zero(n);
  for (std::size_t b = 0; b < block_.size(); ++b) {
    if (counts[b] == 0.0) continue;
    for (Eigen::Index i = 0; i < n; ++i) {
      const Eigen::Index column = index[static_cast<std::size_t>(i)];
      c[i] += counts[b] * block_[b].c[column];
      for (Eigen::Index k = 0; k <= i; ++k)
        G(i, k) += counts[b] * block_[b].G(column, index[static_cast<std::size_t>(k)]);
    }
  }
  G.triangularView<Eigen::StrictlyUpper>() = G.transpose();
  for (Eigen::Index i = 0; i < n; ++i) G(i, i) += precision[static_cast<std::size_t>(i)];
  // x = argmin x'Gx / 2 - c'x,  low <= x <= high
  const Eigen::VectorXd x = bounded_least_squares(G, c, Eigen::Map<Eigen::VectorXd>(low.data(), n),
                                                  Eigen::Map<Eigen::VectorXd>(high.data(), n));
  EffortValues out = EffortValues::Zero(X_.cols());
  for (Eigen::Index i = 0; i < n; ++i) out[index[static_cast<std::size_t>(i)]] = x[i];
  return out;
}

std::vector<double> EffortDesign::losses(const EffortValues& x,
                                         const std::vector<std::size_t>& joints) const {
  std::vector<double> out(block_.size(), 0.0);
  // losses[b] = sum over the rows of b of weights r^2,  r = target - X x
  const Eigen::VectorXd r = residual(x);
  for (std::size_t i = 0; i < rows_->rows.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    if (!joints.empty() &&
        std::find(joints.begin(), joints.end(), rows_->rows[i].joint) == joints.end())
      continue;
    out[rows_->rows[i].block] += weights_[k] * r[k] * r[k];
  }
  return out;
}

Eigen::VectorXd robust_weights(const EffortRows& rows, const Eigen::VectorXd& residual,
                               double outlier) {
  const std::size_t joints = rows.recordings.front().channels.size();
  std::vector<std::vector<double>> of(joints);
  for (std::size_t i = 0; i < rows.rows.size(); ++i)
    of[rows.rows[i].joint].push_back(std::abs(residual[static_cast<Eigen::Index>(i)]));
  // sigma = 1.4826 median |residual| of the joint: the deviation, were they normal
  std::vector<double> sigma(joints, 1.0);
  for (std::size_t j = 0; j < joints; ++j) {
    if (!of[j].empty()) sigma[j] = std::max(kSigmaOfMedian * median(of[j]), 1e-12);
  }
  // weight = min(1, outlier / e) / sigma^2,  e = |residual| / sigma
  Eigen::VectorXd out(residual.size());
  for (std::size_t i = 0; i < rows.rows.size(); ++i) {
    const double s = sigma[rows.rows[i].joint];
    const double e = std::abs(residual[static_cast<Eigen::Index>(i)]) / s;
    out[static_cast<Eigen::Index>(i)] = (e > outlier ? outlier / e : 1.0) / (s * s);
  }
  return out;
}

}  // namespace sanso::diagnose
