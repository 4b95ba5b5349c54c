// URDF text to urdfdom's links and joints: the one place that calls the parser, for every reader of
// robots.
#pragma once

#include <urdf_model/model.h>
#include <urdf_world/types.h>

#include <string>

namespace sanso::model {

/// Errors: files::InputError names `file` and what urdfdom says, or the number of links above
/// kMaxUrdfLinks.
/// Safe to call from several threads (urdfdom's message handler is one for the process).
urdf::ModelInterfaceSharedPtr parse_urdf_text(const std::string& text, const std::string& file);

/// Readers of the tree recurse once a link.
inline constexpr int kMaxUrdfLinks = 1000;

/// The link that `joint` of `link` carries. Errors: InputError names the joint.
const urdf::Link& child_of(const urdf::Link& link, const urdf::Joint& joint,
                           const std::string& file);

}  // namespace sanso::model
