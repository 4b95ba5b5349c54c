// Adam on mini-batches in single precision, with matrix products of fixed order: one seed gives
// the same bits.
#include "host/learn/model/residual_training.h"

#include <cblas.h>

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

#include "host/model/softplus.h"

namespace sanso::learn {
namespace {

using host::kFeatures;
using host::kHidden;
using host::ResidualNetwork;
using model::kNdx;

// Kingma and Ba 2015, algorithm 1
constexpr float kAdamBeta1 = 0.9F, kAdamBeta2 = 0.999F, kAdamEpsilon = 1e-8F;
// Below this spread an output is constant in the data: dividing by it would amplify noise without
// bound.
constexpr float kSmallestOutputDeviation = 1e-6F;

// The least spread a feature is taken to have, about ten times what the sensors resolve. A joint
// that hardly moved while the data were recorded, or the vertical part of gravity near upright,
// would otherwise become the most sensitive input of all, and a roll-out that leaves the data by a
// hair would blow up (seen: a walk's first hip-yaw motion, 70 deviations out).
host::Features smallest_feature_deviations() {
  host::Features d;
  d[0] = 0.005;                         // base height, m
  d.segment<3>(1).setConstant(0.02);    // gravity direction, -
  d.segment<12>(4).setConstant(0.02);   // joint angles, rad
  d.segment<3>(16).setConstant(0.02);   // base velocity, m/s
  d.segment<3>(19).setConstant(0.1);    // base angular velocity, rad/s
  d.segment<12>(22).setConstant(0.2);   // joint rates, rad/s
  d.segment<12>(34).setConstant(0.02);  // targets, rad
  return d;
}

// C (m x n) = alpha A (m x k) op(B) + beta C, all row-major.
void multiply_nt(int m, int n, int k, const float* A, const float* B, float* C) {
  cblas_sgemm(CblasRowMajor, CblasNoTrans, CblasTrans, m, n, k, 1.0F, A, k, B, k, 0.0F, C, n);
}
void multiply_nn(int m, int n, int k, const float* A, const float* B, float* C) {
  cblas_sgemm(CblasRowMajor, CblasNoTrans, CblasNoTrans, m, n, k, 1.0F, A, k, B, n, 0.0F, C, n);
}
void multiply_tn(int m, int n, int k, const float* A, const float* B, float* C) {
  cblas_sgemm(CblasRowMajor, CblasTrans, CblasNoTrans, m, n, k, 1.0F, A, m, B, n, 0.0F, C, n);
}

struct Standardised {
  std::vector<float> z, y;  // (n x 46), (n x 36)
  std::size_t size = 0;
};

// One parameter block with its gradient and Adam's two moments.
struct Block {
  float* value;
  std::size_t size;
  bool decays;  // L2 acts on weights, not on biases
  std::vector<float> gradient, m, v;
  Block(float* data, std::size_t n, bool l2)
      : value(data), size(n), decays(l2), gradient(n), m(n), v(n) {}
};

class Trainer {
 public:
  Trainer(ResidualNetwork& n, const ResidualSettings& settings)
      : net_(n), settings_(settings), blocks_{Block(n.W1.data(), n.W1.size(), true),
                                              Block(n.b1.data(), n.b1.size(), false),
                                              Block(n.W2.data(), n.W2.size(), true),
                                              Block(n.b2.data(), n.b2.size(), false),
                                              Block(n.W3.data(), n.W3.size(), true),
                                              Block(n.b3.data(), n.b3.size(), false)} {}

  /// Squared error of the rows, mean over rows and outputs; keeps what backward() needs.
  double forward(const Standardised& data, const std::vector<std::uint32_t>& rows,
                 std::size_t first, std::size_t count) {
    resize(count);
    for (std::size_t r = 0; r < count; ++r) {
      const std::size_t row = rows[first + r];
      std::copy_n(&data.z[row * kFeatures], kFeatures, &z_[r * kFeatures]);
      std::copy_n(&data.y[row * kNdx], kNdx, &error_[r * kNdx]);
    }
    const int n = static_cast<int>(count);
    layer(n, kFeatures, kHidden, z_, net_.W1.data(), net_.b1.data(), a1_, &h1_);
    layer(n, kHidden, kHidden, h1_, net_.W2.data(), net_.b2.data(), a2_, &h2_);
    layer(n, kHidden, kNdx, h2_, net_.W3.data(), net_.b3.data(), out_, nullptr);
    double sum = 0;
    for (std::size_t i = 0; i < count * kNdx; ++i) {
      error_[i] = out_[i] - error_[i];
      sum += static_cast<double>(error_[i]) * error_[i];
    }
    return sum / static_cast<double>(count * kNdx);
  }

