#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "tools/report/session_report.h"
#include "tools/sanso/commands.h"

namespace sanso::cli {

void add_report(CLI::App& app, int& result) {
  auto folder = std::make_shared<std::filesystem::path>();
  CLI::App* command = app.add_subcommand("report", "write report.html of a learning session and print its table");
  command->add_option("DIR", *folder, "folder that `sanso learn` or `sanso demo` wrote")->required();
  command->footer("Example:\n  sanso report results/squat");
  command->callback([folder, &result] {
    fmt::print("{}", report::session_table(*folder));
    fmt::print("report: {}\n", report::write_session_report(*folder).string());
    result = kDone;
  });
}

}  // namespace sanso::cli
