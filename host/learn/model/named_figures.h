// Figures of the analytical model under the names that a diagnosis gives them: effect, place,
// parameters, as in docs/model-folder.md.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "shared/model/step_model.h"

namespace sanso::learn {

/// `where`: joints ("l_knee"), links ("body_link", "l_knee_link") or nothing, as the effect has it.
struct NamedFigure {
  std::string effect;
  std::vector<std::string> where;
  std::map<std::string, double> parameters;
};

/// Names of the bodies of the model, the base first.
std::vector<std::string> body_names();

/// Changes what the figure says: gain, damping, dry friction, rotor of servos; mass, centre of
/// mass, payload of bodies; friction of the ground. Returns why it cannot, and then changes
/// nothing; empty: done.
std::string put_figure(const NamedFigure& figure, model::ModelParameters& theta);

}  // namespace sanso::learn
