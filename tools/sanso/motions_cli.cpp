// `sanso motions`: lists the library, or makes a motion from a clip or a recipe and writes its page
// beside it.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "host/motion/make/compose.h"
#include "host/motion/make/import.h"
#include "host/motion/make/oscillators.h"
#include "host/motion/make/skate.h"
#include "host/motion/motion.h"
#include "shared/files/atomic_file.h"
#include "tools/inprocess/record_motion.h"
#include "tools/report/motion_page.h"
#include "tools/sanso/commands.h"
#include "tools/session_report/replay.h"

namespace sanso::cli {
namespace {

namespace fs = std::filesystem;

void list_motions(bool json) {
  const motion::MotionLibrary library;
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  if (!json) fmt::print("{:<16} {:>6}  {}\n", "motion", "s", "");
  for (const std::string& name : library.names()) {
    const motion::Motion m = library.load(name);
    if (!json) {
      fmt::print("{:<16} {:>6.2f}  {} ({}; {})\n", name, m.duration_s(), m.title, m.recipe.clip,
                 m.source.licence);
      continue;
    }
    nlohmann::ordered_json clauses = nlohmann::ordered_json::array();
    for (const auto& clause : m.success) {
      nlohmann::ordered_json entry{{"measure", clause.measure}};
      if (clause.at_least) entry["at_least"] = *clause.at_least;
      if (clause.at_most) entry["at_most"] = *clause.at_most;
      if (!clause.waived.empty()) entry["waived"] = clause.waived;
      clauses.push_back(entry);
    }
    list.push_back({{"name", name},
                    {"title", m.title},
                    {"duration_s", m.duration_s()},
                    {"clip", m.recipe.clip},
                    {"licence", m.source.licence},
                    {"basis", m.primitives.num_basis},
                    {"success", clauses}});
  }
  if (json)
    fmt::print(
        "{}\n",
        nlohmann::ordered_json{{"folder", library.folder().string()}, {"motions", list}}.dump(2));
}

struct ImportOptions {
  motion::ImportRequest request;
  fs::path out;
};

/// With the robot doing it, before the figures.
std::string page_of(const motion::Motion& motion) {
  std::string page = report::motion_page(motion);
  const std::string preview = report::preview_markup(motion.reference().x);
  const std::size_t at = page.find("<h2");
  if (!preview.empty() && at != std::string::npos) page.insert(at, "<h2>Preview</h2>\n" + preview);
  return page;
}

fs::path write_with_page(const motion::Motion& motion, const fs::path& out) {
  const fs::path folder = out.empty() ? motion::MotionLibrary().folder() : out;
  fs::create_directories(folder);
  const fs::path file = folder / (motion.name + ".toml");
  motion::write_motion(file, motion);
  files::write_atomically(fs::path(file).replace_extension(".html"), page_of(motion));
  return file;
}

void write_and_tell(const motion::ImportedMotion& made, const char* wanted, const fs::path& out) {
  const fs::path file = write_with_page(made.motion, out);
  const fs::path page = fs::path(file).replace_extension(".html");
  const auto& check = made.check;
  fmt::print(
      "{}: {:.2f} s, fastest joint {} {:.2f} rad/s, ZMP margin {:.0f} mm (5th percentile {:.0f}), "
      "joint limits {:.0f} deg away,\n"
      "  primitives within {:.2f} deg and {:.2f} mm of {}\n",
      made.motion.name, made.motion.duration_s(), check.fastest_joint, check.peak_joint_speed,
      1e3 * check.zmp_margin_worst_m, 1e3 * check.zmp_margin_p5_m,
      check.joint_margin_rad * 57.29578, made.fit.joint_rad * 57.29578, 1e3 * made.fit.position_m,
      wanted);
  fmt::print("motion: {}\nreport: {}\n", file.string(), page.string());
}

struct SkateOptions {
  std::string name;
  fs::path out;
};

void make_skate(const SkateOptions& options) {
  const motion::ImportedMotion made = motion::make_skate(options.name);
  const fs::path file = write_with_page(made.motion, options.out);
  const auto& x = made.retargeted.trajectory.x;
  fmt::print("{}: {:.2f} s down {}, to {:.2f} m and {:.2f} m/s; primitives within {:.2f} mm\n",
             made.motion.name, made.motion.duration_s(), made.motion.skate->ground,
             x.back()[model::kXPos], x.back().segment<3>(model::kXVel).norm(),
             1e3 * made.fit.position_m);
  fmt::print("motion: {}\n", file.string());
}

void add_skate(CLI::App& motions) {
  auto options = std::make_shared<SkateOptions>();
  CLI::App* command = motions.add_subcommand(
      "skate", "make a motion on wheels from its ground profile and the law of energy");
  command
      ->add_option("NAME", options->name, "skate_slope, skate_ramp, skate_ramp_high or skate_jump")
      ->required();
  command->add_option("--out", options->out, "folder (default: the library)");
  command->callback([options] { make_skate(*options); });
}

void import_clip(const ImportOptions& options) {
  write_and_tell(motion::import_motion(options.request), "the retargeted clip", options.out);
}

struct NewOptions {
  fs::path recipe, out = ".";
  std::string name;
  bool example = false;
};

void compose(const NewOptions& options) {
  if (options.example) {
    fmt::print("{}", motion::kExampleRecipe);
    return;
  }
  if (options.recipe.empty() || options.name.empty())
    throw std::runtime_error(
        "sanso motions new: expected a recipe and --as NAME; --example prints a recipe");
  const std::string text = files::read_text(options.recipe);
  write_and_tell(motion::compose_motion(text, options.recipe.string(), options.name),
                 "the recipe's way", options.out);
  fmt::print(
      "next: look at the page; then SANSO_MOTIONS={} sanso learn --motion {} --iterations "
      "10 --out runs/{}\n",
      options.out.string(), options.name, options.name);
}

void add_new(CLI::App& motions) {
  auto options = std::make_shared<NewOptions>();
  CLI::App* command =
      motions.add_subcommand("new", "make a motion from a recipe of key poses and steps");
  command->add_option("RECIPE", options->recipe, "TOML (docs/motions.md)")
      ->check(CLI::ExistingFile);
  command->add_option("--as", options->name, "name of the motion");
  command->add_option("--out", options->out, "folder")->capture_default_str();
  command->add_flag("--example", options->example, "print a recipe to begin with");
  command->footer(
      "Examples:\n  sanso motions new --example > bow.toml\n"
      "  sanso motions new bow.toml --as bow --out my_motions");
  command->callback([options] { compose(*options); });
}

struct RecordOptions {
  fs::path recipe, out = ".";
  std::string name, world = "lab", ground;
  bool example = false;
};

void record(const RecordOptions& options) {
  if (options.example) {
    fmt::print("{}", motion::kExampleRecordRecipe);
    return;
  }
  if (options.recipe.empty() || options.name.empty())
    throw std::runtime_error(
        "sanso motions record: expected NAME and --recipe FILE; --example prints a recipe");
  const std::string text = files::read_text(options.recipe);
  const motion::RecordRecipe recipe = motion::parse_record_recipe(text, options.recipe.string());
  const inprocess::RecordedMotion made =
      inprocess::record_motion(recipe, motion::MotionLibrary().load(recipe.like), options.name,
                               options.world, options.ground);
  const fs::path file = write_with_page(made.motion, options.out);
  const double deg = 57.29578;
  fmt::print(
      "{}: {:.2f} s recorded, joints up to {:.2f} deg off their targets; primitives within {:.2f} "
      "deg\n  and {:.2f} mm of the robot, fastest joint {:.2f} rad/s, joint limits {:.0f} deg "
      "away\nmotion: {}\n",
      options.name, made.robot.duration_s(), deg * made.largest_lag_rad, deg * made.fit.joint_rad,
      1e3 * made.fit.position_m, made.peak_joint_speed, deg * made.joint_margin_rad, file.string());
  fmt::print("next: SANSO_MOTIONS={} sanso learn --motion {} --iterations 10 --out runs/{}\n",
             options.out.string(), options.name, options.name);
}

void add_record(CLI::App& motions) {
  auto options = std::make_shared<RecordOptions>();
  CLI::App* command = motions.add_subcommand(
      "record", "record a motion from the emulated robot, moved by oscillators, held by a hand");
  command->add_option("NAME", options->name, "name of the motion");
  command->add_option("--recipe", options->recipe, "TOML (docs/motions.md)")
      ->check(CLI::ExistingFile);
  command->add_option("--world", options->world, "of the emulated robot")->capture_default_str();
  command->add_option("--ground", options->ground, "profile (default: the motion's)");
  command->add_option("--out", options->out, "folder")->capture_default_str();
  command->add_flag("--example", options->example, "print a recipe to begin with");
  command->footer(
      "Examples:\n  sanso motions record --example > coast.toml\n"
      "  sanso motions record coast --recipe coast.toml --out my_motions");
  command->callback([options] { record(*options); });
}

}  // namespace

void add_motions(CLI::App& app, int& result) {
  auto json = std::make_shared<bool>(false);
  auto options = std::make_shared<ImportOptions>();
  CLI::App* command =
      app.add_subcommand("motions", "list the motions, or make one from a human clip");
  command->add_flag("--json", *json, "as JSON");
  command->footer(
      "Examples:\n  sanso motions\n  sanso motions import clips/squat.bvh --as my_squat --like "
      "squat --out my_motions\n"
      "SANSO_MOTIONS names another folder of motions than the shipped one.");
  CLI::App* clip = command->add_subcommand(
      "import", "retarget a clip (BVH or DeepMimic), check it, write motion and page");
  clip->add_option("CLIP", options->request.clip, "the clip")->required()->check(CLI::ExistingFile);
  clip->add_option("--as", options->request.name, "name of the motion")->required();
  clip->add_option("--like", options->request.like,
                   "motion whose figures are used (default: the one of that name)");
  clip->add_option("--set", options->request.figures,
                   "a figure of the retargeting, KEY=VALUE (docs/motions.md)");
  clip->add_option("--out", options->out, "folder (default: the library)");
  clip->callback([options] { import_clip(*options); });
  add_new(*command);
  add_record(*command);
  add_skate(*command);
  add_jog(*command);
  command->callback([json, command, &result] {
    if (command->get_subcommands().empty()) list_motions(*json);
    result = kDone;
  });
}

}  // namespace sanso::cli
