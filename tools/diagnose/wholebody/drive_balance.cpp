// Moving joints say what friction there is, and so how much of it may hold them when they stand:
// then a stance weighs what it is worth.
#include "tools/diagnose/wholebody/drive_balance.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sanso::diagnose {

bool moves(const Asking& asking, const DriveRows& rows, Eigen::Index joint) {
  const auto moving = std::count_if(
      rows.windows.begin(), rows.windows.end(),
      [&](const StanceWindow& w) { return std::abs(w.dq[joint]) > asking.stance.creeping; });
  return moving >= asking.stance.moved;
}

DriveGuess guess_of(const Asking& asking, const DriveRows& rows, const Eigen::VectorXd& figures) {
  const JointFigure figure = rows.current ? JointFigure::torque : JointFigure::gain;
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(rows.columns.joints);
  DriveGuess out{none, none, none, none};
  for (Eigen::Index j = 0; j < rows.columns.joints; ++j) {
    out.scales[j] = 1.0 / std::max(1.0 - figures[rows.columns.joint(figure, j)], 1e-9);
    const DriveLaw& law = rows.laws[static_cast<std::size_t>(j)];
    const auto found = [&](JointFigure what) { return figures[rows.columns.joint(what, j)]; };
    out.lags[j] = std::max(-law.lag, found(JointFigure::lag));
    if (moves(asking, rows, j))
      out.dry[j] = asking.stance.coulomb + std::max(0.0, law.coulomb + found(JointFigure::dry));
    else  // nothing shows how much holds it
      out.dry[j] = std::numeric_limits<double>::infinity();
    out.load[j] = asking.tolerances.friction + std::max(0.0, law.load + found(JointFigure::load));
  }
  return out;
}

namespace {

/// Rows are not linear in some figures: what was found has to be put into them.
bool bends(const JudgedDriveTerm& j) {
  return j.term.inverse || j.term.effect == effect_of(JointFigure::lag)->id;
}

bool same_terms(const DriveChoice& a, const DriveChoice& b) {
  return std::equal(a.terms.begin(), a.terms.end(), b.terms.begin(), b.terms.end(),
                    [](const JudgedDriveTerm& x, const JudgedDriveTerm& y) {
                      return x.term.effect == y.term.effect && x.term.where == y.term.where;
                    });
}

}  // namespace

DriveBalance balance_drives(const Asking& asking) {
  DriveBalance out{drive_rows(asking), {}};
  if (!out.rows.why_not.empty()) return out;
  out.choice = choose_drive_terms(asking, out.rows);
  for (int round = 1; round < asking.stance.rounds; ++round) {
    const DriveChoice before = out.choice;
    out.rows = drive_rows(asking, guess_of(asking, out.rows, before.figures));
    out.choice = choose_drive_terms(asking, out.rows);
    const bool bent = std::any_of(out.choice.terms.begin(), out.choice.terms.end(), bends);
    if (!bent || same_terms(before, out.choice)) break;
  }
  return out;
}

}  // namespace sanso::diagnose
