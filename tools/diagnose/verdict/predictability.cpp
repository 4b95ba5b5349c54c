// Ridge regression of the missing torque y on features F of the joint's state, by blocks f:
//
//   w_f       = (F'F - F_f'F_f + ridge)^-1 (F'y - F_f'y_f)     fitted without the block
//   explained = 1 - sum_f |y_f - F_f w_f|^2 / |y - mean|^2      predicted in it
//   p           shares of circular shifts of y that are explained as well
#include "tools/diagnose/verdict/predictability.h"

#include <fmt/format.h>
#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "tools/diagnose/stats/robust.h"
#include "tools/diagnose/stats/series.h"

namespace sanso::diagnose {
namespace {

std::vector<TorqueSample> of_joint(const std::vector<TorqueSample>& samples, std::size_t joint) {
  std::vector<TorqueSample> out;
  for (const TorqueSample& s : samples) {
    if (s.joint == joint) out.push_back(s);
  }
  return out;
}

std::vector<double> column(const std::vector<TorqueSample>& s, double TorqueSample::*field) {
  std::vector<double> out;
  out.reserve(s.size());
  for (const TorqueSample& sample : s) out.push_back(sample.*field);
  return out;
}

/// Standardised state, one row a sample.
Eigen::MatrixXd state(const std::vector<TorqueSample>& s) {
  const std::vector<double TorqueSample::*> fields{&TorqueSample::q, &TorqueSample::dq,
                                                   &TorqueSample::ddq, &TorqueSample::motor,
                                                   &TorqueSample::error};
  Eigen::MatrixXd X(static_cast<Eigen::Index>(s.size()), static_cast<Eigen::Index>(fields.size()));
  for (std::size_t f = 0; f < fields.size(); ++f) {
    const std::vector<double> v = column(s, fields[f]);
    const double centre = median(v), scale = std::max(standard_deviation(v), 1e-12);
    for (std::size_t i = 0; i < v.size(); ++i) {
      X(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(f)) =
          std::clamp((v[i] - centre) / scale, -4.0, 4.0);
    }
  }
  return X;
}

/// The state itself, the sign of the velocity, and random Fourier features of the state (Rahimi and
/// Recht 2007).
Eigen::MatrixXd features(const std::vector<TorqueSample>& s, Random random, Eigen::Index fourier) {
  const Eigen::MatrixXd X = state(s);
  const Eigen::Index n = X.rows(), d = X.cols();
  Eigen::MatrixXd F(n, d + 2 + fourier);
  F.leftCols(d) = X;
  const double speed = std::max(0.02 * standard_deviation(column(s, &TorqueSample::dq)), 1e-9);
  for (Eigen::Index i = 0; i < n; ++i) {
    F(i, d) = 1.0;
    F(i, d + 1) = std::tanh(s[i].dq / speed);
  }
  for (Eigen::Index k = 0; k < fourier; ++k) {
    Eigen::VectorXd w(d);
    for (Eigen::Index c = 0; c < d; ++c) w[c] = 0.7 * random.normal();
    const double phase = 2.0 * std::numbers::pi * random.uniform();
    F.col(d + 2 + k) = ((X * w).array() + phase).cos();
  }
  return F;
}

/// Ridge regression cross-validated over contiguous blocks; the linear map y -> held-out prediction
/// is kept, so that shifted copies of y cost one product.
class BlockRidge {
 public:
  BlockRidge(const Eigen::MatrixXd& F, int folds) : F_(F) {
    const Eigen::Index n = F.rows(), p = F.cols();
    const double ridge = 1e-2 * static_cast<double>(n);
    for (int f = 0; f < folds; ++f) {
      const Eigen::Index from = n * f / folds, to = n * (f + 1) / folds;
      Eigen::MatrixXd H = F.transpose() * F -
                          F.middleRows(from, to - from).transpose() * F.middleRows(from, to - from);
      H.diagonal().array() += ridge / static_cast<double>(p);
      folds_.push_back({from, to, H.ldlt().solve(Eigen::MatrixXd::Identity(p, p))});
    }
  }
  double explained(const Eigen::VectorXd& y) const {
    const Eigen::VectorXd full = F_.transpose() * y;
    double error = 0.0;
    for (const Fold& f : folds_) {
      const auto block = F_.middleRows(f.from, f.to - f.from);
      const Eigen::VectorXd w =
          f.inverse * (full - block.transpose() * y.segment(f.from, f.to - f.from));
      error += (y.segment(f.from, f.to - f.from) - block * w).squaredNorm();
    }
    const double total = (y.array() - y.mean()).matrix().squaredNorm();
    return total > 0.0 ? 1.0 - error / total : 0.0;
  }

