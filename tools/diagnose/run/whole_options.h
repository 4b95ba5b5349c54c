// Options of the command as the room for floating bases takes them.
#pragma once

#include "tools/diagnose/run/diagnose.h"
#include "tools/diagnose/wholebody/diagnose_whole.h"

namespace sanso::diagnose {

/// Model, recordings, names allowed, settings and seed.
inline WholeOptions whole_options(const DiagnoseOptions& options) {
  WholeOptions whole;
  whole.model = options.model, whole.recordings = options.recordings;
  whole.effects = options.effects, whole.settings = options.settings, whole.seed = options.seed;
  return whole;
}

}  // namespace sanso::diagnose
