// `sanso motions new`: a motion from a recipe of key poses and steps, without a clip.
#pragma once

#include <string>

#include "host/motion/make/import.h"

namespace sanso::motion {

/// A recipe to begin with: what `sanso motions new --example` prints.
extern const char* const kExampleRecipe;

/// Solves, checks, fits and rounds to what the file holds. `text` is the recipe (docs/motions.md),
/// `file` its name for messages. Throws files::InputError for a recipe that says no motion,
/// ClipError when the robot cannot do it, naming what to change.
ImportedMotion compose_motion(const std::string& text, const std::string& file,
                              const std::string& name);

}  // namespace sanso::motion