 private:
  struct Fold {
    Eigen::Index from, to;
    Eigen::MatrixXd inverse;
  };
  const Eigen::MatrixXd& F_;
  std::vector<Fold> folds_;
};

}  // namespace

Predictability predictability(const std::vector<TorqueSample>& samples, std::size_t joint,
                              Random random, const Settings& settings) {
  Predictability out;
  out.joint = joint;
  const std::vector<TorqueSample> s = of_joint(samples, joint);
  if (std::ssize(s) < settings.remains.least_samples) return out;
  std::vector<double> missing = column(s, &TorqueSample::missing);
  out.torque_rms = rms(missing);
  out.noise_rms = rms(column(s, &TorqueSample::sigma));
  // a single impact must not decide: clip to ten robust deviations
  const double limit = 10.0 * std::max(robust_sigma(missing), out.noise_rms);
  for (double& v : missing) v = std::clamp(v, -limit, limit);
  const Eigen::VectorXd y =
      Eigen::Map<const Eigen::VectorXd>(missing.data(), static_cast<Eigen::Index>(missing.size()));
  const Eigen::MatrixXd F = features(s, random, settings.remains.fourier_features);
  const BlockRidge ridge(F, settings.remains.blocks);
  out.explained = ridge.explained(y);
  // shifted by more than the dependence between neighbours, the torque has lost its state but kept
  // its own colour
  const Eigen::Index n = y.size();
  const auto block = std::clamp<Eigen::Index>(
      static_cast<Eigen::Index>(3.0 * autocorrelation_time(missing)), 5, n / 4);
  int exceed = 0;
  Eigen::VectorXd shifted(n);
  for (int b = 0; b < settings.decisions.bootstrap; ++b) {
    const Eigen::Index shift = block + random.below(n - 2 * block);
    for (Eigen::Index i = 0; i < n; ++i) shifted[i] = y[(i + shift) % n];
    exceed += ridge.explained(shifted) >= out.explained;
  }
  out.p = (exceed + 1.0) / (settings.decisions.bootstrap + 1.0);
  return out;
}

namespace {

struct FormulaTerm {
  std::string name;
  std::function<double(const TorqueSample&)> value;
  bool constant = false;  // a formula gives its size alone
};

/// What a missing torque may be a sum of.
const std::vector<FormulaTerm>& formula_terms() {
  using S = const TorqueSample&;
  static const std::vector<FormulaTerm> terms{
      {"1", [](S) { return 1.0; }, true},
      {"q", [](S s) { return s.q; }},
      {"sin(q)", [](S s) { return std::sin(s.q); }},
      {"cos(q)", [](S s) { return std::cos(s.q); }},
      {"sin(2 q)", [](S s) { return std::sin(2 * s.q); }},
      {"cos(2 q)", [](S s) { return std::cos(2 * s.q); }},
      {"q^3", [](S s) { return s.q * s.q * s.q; }},
      {"dq", [](S s) { return s.dq; }},
      {"dq |dq|", [](S s) { return s.dq * std::abs(s.dq); }},
      {"sign(dq)", [](S s) { return std::tanh(s.dq / 0.05); }},
      {"sign(dq) exp(-|dq|/0.2)",
       [](S s) { return std::tanh(s.dq / 0.05) * std::exp(-std::abs(s.dq) / 0.2); }},
      {"ddq", [](S s) { return s.ddq; }},
      {"motor", [](S s) { return s.motor; }},
      {"|motor| sign(dq)", [](S s) { return std::abs(s.motor) * std::tanh(s.dq / 0.05); }},
      {"motor^2 sign(dq)", [](S s) { return s.motor * s.motor * std::tanh(s.dq / 0.05); }},
      {"motor |motor|", [](S s) { return s.motor * std::abs(s.motor); }},
      {"error", [](S s) { return s.error; }},
      {"q sign(dq)", [](S s) { return s.q * std::tanh(s.dq / 0.05); }},
      {"q dq", [](S s) { return s.q * s.dq; }},
      {"q^2 dq", [](S s) { return s.q * s.q * s.dq; }},
      {"t", [](S s) { return s.t; }},
      {"t sign(dq)", [](S s) { return s.t * std::tanh(s.dq / 0.05); }},
  };
  return terms;
}

/// One choice of columns with its least-squares weights.
struct Choice {
  std::vector<Eigen::Index> columns;
  Eigen::VectorXd w;
  double error = 0.0;  // squared, of y
};

/// The choice with that one column more that lowers the error most; the same choice when none does.
Choice with_best_column(const Choice& now, const Eigen::MatrixXd& X, const Eigen::VectorXd& y) {
  Choice best = now;
  for (Eigen::Index t = 0; t < X.cols(); ++t) {
    if (std::find(now.columns.begin(), now.columns.end(), t) != now.columns.end()) continue;
    std::vector<Eigen::Index> columns = now.columns;
    columns.push_back(t);
    Eigen::MatrixXd A(X.rows(), static_cast<Eigen::Index>(columns.size()));
    for (std::size_t k = 0; k < columns.size(); ++k)
      A.col(static_cast<Eigen::Index>(k)) = X.col(columns[k]);
    Eigen::MatrixXd H = A.transpose() * A;
    H.diagonal() *= 1.0 + 1e-9;
    const Eigen::VectorXd trial = H.ldlt().solve(A.transpose() * y);
    const double e = (y - A * trial).squaredNorm();
    if (e < best.error) best = {columns, trial, e};
  }
  return best;
}

SparseFormula formula_of(const Choice& choice) {
  SparseFormula out;
  for (std::size_t k = 0; k < choice.columns.size(); ++k) {
    const double value = choice.w[k];
    const FormulaTerm& term = formula_terms()[static_cast<std::size_t>(choice.columns[k])];
    out.terms.push_back(term.name);
    out.text +=
        fmt::format("{}{:.3g}{}", k == 0 ? (value < 0 ? "-" : "") : (value < 0 ? " - " : " + "),
                    std::abs(value), term.constant ? "" : " " + term.name);
  }
  if (!out.text.empty()) out.text = "missing torque = " + out.text;
  return out;
}

}  // namespace

SparseFormula sparse_formula(const std::vector<TorqueSample>& samples, std::size_t joint,
                             const RemainsSettings& settings) {
  const std::vector<FormulaTerm>& terms = formula_terms();
  const std::vector<TorqueSample> s = of_joint(samples, joint);
  if (std::ssize(s) < settings.least_samples) return {};
  const auto n = static_cast<Eigen::Index>(s.size());
  Eigen::MatrixXd X(n, static_cast<Eigen::Index>(terms.size()));
  Eigen::VectorXd y(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    y[i] = s[i].missing;
    for (std::size_t t = 0; t < terms.size(); ++t)
      X(i, static_cast<Eigen::Index>(t)) = terms[t].value(s[i]);
  }
  const double effective =
      static_cast<double>(n) / autocorrelation_time(column(s, &TorqueSample::missing));
  Choice chosen{{}, {}, y.squaredNorm()};
  const double total = std::max(chosen.error, 1e-30);
  for (int round = 0; round < settings.formula_terms; ++round) {
    const Choice next = with_best_column(chosen, X, y);
    // BIC on the number of independent samples: a term has to pay log(n) / 2 in log-likelihood; and
    // a share to be worth reading
    const double won = effective * std::log(chosen.error / std::max(next.error, 1e-30));
    const bool pays = next.columns.size() > chosen.columns.size() &&
                      won > 2.0 * std::log(effective) &&
                      chosen.error - next.error > settings.formula_share * total;
    if (!pays) break;
    chosen = next;
  }
  SparseFormula out = formula_of(chosen);
  out.explained = 1.0 - chosen.error / total;
  return out;
}

std::vector<ShapeCurve> shape_curves(const std::vector<TorqueSample>& samples, std::size_t joint) {
  const std::vector<TorqueSample> s = of_joint(samples, joint);
  const std::vector<double> missing = column(s, &TorqueSample::missing);
  const double dependence = autocorrelation_time(missing);
  struct Axis {
    const char *name, *unit;
    double TorqueSample::*field;
  };
  std::vector<ShapeCurve> out;
  for (const Axis& axis :
       {Axis{"velocity", "rad/s", &TorqueSample::dq}, Axis{"position", "rad", &TorqueSample::q},
        Axis{"motor torque", "N m", &TorqueSample::motor},
        Axis{"tracking error", "rad", &TorqueSample::error}, Axis{"time", "s", &TorqueSample::t}}) {
    ShapeCurve curve = shape_curve(column(s, axis.field), missing, 24, dependence);
    curve.name = axis.name;
    curve.x_unit = axis.unit;
    curve.y_unit = "N m";
    if (curve.points.size() >= 4) out.push_back(std::move(curve));
  }
  return out;
}

}  // namespace sanso::diagnose
