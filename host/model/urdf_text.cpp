// Catches what urdfdom prints, so that its complaint becomes the InputError's text instead of a
// line on the terminal.
#include "host/model/urdf_text.h"

#include <console_bridge/console.h>
#include <urdf_parser/urdf_parser.h>

#include <mutex>
#include <tuple>
#include <utility>

#include "shared/files/input_error.h"

namespace sanso::model {
namespace {

using files::InputError;

/// Collects what urdfdom complains about instead of printing it.
class MessageCatcher : public console_bridge::OutputHandler {
 public:
  MessageCatcher() { console_bridge::useOutputHandler(this); }
  ~MessageCatcher() override { console_bridge::restorePreviousOutputHandler(); }
  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR && message.empty()) message = text;
  }
  std::string message;
};

/// The parsed text; where it fails, null and what urdfdom complains about first.
std::pair<urdf::ModelInterfaceSharedPtr, std::string> parsed(const std::string& text) {
  MessageCatcher catcher;
  urdf::ModelInterfaceSharedPtr model;
  try {
    model = urdf::parseURDF(text);
  } catch (const std::exception& e) {
    return {nullptr, e.what()};
  }
  if (!model || !model->getRoot()) return {nullptr, catcher.message};
  return {model, ""};
}

/// `text` with the link `world` added. Simulators (Drake, PyBullet, MuJoCo) take a parent of that
/// name for the fixed frame though no link declares it; urdfdom wants every link declared.
std::string with_world(std::string text) {
  const std::size_t end = text.rfind("</robot");
  if (end != std::string::npos) text.insert(end, "<link name=\"world\"/>");
  return text;
}

}  // namespace

urdf::ModelInterfaceSharedPtr parse_urdf_text(const std::string& text, const std::string& file) {
  static std::mutex handler;
  const std::lock_guard lock(handler);
  auto [model, complaint] = parsed(text);
  if (complaint.find("parent link [world]") != std::string::npos)
    std::tie(model, complaint) = parsed(with_world(text));
  if (!model) {
    throw InputError(file, 0, "", "not a URDF", complaint.substr(0, 200),
                     "a <robot> whose links and joints form one tree");
  }
  if (model->links_.size() > kMaxUrdfLinks) {
    throw InputError(file, 0, "", "too many links", std::to_string(model->links_.size()),
                     "at most " + std::to_string(kMaxUrdfLinks));
  }
  return model;
}

const urdf::Link& child_of(const urdf::Link& link, const urdf::Joint& joint,
                           const std::string& file) {
  for (const auto& child : link.child_links) {
    if (child->name == joint.child_link_name) return *child;
  }
  throw InputError(file, 0, joint.name, "joint without a child link", joint.child_link_name,
                   "a link of that name");
}

}  // namespace sanso::model
