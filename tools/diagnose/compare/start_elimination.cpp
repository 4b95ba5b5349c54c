// The measured start of a shot is uncertain: what a moved start could explain is projected out of
// its residual, shot by shot.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/compare/prediction_error.h"

namespace sanso::diagnose {

namespace {
/// With few joints every start is moved by itself; with more, all at once, and coupling between
/// joints is left out of their derivative.
bool starts_coupled(const Problem& problem) {
  return problem.joints.size() <= static_cast<std::size_t>(problem.settings.data.coupled_starts);
}
}  // namespace

StartElimination::StartElimination(const Problem& problem, const Library& library,
                                   const Model& model)
    : problem_(&problem) {
  make_blocks();
  const std::size_t n = problem.joints.size();
  const bool coupled = starts_coupled(problem);
  J_.setZero(static_cast<Eigen::Index>(problem.size), static_cast<Eigen::Index>(2 * n));
  const double position_step = problem.settings.data.start_step_position,
               velocity_step = problem.settings.data.start_step_velocity;
  const int passes = coupled ? static_cast<int>(2 * n) : 2;
  std::vector<Eigen::VectorXd> moved(static_cast<std::size_t>(passes));
  Eigen::VectorXd base;
  parallel_for(passes + 1, [&](int i) {
    if (i == passes) {
      base = prediction_error(problem, library, model);
      return;
    }
    const int joint = coupled ? i / 2 : -1;
    const bool position = i % 2 == 0;
    moved[static_cast<std::size_t>(i)] = prediction_error_from_moved_start(
        problem, library, model, joint, position ? position_step : 0.0,
        position ? 0.0 : velocity_step);
  });
  for (int i = 0; i < passes; ++i) {
    const Eigen::VectorXd derivative =
        (moved[static_cast<std::size_t>(i)] - base) / (i % 2 == 0 ? position_step : velocity_step);
    if (coupled) {
      J_.col(i) = derivative;
      continue;
    }
    for (const Shot& shot : problem.shots) {
      for (std::size_t c = 0; c < problem.channels.size(); ++c) {
        const auto from = static_cast<Eigen::Index>(shot.offset + c * shot.rows);
        const auto rows = static_cast<Eigen::Index>(shot.rows);
        J_.block(from, 2 * problem.channels[c].joint + i % 2, rows, 1) =
            derivative.segment(from, rows);
      }
    }
  }
  for (const Shot& shot : problem.shots) {
    const Source& source = problem.sources[static_cast<std::size_t>(shot.source)];
    auto J = J_.middleRows(static_cast<Eigen::Index>(shot.offset), entries(shot));
    // in units of the starts' deviations, so that the arrival cost is the identity
    for (std::size_t j = 0; j < n; ++j) {
      J.col(static_cast<Eigen::Index>(2 * j)) *=
          std::max(source.q_sigma[j][shot.window.first], 1e-9);
      J.col(static_cast<Eigen::Index>(2 * j + 1)) *=
          problem.settings.data.arrival_inflation *
          std::max(source.dq_sigma[j][shot.window.first], 1e-9);
    }
    const Eigen::MatrixXd H = J.transpose() * J + Eigen::MatrixXd::Identity(J.cols(), J.cols());
    W_.push_back(H.llt().solve(Eigen::MatrixXd::Identity(J.cols(), J.cols())));
  }
}

void StartElimination::make_blocks() {
  const std::vector<TreeJoint>& tree = problem_->sources.front().nominal.tree.joints;
  const auto n = static_cast<Eigen::Index>(tree.size());
  // few joints: every start was moved by itself, and a sagging supply may have carried it to
  // another branch
  const bool whole = starts_coupled(*problem_);
  for (Eigen::Index j = 0; j < n; ++j) {
    const bool begins = blocks_.empty() || (!whole && tree[static_cast<std::size_t>(j)].parent < 0);
    if (begins) blocks_.push_back({0, 0, 2 * j, 0});
    blocks_.back().starts += 2;
  }
  std::size_t c = 0;  // channels are sorted by joint
  for (Block& block : blocks_) {
    block.first_channel = c;
    while (c < problem_->channels.size() &&
           2 * problem_->channels[c].joint < block.first_start + block.starts)
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
        std::any_of(problem_->shots.begin(), problem_->shots.end(), [&](const Shot& shot) {
          const auto from =
              static_cast<Eigen::Index>(shot.offset + block.first_channel * shot.rows);
          const auto piece =
              columns.col(k).segment(from, static_cast<Eigen::Index>(block.channels * shot.rows));
          return (piece.array() != 0).any();
        });
    if (any) out.push_back(k);
  }
  return out;
}

template <class Columns>
std::vector<Eigen::MatrixXd> StartElimination::gram_of(
    const Columns& columns, int parts, const std::function<int(const Shot&)>& part_of,
    const Eigen::VectorXd& weights) const {
  const int blocks = static_cast<int>(blocks_.size());
  std::vector<std::vector<Eigen::Index>> supports(blocks_.size());
  parallel_for(blocks, [&](int b) {
    const auto k = static_cast<std::size_t>(b);
    supports[k] = support(columns, blocks_[k]);
  });
  // part by part, lower triangles
  std::vector<Eigen::MatrixXd> pieces(static_cast<std::size_t>(parts * blocks));
  parallel_for(parts * blocks, [&](int task) {
    const int part = task / blocks;
    const auto b = static_cast<std::size_t>(task % blocks);
    const Block& block = blocks_[b];
    const auto m = static_cast<Eigen::Index>(supports[b].size());
    Eigen::MatrixXd& G = pieces[static_cast<std::size_t>(task)];
    G.setZero(m, m);
    Eigen::MatrixXd B;
    for (std::size_t s = 0; s < problem_->shots.size(); ++s) {
      const Shot& shot = problem_->shots[s];
      if (part_of(shot) != part) continue;
      const auto from = static_cast<Eigen::Index>(shot.offset + block.first_channel * shot.rows);
      const auto rows = static_cast<Eigen::Index>(block.channels * shot.rows);
      B.resize(rows, m);
      for (Eigen::Index k = 0; k < m; ++k) {
        B.col(k) = columns.col(supports[b][static_cast<std::size_t>(k)])
                       .segment(from, rows)
                       .template cast<double>();
      }
      const double weight = weights.size() == 0 ? 1.0 : weights[static_cast<Eigen::Index>(s)];
      // B' (1 - J W J') B = B' B - |root(W)' J' B|^2
      const Eigen::MatrixXd W =
          W_[s].block(block.first_start, block.first_start, block.starts, block.starts);
      const Eigen::MatrixXd Z =
          W.llt().matrixU() *
          (J_.block(from, block.first_start, rows, block.starts).transpose() * B);
      G.selfadjointView<Eigen::Lower>().rankUpdate(B.transpose(), weight);
      G.selfadjointView<Eigen::Lower>().rankUpdate(Z.transpose(), -weight);
    }
  });
  std::vector<Eigen::MatrixXd> out(static_cast<std::size_t>(parts));
  parallel_for(parts, [&](int part) {
    Eigen::MatrixXd& total = out[static_cast<std::size_t>(part)];
    total.setZero(columns.cols(), columns.cols());
    for (int b = 0; b < blocks; ++b) {
      const std::vector<Eigen::Index>& at = supports[static_cast<std::size_t>(b)];
      const Eigen::MatrixXd& G = pieces[static_cast<std::size_t>(part * blocks + b)];
      for (std::size_t j = 0; j < at.size(); ++j) {
        for (std::size_t i = j; i < at.size(); ++i) {
          total(at[i], at[j]) += G(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
        }
      }
    }
    total.triangularView<Eigen::StrictlyUpper>() = total.transpose();
  });
  return out;
}

std::vector<Eigen::MatrixXd> StartElimination::gram_by(
    const Eigen::MatrixXd& columns, int parts, const std::function<int(const Shot&)>& part_of,
    const Eigen::VectorXd& weights) const {
  return gram_of(columns, parts, part_of, weights);
}

namespace {
Eigen::MatrixXd sum(const std::vector<Eigen::MatrixXd>& parts) {
  Eigen::MatrixXd total = parts.front();
  for (std::size_t i = 1; i < parts.size(); ++i) total += parts[i];
  return total;
}
int group_of(const Shot& shot) { return shot.group; }
}  // namespace

Eigen::MatrixXd StartElimination::gram(const Eigen::MatrixXd& columns,
                                       const Eigen::VectorXd& weights) const {
  return sum(gram_of(columns, problem_->groups, group_of, weights));
}

Eigen::MatrixXd StartElimination::gram(const Eigen::MatrixXf& columns,
                                       const Eigen::VectorXd& weights) const {
  return sum(gram_of(columns, problem_->groups, group_of, weights));
}

std::vector<Eigen::MatrixXd> StartElimination::gram_by_group(const Eigen::MatrixXf& columns,
                                                             const Eigen::VectorXd& weights) const {
  return gram_of(columns, problem_->groups, group_of, weights);
}

Eigen::VectorXd StartElimination::energy_by_shot(const Eigen::VectorXd& r) const {
  Eigen::VectorXd energy(static_cast<Eigen::Index>(problem_->shots.size()));
  for (std::size_t s = 0; s < problem_->shots.size(); ++s) {
    const Shot& shot = problem_->shots[s];
    const auto from = static_cast<Eigen::Index>(shot.offset);
    const auto piece = r.segment(from, entries(shot));
    double total = piece.squaredNorm();
    for (const Block& block : blocks_) {
      const auto first = static_cast<Eigen::Index>(block.first_channel * shot.rows);
      const auto rows = static_cast<Eigen::Index>(block.channels * shot.rows);
      const Eigen::VectorXd z =
          J_.block(from + first, block.first_start, rows, block.starts).transpose() *
          piece.segment(first, rows);
      total -=
          z.dot(W_[s].block(block.first_start, block.first_start, block.starts, block.starts) * z);
    }
    energy[static_cast<Eigen::Index>(s)] = total;
  }
  return energy;
}

Eigen::VectorXd StartElimination::project(const Eigen::VectorXd& r) const {
  Eigen::VectorXd out = r;
  for (std::size_t s = 0; s < problem_->shots.size(); ++s) {
    const Shot& shot = problem_->shots[s];
    const auto from = static_cast<Eigen::Index>(shot.offset);
    const auto J = J_.middleRows(from, entries(shot));
    out.segment(from, entries(shot)) -=
        J * (W_[s] * (J.transpose() * r.segment(from, entries(shot))));
  }
  return out;
}

}  // namespace sanso::diagnose
