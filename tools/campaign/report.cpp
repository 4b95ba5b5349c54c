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
  if (e.within_s > 100)
    return fmt::format("{}, {}", fmt::join(numbers_of(e.faults), " or "), endings);
  return fmt::format("{} in {:.2f} s, {}", fmt::join(numbers_of(e.faults), " or "), e.within_s,
                     endings);
}
std::string finding(const Found& f) {
  if (f.refusal != 0) return fmt::format("R{}, {}", f.refusal, name_of(f.ending));
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
    "Made by `sanso bench faults --page {}`{}; seed {}.\n\n"
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
    "did not get. Falls are judged by the physics.\n\n"
    "*mounted* names where the sensor's axes x, y and z point in the robot: it is screwed on\n"
    "another way than the settings say, from the start.\n\n";

constexpr const char* kTrials =
    "| motion | device | word | direction | what | expected | found | reaction s | step rad | "
    "fall | torque N m | lost | as expected |\n|---|---|---|---|---|---|---|---|---|---|---|---|"
    "---|\n";

constexpr const char* kArming =
    "\n## Arming\n\n"
    "A robot in a person's hands is armed soon after it has become idle, or with one packet\n"
    "lost or damaged; packets count from the command. In all rows but the first eleven it was\n"
    "armed before and stopped, its legs put elsewhere, and the fault cleared: its servos have\n"
    "old goals. *Step* is the largest of a target with torque on (at most 0.15 rad), *speed* that\n"
    "of the fastest joint in the half second after torque (at most 1.5 rad/s).\n\n"
    "| word | direction | what | found | step rad | speed rad/s | as expected |\n"
    "|---|---|---|---|---|---|---|\n";

std::string direction_of(const Scenario& s) {
  return s.direction == Direction::none ? "" : name_of(s.direction);
}
std::string trial_row(const Row& row) {
  const Scenario& s = row.scenario;
  const Found& f = row.found;
  return fmt::format("| {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} |\n",
                     name_of(s.motion), s.device, name_of(s.word), direction_of(s), s.what,
                     expectation(s.expected), finding(f), if_any(f.reaction_s), if_any(f.step_rad),
                     f.fell ? "yes" : "no", if_any(f.torque_Nm), f.ticks_lost, verdict(f));
}
std::string arming_row(const Row& row) {
  const Scenario& s = row.scenario;
  const Found& f = row.found;
  const std::string found = f.ending == Ending::completes && f.refusal == 0 ? "armed" : finding(f);
  return fmt::format("| {} | {} | {} | {} | {:.3f} | {:.2f} | {} |\n", name_of(s.word),
                     direction_of(s), s.what, found, f.step_rad, f.speed_rad_s, verdict(f));
}

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
  std::string page = fmt::format(fmt::runtime(kIntroduction), options.page, filter, options.seed,
                                 rows.size(), failed);
  std::string trials, arming;
  for (const Row& row : rows)
    if (row.scenario.motion == Motion::arming)
      arming += arming_row(row);
    else
      trials += trial_row(row);
  if (!trials.empty()) page += kTrials + trials;
  if (!arming.empty()) page += kArming + arming;
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
                      {"refusal", f.refusal},
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
