// `sanso identify --episodes`: the whole-body model's parameters from recorded trials, by the
// cross-entropy method on the N-step loss in W_x (paper, eq. 6), outside a session. The newest
// fifth of every folder's trials is held out and judges.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "host/learn/model/identify.h"

namespace sanso::app {

struct IdentifyOptions {
  std::vector<std::filesystem::path> episodes;  // folders of sessions, or single .episode files
  // whose W_x; empty: that of the first folder's session
  std::string motion;
  std::uint64_t seed = 1;
  int population = 64, generations = 30, threads = 2;
  std::filesystem::path
      // identification.json, and the search's state after every generation; empty: nothing stored
      out;
  bool resume = false;  // the search in `out`
  bool quiet = false;
};

struct IdentificationData {
  std::string motion;
  model::Tangent weights = model::Tangent::Zero();  // diagonal of W_x
  std::vector<learn::PredictionWindow> train, heldout;
  // of recordings, parameters and all settings that change the search
  std::uint64_t fingerprint = 0;
};

/// Throws std::runtime_error naming the folder or file that is missing, damaged or without an
/// episode, or an `out` that holds a search which is not to be resumed.
IdentificationData load_identification_data(const IdentifyOptions& options);

/// The search itself. `stop` is asked after every generation. With an `out`, the state is stored
/// there when `stores` (one of many processes does).
learn::Identification search_parameters(const IdentifyOptions& options,
                                        const IdentificationData& data,
                                        const std::function<bool()>& stop,
                                        const learn::DistributeCandidates& distribute = {},
                                        bool stores = true);

/// The answer as JSON: losses before and after on training and held-out trials, every parameter in
/// prior deviations and in its own unit.
std::string identification_json(const IdentifyOptions& options, const IdentificationData& data,
                                const learn::Identification& found);

/// Exit code: 0 the found model predicts held-out trials better, 1 it does not (nothing to gain), 2
/// stopped before the end.
int identify(const IdentifyOptions& options);

}  // namespace sanso::app
