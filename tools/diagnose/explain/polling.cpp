// Draws of the final model without its random effects, whose scatter has a name.
#include "tools/diagnose/explain/polling.h"

#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/explain/scatter_rows.h"

namespace sanso::diagnose {

Eigen::VectorXd scatter_of_polling(const Selection& selection, unsigned long seed) {
  constexpr std::uint64_t kStream = 2000;
  const Surroundings& around = *selection.around;
  const Library& library = *around.library;
  Model model = selection.final.model;
  std::erase_if(model.effects, [&](const Chosen& c) { return library[c].random; });
  const std::size_t draws = around.settings().decisions.tolerance_draws;
  std::vector<Eigen::VectorXd> errors(draws);
  parallel_for(draws, [&](std::size_t i) {
    const std::uint64_t own = Random(seed, kStream + i).bits() | 1U;
    errors[i] = around.starts.project(polled_prediction_error(around.problem, library, model, own));
  });
  return variance_of(errors);
}

}  // namespace sanso::diagnose
