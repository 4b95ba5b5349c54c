// Reads the stored state and episodes of a folder; a missing episode costs its figure, not the
// report.
#include "tools/session_report/session_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "host/learn/session/session_state.h"
#include "host/learn/session/summary.h"
#include "shared/files/atomic_file.h"
#include "shared/files/json.h"
#include "shared/model/joints.h"
#include "tools/report/html.h"
#include "tools/report/svg_chart.h"
#include "tools/session_report/replay.h"
#include "tools/session_report/session_figures.h"

namespace sanso::report {
namespace {

namespace fs = std::filesystem;
using learn::SessionState;
using learn::TrialSummary;

std::unique_ptr<SessionState> state_of(const fs::path& folder) {
  const fs::path file = folder / "state.bin";
  if (!fs::exists(file))
    throw std::runtime_error(
        file.string() +
        ": not there; expected the folder that `sanso learn --out` or `sanso demo --out` wrote");
  auto state = std::make_unique<SessionState>();
  learn::load_state(file, *state);
  if (state->history.empty()) throw std::runtime_error(file.string() + ": no finished trial yet");
  return state;
}

std::string outcome(const TrialSummary& t) {
  if (t.failed()) return learn::how_it_ended(t);
  return t.succeeded() ? "no" : "no, but " + t.broken_clauses.front();
}

Table trial_table(const SessionState& state) {
  Table table{{"trial", "cost", "failed", "update p50 [ms]", "max [of 60 ms]", "late updates",
               "bus errors", "time [s]"},
              {}};
  for (const TrialSummary& t : state.history)
    table.rows.push_back({fmt::format("{}", t.trial + 1), fmt::format("{:.2f}", t.cost), outcome(t),
                          fmt::format("{:.2f}", learn::percentile(t.update_ms, 0.5)),
                          fmt::format("{:.2f}", learn::percentile(t.update_ms, 1.0)),
                          fmt::format("{}", t.late_updates),
                          fmt::format("{}", t.bus_lost + t.bus_corrupt),
                          fmt::format("{:.1f}", t.wall_s)});
  return table;
}

std::string verdict(const SessionState& state) {
  const auto& h = state.history;
  const auto failures =
      std::count_if(h.begin(), h.end(), [](const TrialSummary& t) { return t.failed(); });
  const auto best = std::min_element(h.begin(), h.end(), [](const auto& a, const auto& b) {
    return std::make_pair(a.failed(), a.cost) < std::make_pair(b.failed(), b.cost);
  });
  return fmt::format(
      "{} trials, {} failed; first cost {:.2f}, last {:.2f}, best {:.2f} (trial {}).", h.size(),
      failures, h.front().cost, h.back().cost, best->cost, best->trial + 1);
}

void add_trial(HtmlPage& page, const fs::path& folder, const TrialSummary& summary) {
  if (!fs::exists(learn::trial_file(folder, summary.trial))) return;
  const learn::Episode episode = learn::load_episode(learn::trial_file(folder, summary.trial));
  page.heading(fmt::format("Trial {}", summary.trial + 1));
  page.figure(layer_contributions(episode),
              "Share of each layer in the sum that is sent to the servos.");
  std::vector<std::string> body{base_height(episode), base_tilt(episode)};
  if (!episode.truth.empty()) body.push_back(foot_forces(episode));
  page.gallery(body);
  std::vector<std::string> joints;  // right and left side by side
  constexpr int kPerLeg = model::kNumJoints / 2;
  for (int joint = 0; joint < kPerLeg; ++joint)
    for (int leg : {0, kPerLeg}) joints.push_back(joint_angle(episode, leg + joint));
  page.gallery(joints);
}

/// What was run, in words, from summary.json; a session that was killed before its first summary
/// has none.
std::string introduction(const fs::path& folder, const SessionState& state) {
  const auto summary = files::json_or_null(folder / "summary.json");
  if (!summary.is_object()) return state.identity;
  std::string without;
  for (const auto& layer : summary.value("without", nlohmann::json::array()))
    without += (without.empty() ? ", without " : ", ") + layer.get<std::string>();
  return fmt::format("Motion {} on {}, seed {}{}.", summary.value("motion", "?"),
                     summary.value("robot", "?"), summary.value("seed", 0ULL), without);
}

}  // namespace

std::filesystem::path write_session_report(const fs::path& folder) {
  const std::unique_ptr<SessionState> state = state_of(folder);
  HtmlPage page("sanso: learning session");
  page.paragraph(introduction(folder, *state));
  page.answer(verdict(*state), !state->history.back().failed());
  page.figure(
      cost_over_trials(*state),
      "Sum over the 60 ms ticks of the weighted distance from the reference and of the upper "
      "layer's input. Shaded: failed.");
  if (const std::string replay = replay_markup(folder, *state); !replay.empty()) {
    page.heading("Replay");
    page.markup(replay);
    page.paragraph(
        "Solid: the robot (what really was, where the world can tell; else what the controller "
        "believed). Orange: the reference. Green: the load on each foot. Drag to turn, pinch or "
        "roll to come closer.");
  }
  page.gallery({layers_over_trials(*state), gains_over_trials(*state), model_over_trials(*state),
                update_times(*state)});
  page.table(trial_table(*state));
  add_trial(page, folder, state->history.front());
  if (state->history.size() > 1) add_trial(page, folder, state->history.back());
  fs::path file = folder / "report.html";
  files::write_atomically(file, page.finish());
  return file;
}

std::string film_page_of(const fs::path& folder, const FilmOptions& options) {
  return film_page(folder, *state_of(folder), options);
}

std::string compare_costs(const std::vector<fs::path>& folders) {
  LineChart chart{
      .title = "Cost over trials", .x_label = "trial", .y_label = "J", .series = {}, .log_y = true};
  for (const fs::path& folder : folders) {
    Series series{
        .name = (folder.has_filename() ? folder : folder.parent_path()).filename().string(),
        .x = {},
        .y = {}};
    const std::unique_ptr<SessionState> state = state_of(folder);
    for (const TrialSummary& t : state->history) {
      series.x.push_back(t.trial + 1);
      series.y.push_back(t.cost);
    }
    chart.series.push_back(series);
  }
  return svg(chart, {820, 320});
}

void write_session_figures(const fs::path& folder, const fs::path& to) {
  const std::unique_ptr<SessionState> state = state_of(folder);
  fs::create_directories(to);
  files::write_atomically(to / "cost.svg", cost_over_trials(*state));
  files::write_atomically(to / "layers.svg", layers_over_trials(*state));
  files::write_atomically(to / "gains.svg", gains_over_trials(*state));
  files::write_atomically(to / "model.svg", model_over_trials(*state));
  files::write_atomically(to / "updates.svg", update_times(*state));
}

std::string session_table(const fs::path& folder) {
  const Table table = trial_table(*state_of(folder));
  std::string out;
  const auto line = [&](const std::vector<std::string>& cells) {
    for (std::size_t c = 0; c < cells.size(); ++c)
      out += fmt::format("{:>{}}  ", cells[c], std::max<std::size_t>(table.header[c].size(), 7));
    out += '\n';
  };
  line(table.header);
  for (const auto& row : table.rows) line(row);
  return out;
}

}  // namespace sanso::report
