// Packed in 16 bits a number, a trial of 8 s takes about 12 kB and an angle is right to a tenth of
// a milliradian.
#include "tools/session_report/replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "tools/page/embedded/markup.h"
#include "tools/page/layer_parts.h"
#include "tools/page/scene.h"
#include "tools/plant/world_error.h"

namespace sanso::report {
namespace {

namespace fs = std::filesystem;
using learn::Episode;
using nlohmann::json;

using page::kShown;
constexpr int kStride = 3;  // 30 ms: as smooth as a film

ReplayRow row_of(const Episode& episode, std::size_t i) {
  const wire::Observation& o = episode.ticks[i];
  const bool seen = i < episode.truth.size();
  const model::State& x = seen ? episode.truth[i].x : o.x;
  ReplayRow row{};
  for (std::size_t k = 0; k < kShown; ++k) {
    row[k] = x[static_cast<int>(k)];
    row[kShown + k] = static_cast<double>(episode.reference[i][k]);
  }
  model::Input rest;
  for (int j = 0; j < model::kNumJoints; ++j)
    rest[j] = static_cast<double>(
        episode.reference.front()[static_cast<std::size_t>(model::kXJoint + j)]);
  std::size_t c = 2 * kShown;
  for (const std::size_t foot : {0, 1})
    row[c++] = seen ? static_cast<double>(episode.truth[i].foot_load_N[foot]) : 0.0;
  for (const double part : page::layer_parts(o, rest)) row[c++] = part;
  return row;
}

/// Both ends, and between them every so manieth, so that `keep` are left of `count`.
std::set<int> spread(int count, int keep) {
  std::set<int> out;
  for (int i = 0; i < keep; ++i)
    out.insert(keep > 1 ? static_cast<int>(std::lround(double(count - 1) * i / (keep - 1))) : 0);
  return out;
}

int best_of(const std::vector<learn::TrialSummary>& history) {
  return static_cast<int>(std::min_element(history.begin(), history.end(),
                                           [](const auto& a, const auto& b) {
                                             return std::make_pair(a.failed(), a.cost) <
                                                    std::make_pair(b.failed(), b.cost);
                                           }) -
                          history.begin());
}

std::string scene_for(const fs::path& folder) {
  try {
    if (fs::exists(folder / "world.toml"))
      return page::scene_of(plant::load_world((folder / "world.toml").string())).dump();
  } catch (const plant::WorldError&) {  // of another version: the robot is the same
  }
  return page::scene_of(plant::load_world("nominal")).dump();
}

/// Packed and zipped, with these trials of the history in it, as far as they are stored and have
/// moved.
std::string data_of(const fs::path& folder, const learn::SessionState& state,
                    const std::set<int>& wanted, int best) {
  ReplayData data(scene_for(folder), kStride);
  int second = -1;
  for (const int i : wanted) {
    const learn::TrialSummary& summary = state.history[static_cast<std::size_t>(i)];
    if (!fs::exists(learn::trial_file(folder, summary.trial))) continue;
    const Episode episode = learn::load_episode(learn::trial_file(folder, summary.trial));
    if (episode.ticks.empty()) continue;
    if (i == best && data.trials() > 0) second = data.trials();
    data.add(summary, episode);
  }
  return data.trials() > 0 ? page::gzip(data.pack(0, second)) : std::string();
}

}  // namespace

std::vector<ReplayRow> replay_rows(const Episode& episode, int stride) {
  std::vector<ReplayRow> rows;
  if (episode.ticks.empty() || episode.reference.size() != episode.ticks.size()) return rows;
  std::size_t i = 0;
  for (int tick = episode.ticks.front().trial_tick; tick <= episode.ticks.back().trial_tick;
       tick += stride) {
    while (i + 1 < episode.ticks.size() && episode.ticks[i + 1].trial_tick <= tick) ++i;
    rows.push_back(row_of(episode, i));
  }
  for (const learn::PlanRecord& plan : episode.plans) {
    const auto k = static_cast<std::size_t>(
        std::max(0, plan.observed_tick - episode.ticks.front().trial_tick) / stride);
    if (k < rows.size()) rows[k].back() = plan.update_ms;
  }
  // between two answers the last one holds
  for (std::size_t k = 1; k < rows.size(); ++k)
    if (rows[k].back() == 0.0) rows[k].back() = rows[k - 1].back();
  return rows;
}

ReplayData::ReplayData(std::string scene, int stride) : scene_(std::move(scene)), stride_(stride) {}

void ReplayData::add(const learn::TrialSummary& summary, const Episode& episode) {
  const std::vector<ReplayRow> rows = replay_rows(episode, stride_);
  const json about = {{"n", summary.trial + 1},
                      {"cost", summary.cost},
                      {"failed", summary.failed()},
                      {"end", learn::to_string(summary.end)}};
  std::vector<double> numbers;
  for (const ReplayRow& row : rows) numbers.insert(numbers.end(), row.begin(), row.end());
  runs_.add(about.dump(), numbers);
}

std::string ReplayData::pack(int first, int second) const {
  json head = json::parse(scene_);
  head["dt"] = to_seconds(kTickPeriod) * stride_;
  head["first"] = first;
  head["second"] = second;
  return runs_.pack(head.dump());
}

std::string replay_markup(const fs::path& folder, const learn::SessionState& state,
                          std::size_t most_bytes) {
  if (!page::available() || state.history.empty()) return {};
  const auto count = static_cast<int>(state.history.size());
  const int best = best_of(state.history);
  std::string data;
  for (int keep = count; keep >= 1; keep = keep / 2) {
    std::set<int> wanted = spread(count, keep);
    wanted.insert(best);
    data = data_of(folder, state, wanted, best);
    if (4 * data.size() / 3 <= most_bytes) break;
  }
  return data.empty() ? std::string() : page::embedded("replay", data);
}

std::string preview_markup(const std::vector<model::State>& reference) {
  if (!page::available() || reference.empty()) return {};
  Episode episode;
  for (const model::State& x : reference) {
    wire::Observation& o = episode.ticks.emplace_back();
    o.trial_tick = static_cast<std::int32_t>(episode.ticks.size()) - 1;
    o.x = x;
    std::array<float, model::kNx>& shown = episode.reference.emplace_back();
    for (std::size_t i = 0; i < shown.size(); ++i)
      shown[i] = static_cast<float>(x[static_cast<int>(i)]);
  }
  json scene = page::scene_of(plant::load_world("nominal"));
  scene["preview"] = true;
  ReplayData data(scene.dump(), kStride);
  data.add({}, episode);
  return page::embedded("replay", page::gzip(data.pack(0, -1)));
}

std::string film_page(const fs::path& folder, const learn::SessionState& state,
                      const FilmOptions& options) {
  const auto count = static_cast<int>(state.history.size());
  const int first = options.first > 0 ? options.first : 1;
  const int second = options.second > 0 ? options.second : count;
  for (const int trial : {first, second})
    if (trial > count)
      throw std::runtime_error(
          fmt::format("trial {}: {} has trials 1 to {}", trial, folder.string(), count));
  const std::string data = data_of(folder, state, {first - 1, second - 1}, -1);
  if (data.empty())
    throw std::runtime_error(fmt::format("{}: trials {} and {} are not stored or did not move",
                                         folder.string(), first, second));
  const json asked = {
      {"kind", options.kind}, {"width", options.width_px}, {"row_height", options.row_height_px},
      {"fps", options.fps},   {"from", options.from_s},    {"to", options.to_s}};
  return page::film_page(data, asked.dump());
}

}  // namespace sanso::report
