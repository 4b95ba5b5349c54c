// Figures of the analytical model under the names that a diagnosis gives them: effect, place,
// parameters, as in docs/model-folder.md.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "shared/model/step_model.h"

namespace sanso::learn {

/// By parameter, in the units of docs/model-folder.md.
using Numbers = std::map<std::string, double>;

/// `where`: joints ("l_knee"), links ("body_link", "l_knee_link") or nothing, as the effect has it.
struct NamedFigure {
  std::string effect;
  std::vector<std::string> where;
  Numbers parameters;
};

/// What an effect names as its place.
enum class FigurePlace { joint, link, ground };

/// An effect that the model has a figure for. The host reads verdicts and no library: these are the
/// names of the file, and a test holds them to the library's.
struct KnownFigure {
  std::string_view effect;
  FigurePlace place{};
  std::vector<std::string_view> parameters;  // of the effect, those that it reads
  // more mass where it is: all such figures of one place are the same model
  bool kilograms = false;
  /// Changes joint, body or (always 0) ground `place`; false: it cannot take this figure.
  bool (*put)(model::ModelParameters& theta, int place, const Numbers& numbers) = nullptr;
};

const std::vector<KnownFigure>& known_figures();
/// nullptr: the model has no figure for it.
const KnownFigure* known_figure(std::string_view effect);

/// Names of the bodies of the model, the base first.
std::vector<std::string> body_names();

/// Changes what the figure says. Returns why it cannot, and then changes nothing; empty: done.
std::string put_figure(const NamedFigure& figure, model::ModelParameters& theta);

}  // namespace sanso::learn
