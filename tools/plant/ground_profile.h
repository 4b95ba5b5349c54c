// The ground of a profile file (shared/grounds/README.md) as flat facets that MuJoCo can collide
// with. Read with code of its own: the planner's model has another (shared/grounds/ground_file.h),
// so that no mistake in one is hidden by the same mistake in the other.
#pragma once

#include <string>
#include <vector>

namespace sanso::plant {

/// A flat piece of the surface, seen from the side: from (x0, z0) to (x1, z1), x1 > x0.
struct Facet {
  double x0 = 0, z0 = 0, x1 = 0, z1 = 0;
  double friction_factor = 1.0;  // times the world's friction
};

struct GroundProfile {
  double width_m = 0.5;
  std::vector<Facet> facets;  // in the order of x
};

/// A profile that the program carries ("ramp", ...) or the path of a file. Throws WorldError.
GroundProfile load_profile(const std::string& name_or_path);

/// A profile's text; `origin` names it in messages. Throws WorldError.
GroundProfile parse_profile(const std::string& toml_text, const std::string& origin);

/// Whether the program carries a profile of this name.
bool has_profile(const std::string& name);

}  // namespace sanso::plant
