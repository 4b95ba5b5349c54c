// In the code's own names, of a command at row k with goal u[k], held[k] the goal that the servo
// has before it, and n losses that follow it at once:
//
//   response = made / ((u[k] - held[k]) (1 + n))^2      made: energy of what its loss alone changes
//   shows      response missed^2 > times price          missed: Commands::missed of the run
//
// Whether k itself is lost is not asked: what would show is the same command either way, so that a
// share that is counted among those does not lean to one side.
#include "tools/diagnose/explain/showing.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "tools/diagnose/stats/robust.h"

namespace sanso::diagnose {
namespace {

std::vector<Run> runs_of(const std::vector<LostCommand>& lost) {
  std::vector<Run> out;
  for (const LostCommand& l : lost) {
    const bool goes_on = !out.empty() && l.source == out.back().first.source &&
                         l.joint == out.back().first.joint &&
                         l.row == out.back().first.row + out.back().length;
    if (goes_on) {
      ++out.back().length;
    } else {
      out.push_back({l});
    }
  }
  return out;
}

std::size_t typical_run(const std::vector<Run>& runs) {
  if (runs.empty()) return 1;
  std::vector<double> lengths;
  lengths.reserve(runs.size());
  for (const Run& run : runs) lengths.push_back(static_cast<double>(run.length));
  return std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(median(lengths))));
}

/// Sum over rows of what the servo's goal changes by when the command is lost, or no longer [rad].
double displaced(const Hunt& hunt, LostCommand at) {
  const std::vector<LostCommand>& lost = hunt.repaired().lost;
  const std::vector<double>& u = hunt.commands().of(at.source, at.joint);
  std::size_t held = at.row - 1;
  while (held > 0 && holds(lost, {at.source, at.joint, held})) --held;
  std::size_t end = at.row + 1;
  while (end < u.size() && holds(lost, {at.source, at.joint, end})) ++end;
  return (u[at.row] - u[held]) * static_cast<double>(end - at.row);
}

}  // namespace

Interval Counted::interval(double together) const {
  return wilson_interval(static_cast<int>(std::lround(lost / together)),
                         static_cast<int>(std::lround(std::max(commands, lost) / together)));
}

Showing::Showing(const Hunt& hunt, std::vector<std::size_t> joints)
    : hunt_(hunt), joints_(std::move(joints)), runs_(runs_of(hunt.repaired().lost)) {
  typical_ = typical_run(runs_);
  for (const std::size_t joint : joints_) {
    const std::vector<std::vector<Change>> alone = hunt_.each_alone(joint);
    for (std::size_t s = 0; s < alone.size(); ++s) {
      const std::size_t source = hunt_.problem()->shots[s].source;
      for (const Change& c : alone[s]) {
        const double change = displaced(hunt_, {source, joint, c.row});
        if (change == 0.0) continue;
        double& response = response_[{source, joint, c.row}];  // in two shots: where it shows more
        response = std::max(response, c.made / (change * change));
      }
    }
  }
}

bool Showing::shows(const Run& run, double times) const {
  const auto& [source, joint, row] = run.first;
  const auto it = response_.find({source, joint, row});
  if (it == response_.end()) return false;
  const double missed = hunt_.commands().missed(source, joint, row, run.length);
  const double price =
      hunt_.price().first + static_cast<double>(run.length - 1) * hunt_.price().further;
  return it->second * missed * missed > times * price;
}

bool Showing::typically(const LostCommand& at) const {
  return shows({at, typical_}, hunt_.problem()->settings.chance.loss_shows);
}

template <class F>
void Showing::each_command(const Shot& shot, const F& f) const {
  for (const std::size_t joint : joints_) {
    for (std::size_t row = hunt_.commands().first_row(shot, joint); row < shot.window.last; ++row)
      if (hunt_.commands().changes(shot.source, joint, row))
        f(LostCommand{shot.source, joint, row});
  }
}

Showing::Split Showing::count() const {
  Split out;
  for (const Shot& shot : hunt_.problem()->shots) {
    each_command(shot, [&](const LostCommand& at) {
      Counted& one = typically(at) ? out.visible : out.hidden;
      ++one.commands;
      if (holds(hunt_.repaired().lost, at)) ++one.lost;
    });
  }
  return out;
}

double Showing::run_effect() const {
  double sum = 0.0, squares = 0.0;
  for (const Run& run : runs_) {
    const double length = static_cast<double>(run.length);
    sum += length;
    squares += length * length;
  }
  return sum > 0.0 ? squares / sum : 1.0;
}

double Showing::share_seen() const {
  double seen = 0.0, all = 0.0;
  for (const Run& run : runs_) {
    const double length = static_cast<double>(run.length);
    all += length;
    if (shows(run, 1.0)) seen += length;
  }
  return all > 0.0 ? seen / all : 0.0;
}

double Showing::chance_of_spread() const {
  std::vector<double> places(hunt_.problem()->sources.size(), 0.0), found = places;
  for (const Shot& shot : hunt_.problem()->shots) {
    bool hit = false;
    each_command(shot, [&](const LostCommand& at) {
      if (!typically(at)) return;
      places[shot.source] += 1.0;
      hit = hit || holds(hunt_.repaired().lost, at);
    });
    found[shot.source] += hit ? 1.0 : 0.0;
  }
  const double all = std::accumulate(found.begin(), found.end(), 0.0);
  const double everywhere = std::accumulate(places.begin(), places.end(), 0.0);
  double least = 1.0;
  for (std::size_t s = 0; s < places.size() && everywhere > 0.0; ++s)
    least = std::min(least, binomial_tail(found[s], all, places[s] / everywhere));
  return std::min(1.0, least * static_cast<double>(places.size()));
}

}  // namespace sanso::diagnose
