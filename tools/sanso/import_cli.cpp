// `sanso import`: bags of ros2 as CSV recordings, the form that a person can read and cut.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "tools/recording/csv_writer.h"
#include "tools/recording/mcap_recording.h"
#include "tools/sanso/commands.h"

namespace sanso::cli {
namespace {

namespace fs = std::filesystem;

struct ImportOptions {
  std::vector<fs::path> bags;
  fs::path out;
};

bool is_bag(const fs::path& file) {
  return file.extension() == ".mcap" || file.extension() == ".db3";
}

/// The files of a bag's folder, or the file itself.
std::vector<fs::path> files_of(const fs::path& bag) {
  if (!fs::is_directory(bag)) {
    if (is_bag(bag)) return {bag};
    const bool packed = bag.extension() == ".zstd";
    throw std::runtime_error(bag.string() + (packed ? ": packed as a whole; `zstd -d` first"
                                                    : ": a bag is .mcap, .db3 or their folder"));
  }
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(bag))
    if (is_bag(entry.path())) files.push_back(entry.path());
  if (files.empty()) throw std::runtime_error(bag.string() + ": holds no .mcap and no .db3");
  std::sort(files.begin(), files.end());
  return files;
}

void import_file(const fs::path& bag, const fs::path& csv) {
  if (fs::exists(csv))
    throw std::runtime_error(csv.string() + " is there already; another --out, or remove it");
  const recording::Recording r = recording::read_recording(bag.string());
  recording::write_csv(r, csv.string());
  std::set<std::string> kinds;
  for (const recording::Channel& c : r.channels) kinds.insert(c.name.substr(0, c.name.find(':')));
  fmt::print("{}: {} rows, {:.2f} s, {} joints, columns {}{}\n", csv.string(), r.rows(),
             r.t.back() - r.t.front(), r.joints().size(), fmt::join(kinds, " "),
             r.cut ? "; the bag was cut, its whole rows are here" : "");
}

int run_import(const ImportOptions& options) {
  for (const fs::path& bag : options.bags) {
    const fs::path out = !options.out.empty()    ? options.out
                         : bag.has_parent_path() ? bag.parent_path()
                                                 : fs::path(".");
    fs::create_directories(out);
    for (const fs::path& file : files_of(bag))
      import_file(file, out / file.filename().replace_extension(".csv"));
  }
  return kDone;
}

}  // namespace

void add_import(CLI::App& app, int& result) {
  auto options = std::make_shared<ImportOptions>();
  CLI::App* command = app.add_subcommand("import", "bags of ros2 (MCAP, SQLite) as CSV recordings");
  command->add_option("BAG", options->bags, "file .mcap or .db3, or the folder of `ros2 bag`")
      ->required()
      ->check(CLI::ExistingPath);
  command->add_option("--out", options->out, "folder for the CSV files; beside the bag");
  command->footer(
      "Examples:\n  sanso import rosbag2_2026_11_23 --out recordings\n"
      "  sanso diagnose --model my_robot --recordings recordings/*.csv --out result\n"
      "diagnose and score also read .mcap and .db3 as they are.");
  command->callback([options, &result] { result = run_import(*options); });
}

}  // namespace sanso::cli
