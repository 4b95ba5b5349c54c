// The measured start of a shot is uncertain: what a moved start could explain is projected out of
// its residual, shot by shot.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>

#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/compare/prediction_error.h"
#include "tools/diagnose/compare/start_elimination.h"

namespace sanso::diagnose {

namespace {
/// With few joints every start is moved by itself; with more, all at once, and coupling between
/// joints is left out of their derivative.
bool starts_coupled(const Comparison& comparison) {
  return comparison.joints.size() <=
         static_cast<std::size_t>(comparison.settings.data.coupled_starts);
}
/// d r / d start, one pass of simulations each: position and velocity of every joint where they are
/// coupled, else of all joints at once.
std::vector<Eigen::VectorXd> start_derivatives(const Problem& problem, const Library& library,
                                               const Model& model, bool coupled) {
  const double position_step = problem->settings.data.start_step_position,
               velocity_step = problem->settings.data.start_step_velocity;
  const std::size_t passes = coupled ? 2 * problem->joints.size() : 2;
  std::vector<Eigen::VectorXd> moved(passes);
  Eigen::VectorXd base;
  const Remembered known(problem, library, model);  // a start that moves changes no memory
  parallel_for(passes + 1, [&](std::size_t i) {
    if (i == passes) {
      base =
          prediction_error_from_moved_start(problem, library, model, std::nullopt, 0.0, 0.0, known);
      return;
    }
    const std::optional<std::size_t> joint =
        coupled ? std::optional<std::size_t>(i / 2) : std::nullopt;
    const bool position = i % 2 == 0;
    moved[i] = prediction_error_from_moved_start(problem, library, model, joint,
                                                 position ? position_step : 0.0,
                                                 position ? 0.0 : velocity_step, known);
  });
  for (std::size_t i = 0; i < passes; ++i)
    moved[i] = (moved[i] - base) / (i % 2 == 0 ? position_step : velocity_step);
  return moved;
}

}  // namespace

StartElimination::StartElimination(const Problem& problem, const Library& library,
                                   const Model& model)
    : comparison_(problem.comparison) {
  make_blocks();
  const std::size_t n = problem->joints.size();
  const bool coupled = starts_coupled(*problem);
  J_.setZero(problem->size, 2 * n);
  const std::vector<Eigen::VectorXd> derivatives =
      start_derivatives(problem, library, model, coupled);
  for (std::size_t i = 0; i < derivatives.size(); ++i) {
    if (coupled) {
      J_.col(i) = derivatives[i];
      continue;
    }
    for (const Shot& shot : problem->shots) {
      for (std::size_t c = 0; c < problem->channels.size(); ++c) {
        rows_of(J_.col(2 * problem->channels[c].joint + i % 2), shot, c) =
            rows_of(derivatives[i], shot, c);
      }
    }
  }
  for (const Shot& shot : problem->shots) {
    const Source& source = problem->sources[shot.source];
    auto J = block_of(J_, shot, 0, problem->channels.size());
    // in units of the starts' deviations, so that the arrival cost is the identity
    for (std::size_t j = 0; j < n; ++j) {
      J.col(2 * j) *= std::max(source.q_sigma[j][shot.window.first], 1e-9);
      J.col(2 * j + 1) *= problem->settings.data.arrival_inflation *
                          std::max(source.dq_sigma[j][shot.window.first], 1e-9);
    }
    const Eigen::MatrixXd H = J.transpose() * J + Eigen::MatrixXd::Identity(J.cols(), J.cols());
    W_.push_back(H.llt().solve(Eigen::MatrixXd::Identity(J.cols(), J.cols())));
  }
}

void StartElimination::make_blocks() {
  const std::vector<TreeJoint>& tree = comparison_->sources.front().nominal.tree.joints;
  // few joints: every start was moved by itself, and a sagging supply may have carried it to
  // another branch
  const bool whole = starts_coupled(*comparison_);
  for (std::size_t j = 0; j < tree.size(); ++j) {
    const bool begins = blocks_.empty() || (!whole && tree[j].parent < 0);
    if (begins) blocks_.push_back({0, 0, 2 * j, 0});
    blocks_.back().starts += 2;
  }
  std::size_t c = 0;  // channels are sorted by joint
  for (Block& block : blocks_) {
    block.first_channel = c;
    while (c < comparison_->channels.size() &&
           2 * comparison_->channels[c].joint < block.first_start + block.starts)
      ++c;
    block.channels = c - block.first_channel;
  }
}

/// Columns that are not zero throughout the block.
template <class Columns>
std::vector<Eigen::Index> StartElimination::support(const Columns& columns,
                                                    const Block& block) const {
  std::vector<Eigen::Index> out;
  for (Eigen::Index k = 0; k < columns.cols(); ++k) {
    const bool any =
        std::any_of(comparison_->shots.begin(), comparison_->shots.end(), [&](const Shot& shot) {
          const auto piece = rows_of(columns.col(k), shot, block.first_channel, block.channels);
          return (piece.array() != 0).any();
        });
    if (any) out.push_back(k);
  }
  return out;
}

template <class Columns>
std::vector<Eigen::MatrixXd> StartElimination::gram_of(
    const Columns& columns, std::size_t parts,
    const std::function<std::size_t(const Shot&)>& part_of, const Eigen::VectorXd& weights) const {
  const std::size_t blocks = blocks_.size();
  std::vector<std::vector<Eigen::Index>> supports(blocks_.size());
  parallel_for(blocks, [&](std::size_t b) { supports[b] = support(columns, blocks_[b]); });
  // part by part, lower triangles
  std::vector<Eigen::MatrixXd> pieces(parts * blocks);
  parallel_for(parts * blocks, [&](std::size_t task) {
    const std::size_t part = task / blocks, b = task % blocks;
    const Block& block = blocks_[b];
    const auto m = static_cast<Eigen::Index>(supports[b].size());
    Eigen::MatrixXd& G = pieces[task];
    G.setZero(m, m);
    Eigen::MatrixXd B;
    for (std::size_t s = 0; s < comparison_->shots.size(); ++s) {
      const Shot& shot = comparison_->shots[s];
      if (part_of(shot) != part) continue;
      const auto J = block_of(J_, shot, block.first_channel, block.channels)
                         .middleCols(block.first_start, block.starts);
      B.resize(J.rows(), m);
      for (Eigen::Index k = 0; k < m; ++k) {
        B.col(k) = rows_of(columns.col(supports[b][k]), shot, block.first_channel, block.channels)
                       .template cast<double>();
      }
      const double weight = weights.size() == 0 ? 1.0 : weights[s];
      // B' (1 - J W J') B = B' B - |root(W)' J' B|^2
      const Eigen::MatrixXd W =
          W_[s].block(block.first_start, block.first_start, block.starts, block.starts);
      const Eigen::MatrixXd Z = W.llt().matrixU() * (J.transpose() * B);
      G.selfadjointView<Eigen::Lower>().rankUpdate(B.transpose(), weight);
      G.selfadjointView<Eigen::Lower>().rankUpdate(Z.transpose(), -weight);
    }
  });
  std::vector<Eigen::MatrixXd> out(parts);
  parallel_for(parts, [&](std::size_t part) {
    Eigen::MatrixXd& total = out[part];
    total.setZero(columns.cols(), columns.cols());
    for (std::size_t b = 0; b < blocks; ++b) {
      const std::vector<Eigen::Index>& at = supports[b];
      const Eigen::MatrixXd& G = pieces[part * blocks + b];
      for (std::size_t j = 0; j < at.size(); ++j) {
        for (std::size_t i = j; i < at.size(); ++i) total(at[i], at[j]) += G(i, j);
      }
    }
    total.triangularView<Eigen::StrictlyUpper>() = total.transpose();
  });
  return out;
}

std::vector<Eigen::MatrixXd> StartElimination::gram_by(
    const Eigen::MatrixXd& columns, std::size_t parts,
    const std::function<std::size_t(const Shot&)>& part_of, const Eigen::VectorXd& weights) const {
  return gram_of(columns, parts, part_of, weights);
}

namespace {
Eigen::MatrixXd sum(const std::vector<Eigen::MatrixXd>& parts) {
  Eigen::MatrixXd total = parts.front();
  for (std::size_t i = 1; i < parts.size(); ++i) total += parts[i];
  return total;
}
std::size_t group_of(const Shot& shot) { return shot.group; }
}  // namespace

Eigen::MatrixXd StartElimination::gram(const Eigen::MatrixXd& columns,
                                       const Eigen::VectorXd& weights) const {
  return sum(gram_of(columns, comparison_->groups, group_of, weights));
}

Eigen::MatrixXd StartElimination::gram(const Eigen::MatrixXf& columns,
                                       const Eigen::VectorXd& weights) const {
  return sum(gram_of(columns, comparison_->groups, group_of, weights));
}

std::vector<Eigen::MatrixXd> StartElimination::gram_by_group(const Eigen::MatrixXf& columns,
                                                             const Eigen::VectorXd& weights) const {
  return gram_of(columns, comparison_->groups, group_of, weights);
}

Eigen::VectorXd StartElimination::energy_by_shot(const Eigen::VectorXd& r,
                                                 const std::vector<char>& wanted) const {
  Eigen::VectorXd energy = Eigen::VectorXd::Zero(comparison_->shots.size());
  for (std::size_t s = 0; s < comparison_->shots.size(); ++s) {
    if (!wanted.empty() && wanted[s] == 0) continue;
    const Shot& shot = comparison_->shots[s];
    double total = rows_of(r, shot, 0, comparison_->channels.size()).squaredNorm();
    for (const Block& block : blocks_) {
      const Eigen::VectorXd z = block_of(J_, shot, block.first_channel, block.channels)
                                    .middleCols(block.first_start, block.starts)
                                    .transpose() *
                                rows_of(r, shot, block.first_channel, block.channels);
      total -=
          z.dot(W_[s].block(block.first_start, block.first_start, block.starts, block.starts) * z);
    }
    energy[s] = total;
  }
  return energy;
}

Eigen::VectorXd StartElimination::project(const Eigen::VectorXd& r) const {
  Eigen::VectorXd out = r;
  for (std::size_t s = 0; s < comparison_->shots.size(); ++s) {
    const Shot& shot = comparison_->shots[s];
    const auto J = block_of(J_, shot, 0, comparison_->channels.size());
    const auto of_shot = rows_of(r, shot, 0, comparison_->channels.size());
    rows_of(out, shot, 0, comparison_->channels.size()) -= J * (W_[s] * (J.transpose() * of_shot));
  }
  return out;
}

}  // namespace sanso::diagnose
