// Report: the robot in three dimensions. What moves stands in shown_motion.h, how it is drawn in
// tools/page.
#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "shared/files/input_error.h"
#include "tools/diagnose/effects/effect.h"
#include "tools/diagnose/run/report_sections.h"
#include "tools/page/embedded/markup.h"
#include "tools/page/embedded/packing.h"
#include "tools/page/embedded/urdf_scene.h"

namespace sanso::diagnose {
namespace {

using nlohmann::json;

std::string name_of(const std::string& effect) {
  const Effect* known = find_effect(effect);
  return known == nullptr ? effect : std::string(known->name);
}

/// Joints and links that the verdict names, each once, with what it says of them.
json lit(const Verdict& v, const RobotTree& tree) {
  json out = json::array();
  const auto add = [&](const std::string& name, const std::string& what) {
    const auto link = tree.links.find(name);
    const int joint = tree.index_of(name);
    const int carrier = joint >= 0 ? joint : link != tree.links.end() ? link->second.joint : -1;
    if (joint < 0 && link == tree.links.end()) return;  // the ground, the supply: nothing to light
    json entry = {{"name", name}, {"text", what + " at " + name}};
    if (carrier >= 0) entry["joint"] = tree.joints[static_cast<std::size_t>(carrier)].name;
    out.push_back(std::move(entry));
  };
  for (const Finding& f : v.findings)
    for (const std::string& where : f.where) add(where, name_of(f.effect));
  if (v.unexplained) add(v.unexplained->where, "something without a name");
  return out;
}

const char* words(const ModelFolder& model, bool simulated) {
  if (!simulated)
    return "As recorded: without a pose in every recording and shapes in the model nothing is "
           "simulated. Lit: what the verdict names.";
  if (model.floating)
    return "White: as recorded. Orange: the base as the nominal model lets it go, blue: as the "
           "patched one does. Joints move as recorded; momentum, gravity and a hard ground do the "
           "rest, from the recorded state anew every second. No verdict rests on it, and what only "
           "a sensor reads wrongly changes nothing in it. Lit: what the verdict names. Differences "
           "that are too small to be seen can be enlarged.";
  return "White: as recorded. Orange: simulated with the nominal model, blue: with the "
         "patched one, both with the recorded commands, put back to the recorded state "
         "every 2 s, on recordings that were not fitted. Lit: what the verdict names. "
         "Differences that are too small to be seen can be enlarged.";
}

}  // namespace

void tell_robot(report::HtmlPage& page, const Verdict& v, const ModelFolder& model,
                const ShownMotions& shown) {
  if (!page::available() || shown.motions.empty()) return;
  json scene;
  try {
    scene = page::scene_of_urdf(model.urdf, model.urdf_file, model.folder);
  } catch (const files::InputError&) {
    return;  // the verdict has said so
  }
  const RobotTree& tree = model.tree;
  scene["floating"] = model.floating;
  scene["figures"] = shown.simulated ? json{"recorded", "nominal", "patched"} : json{"recorded"};
  if (shown.ground) scene["ground"] = *shown.ground;
  scene["joints"] = scene["slides"] = json::array();
  for (const TreeJoint& joint : tree.joints) {
    scene["joints"].push_back(joint.name);
    scene["slides"].push_back(joint.prismatic);
  }
  scene["lit"] = lit(v, tree);
  const std::size_t columns =
      1 + scene["figures"].size() * (tree.joints.size() + (model.floating ? 7 : 0));
  page::PackedRuns runs(columns);
  for (const ShownMotion& m : shown.motions) {
    const std::string name = std::filesystem::path(m.recording).stem().string();
    runs.add(json{{"name", name}, {"dt", m.dt}}.dump(), m.numbers);
  }
  page.heading("The robot");
  page.markup(page::embedded("mechanism", page::gzip(runs.pack(scene.dump()))));
  page.paragraph(words(model, shown.simulated));
  for (const json& note : scene["notes"]) page.paragraph("Not drawn: " + note.get<std::string>());
}

}  // namespace sanso::diagnose
