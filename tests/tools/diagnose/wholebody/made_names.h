// Two names that a robot's recordings leave undecided, whatever they are: viscous friction at all
// joints, or dry friction there. Only motion, slow and fast, tells the two apart.
#pragma once

#include <algorithm>
#include <memory>

#include "tests/tools/diagnose/wholebody/made_stance.h"
#include "tools/diagnose/wholebody/names_apart.h"

namespace sanso::diagnose::test {

struct MadeNames {
  static constexpr double kViscous = 0.3;  // N m s/rad
  StanceWorld world;
  std::shared_ptr<const NamesApart> apart;

  explicit MadeNames(const Stance& stance) : MadeNames(StanceWorld(stance)) {}
  explicit MadeNames(StanceWorld made) : world(std::move(made)) {
    const Asking asking = world.asking();
    const DriveRows rows = drive_rows(asking);
    const std::vector<DriveTerm> all = drive_terms(asking, rows);
    const auto at_all = [&](JointFigure figure) {
      return *std::find_if(all.begin(), all.end(), [&](const DriveTerm& t) {
        return t.effect == effect_of(figure)->id && t.where.size() == world.body.model.tree.size();
      });
    };
    JudgedDriveTerm viscous;
    viscous.term = at_all(JointFigure::speed);
    viscous.size = kViscous, viscous.sigma = 1e-6;
    viscous.rivals = {at_all(JointFigure::dry)};
    DriveChoice choice;
    choice.figures = choice.named = viscous.term.columns * kViscous;
    choice.terms = {std::move(viscous)};
    apart = names_apart(asking, rows, choice);
  }

  /// Of a drawn motion, `share` of the usual one.
  double nats(double share, double seconds) const {
    Stance tried;
    tried.seconds = seconds;
    tried.moves = [share](int) { return share; };
    return apart->nats(recorded(world.body, tried, 99));
  }
};

/// Stands, but for a little.
inline Stance hardly_moving() {
  Stance out;
  out.recordings = 3, out.seconds = 4.0;
  out.moves = [](int) { return 0.05; };
  return out;
}

}  // namespace sanso::diagnose::test
