// The phases of a plan whose noise has slopes. Models that fit the data about as well as the one
// that is planned with are linearised beside it: what they differ by is a noise of its own. So is
// the same model without the upper layer's input, for dF/dx of the noise that inputs make. Each
// costs a linearisation.
#pragma once

#include <memory>
#include <vector>

#include "host/mpc/op3_phases.h"

namespace sanso::mpc {

struct NoiseSettings {
  bool input_slope = false;        // dF/dx of the noise that inputs make
  bool one_noise_channel = false;  // of that noise
  double spread = 0.0;             // amplitude of the noise between models; 0: not planned with
};

class NoisePhases : public Phases {
 public:
  /// `nominal`: of the model that is planned with; its context is everyone's.
  NoisePhases(const NoiseSettings& noise, const Op3PhasesSettings& settings, Op3Phases& nominal,
              SpinPool& pool);
  /// After nominal.set_model(); allocates.
  void set_model(const host::AugmentedModel& model);

  int stages() const override { return nominal_.stages(); }
  void begin_solve() override;
  void linearize(const Trajectory& nominal, StageDerivatives* derivatives,
                 StageCost* costs) override;
  NoiseColumns noise_columns(double sigma) const override;
  void roll_out(const LinePolicy& policy, const double* steps, LaneTrajectories& out) override;
  void lane_taken(int lane) override { nominal_.lane_taken(lane); }

 private:
  struct Scratch {
    Trajectory trajectory;
    StageDerivatives derivatives[kMaxStages];
    StageCost costs[kMaxHorizon];
  };
  void linearize_beside(Op3Phases& phases, const Trajectory& at);
  void take_input_noise(const StageDerivatives* nominal, int column);
  void take_member(const Op3Phases& member, const StageDerivatives* nominal, int column);
  double price(const LinePolicy& policy, LaneTrajectories& lanes, int lane) const;

  NoiseSettings noise_;
  Op3PhasesSettings settings_;
  Op3Phases& nominal_;
  SpinPool& pool_;
  std::unique_ptr<Op3Phases> without_upper_;  // null: dF/dx is not asked for
  std::vector<std::unique_ptr<Op3Phases>> members_;
  std::vector<StageNoise> columns_;  // by stage
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace sanso::mpc
