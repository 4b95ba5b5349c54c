// Columns of noise as differences of linearisations about one trajectory, and their price along a
// roll-out.
#include "host/mpc/noise_phases.h"

#include <algorithm>
#include <cstring>

#include "shared/model/state_layout.h"

namespace sanso::mpc {

NoisePhases::NoisePhases(const NoiseSettings& noise, const Op3PhasesSettings& settings,
                         Op3Phases& nominal, SpinPool& pool)
    : noise_(noise),
      settings_(settings),
      nominal_(nominal),
      pool_(pool),
      columns_(static_cast<std::size_t>(nominal.stages())),
      scratch_(std::make_unique<Scratch>()) {}

void NoisePhases::set_model(const host::AugmentedModel& model) {
  without_upper_.reset();
  members_.clear();
  if (noise_.input_slope) without_upper_ = std::make_unique<Op3Phases>(settings_, model, pool_);
  if (!(noise_.spread > 0.0)) return;
  const std::size_t count = std::min(model.spread.size(), static_cast<std::size_t>(kMaxSpread));
  for (std::size_t e = 0; e < count; ++e) {
    host::AugmentedModel member = model;
    member.analytical = model.spread[e];
    member.spread.clear();
    members_.push_back(std::make_unique<Op3Phases>(settings_, member, pool_));
  }
}

void NoisePhases::begin_solve() {
  nominal_.begin_solve();
  if (without_upper_) without_upper_->begin_solve();
  for (const auto& member : members_) member->begin_solve();
}

void NoisePhases::linearize_beside(Op3Phases& phases, const Trajectory& at) {
  phases.context() = nominal_.context();
  phases.start_contact_from(nominal_);
  phases.linearize(at, scratch_->derivatives, scratch_->costs);
}

void NoisePhases::linearize(const Trajectory& nominal, StageDerivatives* derivatives,
                            StageCost* costs) {
  nominal_.linearize(nominal, derivatives, costs);
  int column = 0;
  if (without_upper_) {
    scratch_->trajectory = nominal;
    std::memset(scratch_->trajectory.u, 0, sizeof scratch_->trajectory.u);
    linearize_beside(*without_upper_, scratch_->trajectory);
    take_input_noise(derivatives, column++);
  }
  for (const auto& member : members_) {
    linearize_beside(*member, nominal);
    take_member(*member, derivatives, column++);
  }
}

/// F = f(x, u) ⊖ f(x, u without u_up): dF/dx = A - A without, dF/du = B.
void NoisePhases::take_input_noise(const StageDerivatives* nominal, int column) {
  for (int k = 0; k < stages(); ++k) {
    NoiseColumn& out = columns_[static_cast<std::size_t>(k)].column[column];
    for (int i = 0; i < kNdx; ++i) {
      out.c[i] = nominal[k].F[i];
      for (int j = 0; j < kColumns; ++j)
        out.D[i][j] = nominal[k].AB[i][j] - (j < kNdx ? scratch_->derivatives[k].AB[i][j] : 0.0);
    }
  }
}

/// F = f_e(x, u) ⊖ f(x, u).
void NoisePhases::take_member(const Op3Phases& member, const StageDerivatives* nominal,
                              int column) {
  for (int k = 0; k < stages(); ++k) {
    NoiseColumn& out = columns_[static_cast<std::size_t>(k)].column[column];
    const model::Tangent c = model::minus(member.nominal_next(k), nominal_.nominal_next(k));
    for (int i = 0; i < kNdx; ++i) {
      out.c[i] = c[i];
      for (int j = 0; j < kColumns; ++j)
        out.D[i][j] = scratch_->derivatives[k].AB[i][j] - nominal[k].AB[i][j];
    }
  }
}

NoiseColumns NoisePhases::noise_columns(double sigma) const {
  NoiseColumns out;
  out.stage = columns_.data();
  if (without_upper_) {
    out.of_input = true;
    out.variance[0] = sigma * sigma;
    out.by_coordinate[0] = !noise_.one_noise_channel;
    out.count = 1;
  }
  // the mean of the members' squares is the variance between them
  for (std::size_t e = 0; e < members_.size(); ++e)
    out.variance[out.count++] =
        noise_.spread * noise_.spread / static_cast<double>(members_.size());
  return out;
}

void NoisePhases::roll_out(const LinePolicy& policy, const double* steps, LaneTrajectories& out) {
  nominal_.roll_out(policy, steps, out);
  if (!policy.columns) return;
  pool_.run(kLineSearchLanes,
            [&](int lane, int) { out.noise_cost(lane) += price(policy, out, lane); });
}

double NoisePhases::price(const LinePolicy& policy, LaneTrajectories& lanes, int lane) const {
  const Trajectory& nominal = *policy.nominal;
  double sum = 0;
  for (int k = 0; k < stages(); ++k) {
    const model::State x = model::State::NullaryExpr(
        [&](Eigen::Index i) { return lanes.x(k, static_cast<int>(i), lane); });
    const model::Tangent dx = model::minus(x, Eigen::Map<const model::State>(nominal.x[k]));
    double d[kColumns];
    for (int i = 0; i < kNdx; ++i) d[i] = dx[i];
    for (int i = 0; i < kNu; ++i) d[kNdx + i] = lanes.u(k, i, lane) - nominal.u[k][i];
    const ColumnsPrice& price = policy.columns[k];
    sum += price.at;
    for (int i = 0; i < kColumns; ++i) {
      double row = 2 * price.slope[i];
      for (int j = 0; j < kColumns; ++j) row += price.curvature[i][j] * d[j];
      sum += row * d[i];
    }
  }
  return 0.5 * sum;
}

}  // namespace sanso::mpc
