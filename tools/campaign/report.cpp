// The campaign as a page, as JSON and as lines.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tools/campaign/campaign.h"

namespace sanso::campaign {
namespace {

std::string number_of(firmware::Fault fault) {
  return fault == firmware::Fault::none ? "-" : fmt::format("F{}", static_cast<int>(fault));
}
std::vector<std::string> names_of(const std::vector<Ending>& endings) {
  std::vector<std::string> names;
  for (const Ending ending : endings) names.emplace_back(name_of(ending));
  return names;
}
std::vector<std::string> numbers_of(const std::vector<firmware::Fault>& faults) {
  std::vector<std::string> numbers;
  for (const firmware::Fault fault : faults) numbers.push_back(number_of(fault));
  return numbers;
}
std::string expectation(const Expected& e) {
  const std::string endings = fmt::format("{}", fmt::join(names_of(e.endings), " or "));
  if (e.faults.empty()) return endings;
  return fmt::format("{} in {:.2f} s, {}", fmt::join(numbers_of(e.faults), " or "), e.within_s,
                     endings);
}
std::string finding(const Found& f) {
  if (f.fault == firmware::Fault::none) return name_of(f.ending);
  return fmt::format("{}, {}", number_of(f.fault), name_of(f.ending));
}
std::string if_any(double value, const char* unit = "") {
  return value < 0 ? "-" : fmt::format("{:.2f}{}", value, unit);
}
std::string verdict(const Found& found) {
  return found.passed() ? "yes" : fmt::format("**no**: {}", fmt::join(found.broken, "; "));
}

constexpr const char* kIntroduction =
    "# Faults, made to happen\n\n"
    "Made by `sanso bench faults --page docs/results/faults.md`{}; seed {}.\n\n"
    "Every row is a trial of its own on the emulated robot (world lab) in virtual time, the real\n"
    "bytes of bus, IMU and link, planner in the loop: {} rows, {} not as expected. Trouble comes\n"
    "while the robot stands (1.0 s into the trial), on its way down in a squat (2.5 s), or in a\n"
    "step (3.1 s). The rows are the product of fault words, devices, directions and motions\n"
    "(`tools/campaign/cells.cpp`); what is expected stands there, not in the controller.\n\n"
    "*Ends*: `completes` the motion and stands in hold; `held` by the servos with the fault\n"
    "latched; `lowered` into the crouch, then torque off; `limp`: torque off without that;\n"
    "`fell` with torque still on. *Reaction* counts from the beginning of trouble to the latched\n"
    "fault. *Step* is the largest change of a target in one tick (allowed: 0.15 rad). *Torque*\n"
    "is the sum over the servos 5 s after a fall. *Lost* are ticks whose observation the host\n"
    "did not get. Falls are judged by the physics.\n\n";

}  // namespace

std::string line_of(const Row& row) {
  const Found& f = row.found;
  return fmt::format(
      "{:<50} {:<22} {:>6} {:>5} {}", row.scenario.name(), finding(f), if_any(f.reaction_s),
      if_any(f.step_rad),
      f.passed() ? "" : fmt::format("NOT AS EXPECTED: {}", fmt::join(f.broken, "; ")));
}

std::string page_of(const std::vector<Row>& rows, const Options& options) {
  const auto failed =
      std::count_if(rows.begin(), rows.end(), [](const Row& r) { return !r.found.passed(); });
  const std::string filter =
      options.filter.empty() ? "" : fmt::format(" with `--filter {}`", options.filter);
  std::string page =
      fmt::format(fmt::runtime(kIntroduction), filter, options.seed, rows.size(), failed);
  page +=
      "| motion | device | word | direction | what | expected | found | reaction s | step rad | "
      "fall | torque N m | lost | as expected |\n|---|---|---|---|---|---|---|---|---|---|---|---|"
      "---|\n";
  for (const Row& row : rows) {
    const Scenario& s = row.scenario;
    const Found& f = row.found;
    page += fmt::format(
        "| {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} |\n", name_of(s.motion),
        s.device, name_of(s.word), s.direction == Direction::none ? "" : name_of(s.direction),
        s.what, expectation(s.expected), finding(f), if_any(f.reaction_s), if_any(f.step_rad),
        f.fell ? "yes" : "no", if_any(f.torque_Nm), f.ticks_lost, verdict(f));
  }
  return page;
}

std::string json_of(const std::vector<Row>& rows, const Options& options) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Row& row : rows) {
    const Scenario& s = row.scenario;
    const Found& f = row.found;
    list.push_back({{"name", s.name()},
                    {"motion", name_of(s.motion)},
                    {"device", s.device},
                    {"word", name_of(s.word)},
                    {"direction", name_of(s.direction)},
                    {"what", s.what},
                    {"expected",
                     {{"faults", numbers_of(s.expected.faults)},
                      {"endings", names_of(s.expected.endings)},
                      {"within_s", s.expected.within_s},
                      {"fall_allowed", s.expected.fall_allowed}}},
                    {"found",
                     {{"fault", static_cast<int>(f.fault)},
                      {"detail", f.detail},
                      {"ending", name_of(f.ending)},
                      {"reaction_s", f.reaction_s},
                      {"step_rad", f.step_rad},
                      {"speed_rad_s", f.speed_rad_s},
                      {"fell", f.fell},
                      {"torque_after_fall_Nm", f.torque_Nm},
                      {"ticks_lost", f.ticks_lost}}},
                    {"broken", f.broken},
                    {"passed", f.passed()}});
  }
  return nlohmann::ordered_json{{"seed", options.seed}, {"scenarios", list}}.dump(2);
}

}  // namespace sanso::campaign
