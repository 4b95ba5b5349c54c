// effort = a (needed by the links) + friction + constant, all free: a is the unit.
#include "tools/diagnose/torque/drive_gain.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace sanso::diagnose {
namespace {

/// The nuisance that is the joint's gain.
std::optional<std::size_t> gain_term(const EffortDesign& design, const std::string& joint) {
  for (std::size_t t = 0; t < design.terms().size(); ++t) {
    const EffortTerm& term = design.terms()[t];
    if (term.law.kind == EffortKind::share && term.nuisance && term.where.front() == joint)
      return t;
  }
  return std::nullopt;
}

/// Of the friction and the constant that are fitted beside a gain.
std::vector<Eigen::Index> columns_beside(const EffortDesign& design, const std::string& joint) {
  std::vector<Eigen::Index> out;
  for (std::size_t t = 0; t < design.terms().size(); ++t) {
    const EffortTerm& term = design.terms()[t];
    if (term.law.beside_gain && !term.nuisance && term.where.front() == joint)
      out.push_back(design.first_column(t));
  }
  return out;
}

struct Estimate {
  double a = 0.0;      // recorded unit for one N m
  double share = 0.0;  // of the error that the links' effort takes away beside all else
};

/// Squared error of a plain least-squares fit of the effort on these columns.
double left_by(const EffortDesign& design, std::size_t joint,
               const std::vector<Eigen::Index>& columns, double* first_value) {
  std::vector<Eigen::Index> members;
  for (std::size_t i = 0; i < design.rows().rows.size(); ++i) {
    if (design.rows().rows[i].joint == joint) members.push_back(static_cast<Eigen::Index>(i));
  }
  Eigen::MatrixXd X(static_cast<Eigen::Index>(members.size()),
                    static_cast<Eigen::Index>(columns.size()));
  Eigen::VectorXd y(X.rows());
  for (Eigen::Index i = 0; i < X.rows(); ++i) {
    const Eigen::Index row = members[static_cast<std::size_t>(i)];
    y[i] = design.rows().rows[static_cast<std::size_t>(row)].effort;
    for (Eigen::Index c = 0; c < X.cols(); ++c)
      X(i, c) = design.X()(row, columns[static_cast<std::size_t>(c)]);
  }
  Eigen::MatrixXd G = X.transpose() * X;
  G.diagonal() *= 1.0 + 1e-9;
  G.diagonal().array() += 1e-300;
  const Eigen::VectorXd x = G.ldlt().solve(X.transpose() * y);
  if (first_value != nullptr) *first_value = x[0];
  return (y - X * x).squaredNorm();
}

Estimate estimate(const EffortDesign& design, std::size_t joint, const std::string& name) {
  const std::vector<Eigen::Index> others = columns_beside(design, name);
  std::vector<Eigen::Index> with = others;
  with.insert(with.begin(), *gain_column(design, name));
  Estimate out;
  const double before = left_by(design, joint, others, nullptr);
  const double after = left_by(design, joint, with, &out.a);
  out.share = before > 0.0 ? 1.0 - after / before : 0.0;
  return out;
}

}  // namespace

std::optional<Eigen::Index> gain_column(const EffortDesign& design, const std::string& joint) {
  const std::optional<std::size_t> term = gain_term(design, joint);
  if (!term) return std::nullopt;
  return design.first_column(*term);
}

std::vector<EffortGainFound> scale_unknown_gains(EffortDesign& design, const Settings& settings) {
  std::vector<EffortGainFound> out;
  const EffortRecording& first = design.rows().recordings.front();
  for (std::size_t j = 0; j < first.channels.size(); ++j) {
    const EffortChannel& channel = first.channels[j];
    if (!channel.gain_unknown) continue;
    EffortGainFound gain;
    gain.joint = first.nominal.tree.joints[j].name;
    gain.unit = channel.unit;
    gain.stated = false;
    const Estimate e = estimate(design, j, gain.joint);
    gain.determined = e.a > 0.0 && e.share > settings.effort.gain_share;
    gain.value = gain.determined ? 1.0 / e.a : 1.0;
    design.scale(j, gain.value, !gain.determined);
    if (!gain.determined) design.hold(*gain_term(design, gain.joint), gain.unit);
    out.push_back(gain);
  }
  return out;
}

}  // namespace sanso::diagnose
