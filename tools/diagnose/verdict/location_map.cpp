#include "tools/diagnose/verdict/location_map.h"

#include <algorithm>
#include <cmath>

#include "tools/diagnose/stats/significance.h"

namespace sanso::diagnose {
namespace {

/// Energy of one joint in one shot, inside and outside a regime.
struct Split {
  double in = 0.0, out = 0.0, n_in = 0.0, n_out = 0.0, sum_in = 0.0;
};

/// Calls f(shot index, row of the recording, whitened error) for every compared row of a joint's
/// position.
template <class F>
void for_rows(const Problem& problem, const Eigen::VectorXd& r, int joint, const F& f) {
  for (std::size_t c = 0; c < problem.channels.size(); ++c) {
    if (problem.channels[c].signal != Signal::q || problem.channels[c].joint != joint) continue;
    for (std::size_t s = 0; s < problem.shots.size(); ++s) {
      const Shot& shot = problem.shots[s];
      for (std::size_t k = 0; k < shot.rows; ++k) {
        f(s, shot.window.first + (k + 1) * static_cast<std::size_t>(shot.stride),
          r[static_cast<Eigen::Index>(shot.offset + c * shot.rows + k)]);
      }
    }
  }
}

LocationCell cell_of(const std::vector<Split>& shots, double total_excess) {
  LocationCell cell;
  Split all;
  for (const Split& s : shots) {
    all.in += s.in, all.out += s.out, all.n_in += s.n_in, all.n_out += s.n_out,
        all.sum_in += s.sum_in;
  }
  cell.rows = all.n_in;
  if (all.n_in < 1.0 || all.n_out < 1.0) return cell;
  const double outside = std::max(all.out / all.n_out, 1e-12);
  cell.lift = (all.in / all.n_in) / outside;
  cell.share = total_excess > 0.0 ? std::clamp((all.in - all.n_in) / total_excess, 0.0, 1.0) : 0.0;
  cell.mean = all.sum_in / all.n_in;
  // a shot is one observation: neighbouring rows of one shot are not independent
  double sum = 0.0, square = 0.0;
  for (const Split& s : shots) {
    const double d = s.in - s.n_in * outside;
    sum += d, square += d * d;
  }
  // p here; adjusted by the caller
  cell.q_value = square > 0.0 ? normal_tail(sum / std::sqrt(square)) : 1.0;
  return cell;
}

}  // namespace

LocationMap locate(const Problem& problem, const Regimes& regimes,
                   const Eigen::VectorXd& projected) {
  LocationMap map;
  const std::size_t n = problem.joints.size(), shots = problem.shots.size();
  double total_excess = 0.0;
  map.time_strip.assign(n, std::vector<double>(shots, 0.0));
  for (std::size_t j = 0; j < n; ++j) {
    std::vector<double> count(shots, 0.0);
    for_rows(problem, projected, static_cast<int>(j), [&](std::size_t s, std::size_t, double e) {
      total_excess += e * e - 1.0;
      map.time_strip[j][s] += e * e;
      count[s] += 1.0;
    });
    for (std::size_t s = 0; s < shots; ++s) map.time_strip[j][s] /= std::max(1.0, count[s]);
  }
  double elapsed = 0.0;
  for (std::size_t s = 0; s < shots; ++s) {
    const Source& source = problem.sources[static_cast<std::size_t>(problem.shots[s].source)];
    if (s > 0 && problem.shots[s].source != problem.shots[s - 1].source) {
      const Source& before = problem.sources[static_cast<std::size_t>(problem.shots[s - 1].source)];
      elapsed += before.drive.t.back() - before.drive.t.front();
    }
    map.shot_time.push_back(elapsed + source.drive.t[problem.shots[s].window.first] -
                            source.drive.t.front());
  }
  map.heat.assign(n, std::vector<double>(regimes.names.size(), NAN));
  for (std::size_t j = 0; j < n; ++j) {
    for (std::size_t g = 0; g < regimes.names.size(); ++g) {
      std::vector<Split> split(shots);
      for_rows(problem, projected, static_cast<int>(j),
               [&](std::size_t s, std::size_t row, double e) {
                 Split& here = split[s];
                 if (regimes.in(problem.shots[s].source, static_cast<int>(j), g, row)) {
                   here.in += e * e, here.n_in += 1.0, here.sum_in += e;
                 } else {
                   here.out += e * e, here.n_out += 1.0;
                 }
               });
      LocationCell cell = cell_of(split, total_excess);
      cell.where = problem.joints[j];
      cell.regime = regimes.names[g];
      if (cell.rows > 0.0) {
        double energy = 0.0;
        for (const Split& s : split) energy += s.in;
        map.heat[j][g] = energy / cell.rows;
      }
      if (cell.rows >= 20.0) map.cells.push_back(std::move(cell));
    }
  }
  std::vector<double> p;
  for (const LocationCell& c : map.cells) p.push_back(c.q_value);
  const std::vector<double> q = false_discovery_rate(p);
  for (std::size_t i = 0; i < q.size(); ++i) map.cells[i].q_value = q[i];
  std::stable_sort(map.cells.begin(), map.cells.end(),
                   [](const LocationCell& a, const LocationCell& b) {
                     const bool called_a = a.q_value < 0.05, called_b = b.q_value < 0.05;
                     return called_a != called_b ? called_a
                                                 : a.share * std::log(std::max(a.lift, 1.0)) >
                                                       b.share * std::log(std::max(b.lift, 1.0));
                   });
  return map;
}

std::string location_sentence(const LocationMap& map) {
  std::string text;
  int named = 0;
  for (const LocationCell& c : map.cells) {
    if (c.q_value >= 0.05 || c.lift < 1.2) continue;
    if (named == 0)
      text = c.where + ": " + c.regime;
    else if (c.where == map.cells.front().where)
      text += ", " + c.regime;
    if (++named == 3) break;
  }
  return named == 0 ? "spread evenly over joints and regimes" : text;
}

}  // namespace sanso::diagnose