  /// Error of the last forward() in the units of the targets: mean over rows of sum_i weight_i
  /// error_i^2.
  double weighted_error(const model::Tangent& weights) const {
    const model::Tangent w = weights.cwiseProduct(net_.output_scale.cast<double>().cwiseAbs2());
    double sum = 0;
    for (std::size_t i = 0; i < error_.size(); ++i) {
      sum += w[static_cast<Eigen::Index>(i % kNdx)] * static_cast<double>(error_[i]) * error_[i];
    }
    return sum / static_cast<double>(count_);
  }

  /// Gradient of the mean squared error of the last forward(), by back-propagation.
  void backward() {
    const int n = static_cast<int>(count_);
    const float scale = 2.0F / static_cast<float>(count_ * kNdx);
    for (float& e : error_) e *= scale;
    multiply_tn(kNdx, kHidden, n, error_.data(), h2_.data(), blocks_[4].gradient.data());
    column_sums(error_, kNdx, blocks_[5].gradient);
    multiply_nn(n, kHidden, kNdx, error_.data(), net_.W3.data(), d2_.data());
    for (std::size_t i = 0; i < d2_.size(); ++i) d2_[i] *= host::softplus_slope(a2_[i]);
    multiply_tn(kHidden, kHidden, n, d2_.data(), h1_.data(), blocks_[2].gradient.data());
    column_sums(d2_, kHidden, blocks_[3].gradient);
    multiply_nn(n, kHidden, kHidden, d2_.data(), net_.W2.data(), d1_.data());
    for (std::size_t i = 0; i < d1_.size(); ++i) d1_[i] *= host::softplus_slope(a1_[i]);
    multiply_tn(kHidden, kFeatures, n, d1_.data(), z_.data(), blocks_[0].gradient.data());
    column_sums(d1_, kHidden, blocks_[1].gradient);
  }

  void adam_step() {
    ++step_;
    const auto rate =
        static_cast<float>(settings_.learning_rate * std::sqrt(1 - std::pow(kAdamBeta2, step_)) /
                           (1 - std::pow(kAdamBeta1, step_)));
    for (Block& b : blocks_) {
      const auto decay =
          b.decays ? static_cast<float>(2 * settings_.l2) / static_cast<float>(kNdx) : 0.0F;
      for (std::size_t i = 0; i < b.size; ++i) {
        const float g = b.gradient[i] + decay * b.value[i];
        b.m[i] = kAdamBeta1 * b.m[i] + (1 - kAdamBeta1) * g;
        b.v[i] = kAdamBeta2 * b.v[i] + (1 - kAdamBeta2) * g * g;
        b.value[i] -= rate * b.m[i] / (std::sqrt(b.v[i]) + kAdamEpsilon);
      }
    }
  }

 private:
  void resize(std::size_t count) {
    count_ = count;
    z_.resize(count * kFeatures);
    out_.resize(count * kNdx);
    error_.resize(count * kNdx);
    for (auto* buffer : {&a1_, &h1_, &a2_, &h2_, &d1_, &d2_}) buffer->resize(count * kHidden);
  }
  static void layer(int n, int in, int out, const std::vector<float>& x, const float* W,
                    const float* b, std::vector<float>& a, std::vector<float>* h) {
    multiply_nt(n, out, in, x.data(), W, a.data());
    for (std::size_t r = 0; r < static_cast<std::size_t>(n); ++r) {
      for (std::size_t j = 0; j < static_cast<std::size_t>(out); ++j) {
        float& value = a[r * out + j];
        value += b[j];
        if (h != nullptr) (*h)[r * out + j] = host::softplus(value);
      }
    }
  }
  static void column_sums(const std::vector<float>& rows, std::size_t columns,
                          std::vector<float>& sums) {
    std::fill(sums.begin(), sums.end(), 0.0F);
    for (std::size_t i = 0; i < rows.size(); ++i) sums[i % columns] += rows[i];
  }

