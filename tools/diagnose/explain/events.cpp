// Shots whose position error stands far above the joint's other shots: mean square m by shot,
//
//   event where m >= shot_outlier^2 u;   excess = (m - u) rows
//   u = max(1, median m, what a tolerated model scatters there)
#include "tools/diagnose/explain/events.h"

#include <algorithm>
#include <cmath>

#include "tools/diagnose/stats/robust.h"

namespace sanso::diagnose {
namespace {

/// Mean square of a channel's errors in a shot, in units of the channel's floor.
double mean_square(const Problem& problem, std::size_t channel, const Shot& shot,
                   const Eigen::VectorXd& r) {
  const Observed& c = problem->channels[channel];
  const double sigma = problem.scales.sigma[channel];
  const double unit = sigma * sigma / (c.floor * c.floor);
  return unit * rows_of(r, shot, channel).squaredNorm() / static_cast<double>(shot.rows);
}

}  // namespace

Eigen::MatrixXd mean_squares(const Problem& problem, const Eigen::VectorXd& projected) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(problem->channels.size(), problem->shots.size());
  for (std::size_t c = 0; c < problem->channels.size(); ++c) {
    if (problem->channels[c].signal != Signal::q) continue;
    for (std::size_t s = 0; s < problem->shots.size(); ++s)
      out(c, s) = mean_square(problem, c, problem->shots[s], projected);
  }
  return out;
}

std::vector<Event> find_events(const Problem& problem, const Eigen::VectorXd& projected,
                               const Eigen::MatrixXd& tolerated) {
  std::vector<Event> out;
  const double outlier = problem->settings.decisions.shot_outlier;
  for (std::size_t c = 0; c < problem->channels.size(); ++c) {
    if (problem->channels[c].signal != Signal::q) continue;
    std::vector<double> squares;
    for (const Shot& shot : problem->shots)
      squares.push_back(mean_square(problem, c, shot, projected));
    const double usual = std::max(1.0, median(squares));
    for (std::size_t s = 0; s < squares.size(); ++s) {
      double level = usual;
      if (tolerated.size() > 0) level = std::max(level, tolerated(c, s));
      if (squares[s] < outlier * outlier * level) continue;
      const double rows = static_cast<double>(problem->shots[s].rows);
      out.push_back(
          {s, problem->channels[c].joint, std::sqrt(squares[s]), (squares[s] - level) * rows});
    }
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const Event& a, const Event& b) { return a.excess > b.excess; });
  return out;
}

RepeatedEvents repeated(const std::vector<Event>& events) {
  RepeatedEvents out;
  for (const Event& first : events) {  // sorted: the first of a joint is its strongest
    const auto same = [&](const Event& e) { return e.joint == first.joint; };
    if (&first != &*std::find_if(events.begin(), events.end(), same)) continue;
    double energy = -first.excess;
    for (const Event& e : events) energy += same(e) ? e.excess : 0.0;
    if (energy > out.energy) out = {first.joint, energy};
  }
  return out;
}

std::vector<double> instants_of(const Comparison& comparison, const std::vector<Event>& events,
                                std::size_t limit) {
  std::vector<double> out;
  for (const Event& e : events) {
    const Shot& shot = comparison.shots[e.shot];
    const std::vector<double>& t = comparison.sources[shot.source].drive.t;
    const double from = t[shot.window.first], length = t[shot.window.last] - from;
    const bool known = std::any_of(out.begin(), out.end(),
                                   [&](double x) { return std::abs(x - from) < 0.5 * length; });
    if (!known && out.size() < limit) out.push_back(from);
  }
  return out;
}

}  // namespace sanso::diagnose
