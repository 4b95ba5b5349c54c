// `sanso identify`: fits the settings that model.toml holds (friction, rotor inertia, gain, delay,
// zero) to recordings, all at once, and says for each whether the data determine it. Names no
// cause: that is what `sanso diagnose` is for.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tools/diagnose/gate/load.h"
#include "tools/diagnose/model_folder/model_folder.h"
#include "tools/diagnose/settings.h"

namespace sanso::diagnose {

struct IdentifiedParameter {
  std::string joint, effect, parameter, unit;
  double nominal = 0.0;  // value of the effect at which nothing changes
  double value = 0.0;
  double sigma = 0.0;  // standard deviation, errors' correlation included
  // differs from the nominal by more than two standard deviations; only these are kept
  bool determined = false;
  bool at_bound = false;
};

struct Identification {
  std::vector<IdentifiedParameter> parameters;
  ModelFolder model;  // nominal with the determined parameters folded in
  // share of the prediction error's energy (0.5 s) left on data not used for the fit
  double error_left = 1.0;
};

using IdentifyProgress = std::function<void(const std::string&)>;

/// `loaded` must not be refused. Throws files::InputError.
Identification identify(const ModelFolder& model, const LoadedRecordings& loaded,
                        const Settings& settings, const IdentifyProgress& progress);

/// Exit code 0 done, 2 refused. Writes `out` (a model folder) only when everything went well.
int run_identify(const std::string& model_folder, const std::vector<std::string>& files,
                 const std::string& out, const Settings& settings = {});

}  // namespace sanso::diagnose