  ResidualNetwork& net_;
  ResidualSettings settings_;
  std::vector<Block> blocks_;
  std::vector<float> z_, a1_, h1_, a2_, h2_, out_, error_, d1_, d2_;
  std::size_t count_ = 0;
  int step_ = 0;
};

// Mean and deviation of each column over the given rows.
void column_statistics(const std::vector<float>& values, std::size_t columns,
                       const std::vector<std::uint32_t>& rows, float* mean, float* deviation) {
  for (std::size_t c = 0; c < columns; ++c) {
    double sum = 0, squares = 0;
    for (const std::uint32_t r : rows) sum += values[r * columns + c];
    const double m = sum / static_cast<double>(rows.size());
    for (const std::uint32_t r : rows)
      squares += (values[r * columns + c] - m) * (values[r * columns + c] - m);
    mean[c] = static_cast<float>(m);
    deviation[c] = static_cast<float>(std::sqrt(squares / static_cast<double>(rows.size())));
  }
}

void set_standardisation(const TransitionSet& data, const std::vector<std::uint32_t>& rows,
                         ResidualNetwork& n) {
  Eigen::Matrix<float, kFeatures, 1> deviation;
  column_statistics(data.features, kFeatures, rows, n.feature_mean.data(), deviation.data());
  n.feature_scale = deviation.cwiseMax(smallest_feature_deviations().cast<float>()).cwiseInverse();
  column_statistics(data.targets, kNdx, rows, n.output_mean.data(), n.output_scale.data());
  n.output_scale = n.output_scale.cwiseMax(kSmallestOutputDeviation);
}

Standardised standardised(const TransitionSet& data, const ResidualNetwork& n) {
  Standardised s{data.features, data.targets, data.size()};
  for (std::size_t i = 0; i < s.z.size(); ++i) {
    const auto c = static_cast<Eigen::Index>(i % kFeatures);
    s.z[i] = (s.z[i] - n.feature_mean[c]) * n.feature_scale[c];
  }
  for (std::size_t i = 0; i < s.y.size(); ++i) {
    const auto c = static_cast<Eigen::Index>(i % kNdx);
    s.y[i] = (s.y[i] - n.output_mean[c]) / n.output_scale[c];
  }
  return s;
}

// Uniform weights scaled to keep the variance through a layer (Glorot and Bengio 2010); the last
// layer starts at zero, so that an untrained network predicts the mean and nothing else.
ResidualNetwork random_network(std::mt19937_64& rng) {
  ResidualNetwork n;
  const auto fill = [&rng](auto& W) {
    const float limit = std::sqrt(6.0F / static_cast<float>(W.rows() + W.cols()));
    for (Eigen::Index i = 0; i < W.size(); ++i) {
      W.data()[i] =
          limit * (2.0F * static_cast<float>(rng() >> 40) / static_cast<float>(1 << 24) - 1.0F);
    }
  };
  fill(n.W1);
  fill(n.W2);
  return n;
}

void shuffle(std::vector<std::uint32_t>& items, std::mt19937_64& rng) {
  // Fisher-Yates
  for (std::size_t i = items.size(); i > 1; --i) std::swap(items[i - 1], items[rng() % i]);
}

struct Split {
  std::vector<std::uint32_t> train, heldout;
};

// Whole trials are held out, since neighbouring transitions of one trial are nearly copies of each
// other; and the newest ones, since trials of one policy are nearly copies too and the policy moves
// on.
Split split_by_trial(const TransitionSet& data, double heldout_fraction) {
  std::vector<std::uint32_t> trials(data.trial);
  std::sort(trials.begin(), trials.end());
  trials.erase(std::unique(trials.begin(), trials.end()), trials.end());
  if (trials.size() < 2) {
    throw std::invalid_argument(
        fmt::format("residual network: {} trial(s) given, at least 2 are needed (one is held out)",
                    trials.size()));
  }
  const std::uint32_t first_heldout =
      trials[trials.size() - newest_heldout(trials.size(), heldout_fraction)];
  Split split;
  for (std::uint32_t row = 0; row < data.size(); ++row) {
    (data.trial[row] >= first_heldout ? split.heldout : split.train).push_back(row);
  }
  return split;
}

}  // namespace

std::size_t newest_heldout(std::size_t trials, double fraction) {
  const auto wanted = static_cast<std::size_t>(std::lround(fraction * static_cast<double>(trials)));
  return std::clamp<std::size_t>(wanted, 1, trials - 1);
}

void TransitionSet::add(std::uint32_t trial_number, const host::Features& f,
                        const model::Tangent& target) {
  for (int i = 0; i < kFeatures; ++i) features.push_back(static_cast<float>(f[i]));
  for (int i = 0; i < kNdx; ++i) targets.push_back(static_cast<float>(target[i]));
  trial.push_back(trial_number);
}

double one_step_loss(const TransitionSet& data, const std::vector<std::uint32_t>& rows,
                     const model::Tangent& weights, const host::ResidualNetwork* network) {
  double sum = 0;
  for (const std::uint32_t row : rows) {
    const Eigen::Map<const Eigen::Matrix<float, kFeatures, 1>> f(
        &data.features[static_cast<std::size_t>(row) * kFeatures]);
    const Eigen::Map<const Eigen::Matrix<float, kNdx, 1>> target(
        &data.targets[static_cast<std::size_t>(row) * kNdx]);
    model::Tangent e = target.cast<double>();
    if (network != nullptr) e -= host::residual_output(*network, f.cast<double>());
    sum += e.dot(weights.cwiseProduct(e));
  }
  return sum / static_cast<double>(std::max<std::size_t>(1, rows.size()));
}

namespace {

/// One pass over the rows in batches; at least one, the last incomplete one is left out. Mean loss.
double train_epoch(Trainer& trainer, const Standardised& data,
                   const std::vector<std::uint32_t>& rows, std::size_t batch) {
  double sum = 0;
  std::size_t batches = 0;
  for (std::size_t first = 0; first + batch <= rows.size() || first == 0;
       first += batch, ++batches) {
    sum += trainer.forward(data, rows, first, std::min(batch, rows.size() - first));
    trainer.backward();
    trainer.adam_step();
  }
  return sum / static_cast<double>(batches);
}

}  // namespace

ResidualTraining train_residual(const TransitionSet& data, const model::Tangent& weights,
                                const ResidualSettings& settings, std::uint64_t seed,
                                const host::ResidualNetwork* start) {
  const auto batch = static_cast<std::size_t>(settings.batch);
  if (data.size() < batch) {
    throw std::invalid_argument(
        fmt::format("residual network: {} transitions given, at least one batch of {} is needed",
                    data.size(), batch));
  }
  // batches are small, and one thread gives the same bits on every machine size
  openblas_set_num_threads(1);
  std::mt19937_64 rng(seed);
  Split split = split_by_trial(data, settings.heldout_fraction);
  if (!settings.held_out_decides)
    split.train.insert(split.train.end(), split.heldout.begin(), split.heldout.end());
  ResidualNetwork network = start != nullptr ? *start : random_network(rng);
  set_standardisation(data, split.train, network);
  const Standardised s = standardised(data, network);

  Trainer trainer(network, settings);
  ResidualTraining result;
  ResidualNetwork best = network;
  // The stop looks at what the gate looks at: in standardised units, coordinates that hold nothing
  // but noise would count as much as the rest and stop the training as soon as they are
  // over-fitted.
  const auto heldout_loss = [&] {
    trainer.forward(s, split.heldout, 0, split.heldout.size());
    return trainer.weighted_error(weights);
  };
  double best_loss = heldout_loss();
  int since_best = 0;
  const int patience = settings.held_out_decides ? settings.patience : settings.max_epochs;
  while (result.epochs < settings.max_epochs && since_best < patience) {
    shuffle(split.train, rng);
    result.train_loss = train_epoch(trainer, s, split.train, batch);
    ++result.epochs;
    ++since_best;
    if (const double loss = heldout_loss(); loss < best_loss || !settings.held_out_decides) {
      best_loss = loss;
      best = network;
      since_best = 0;
    }
  }
  result.heldout_loss = one_step_loss(data, split.heldout, weights, &best);
  result.heldout_loss_without = one_step_loss(data, split.heldout, weights, nullptr);
  if (result.heldout_loss < result.heldout_loss_without || !settings.held_out_decides)
    result.network = best;
  return result;
}

}  // namespace sanso::learn
