// Squared errors by joint and regime, and which cells hold more than their share.
#include "tools/diagnose/verdict/location_map.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "tools/diagnose/stats/significance.h"

namespace sanso::diagnose {
namespace {

/// Energy of one joint in one shot, inside and outside a regime.
struct InAndOut {
  double in = 0.0, out = 0.0, n_in = 0.0, n_out = 0.0, sum_in = 0.0;
};

/// Calls f(shot index, row of the recording, whitened error) for every compared row of a joint's
/// position.
template <class F>
void for_rows(const Comparison& comparison, const Eigen::VectorXd& r, std::size_t joint,
              const F& f) {
  for (std::size_t c = 0; c < comparison.channels.size(); ++c) {
    if (comparison.channels[c].signal != Signal::q || comparison.channels[c].joint != joint)
      continue;
    for (std::size_t s = 0; s < comparison.shots.size(); ++s) {
      const Shot& shot = comparison.shots[s];
      const auto errors = rows_of(r, shot, c);
      for (std::size_t k = 0; k < shot.rows; ++k) f(s, recorded_row(shot, k), errors[k]);
    }
  }
}

struct TimeStrip {
  std::vector<std::vector<double>> squares;  // LocationMap::time_strip
  double excess = 0.0;                       // energy beyond noise of all joints, sum (e^2 - 1)
};

/// Mean squares of each joint's errors by shot.
TimeStrip time_strip(const Comparison& comparison, const Eigen::VectorXd& projected) {
  const std::size_t n = comparison.joints.size(), shots = comparison.shots.size();
  TimeStrip out;
  out.squares.assign(n, std::vector<double>(shots, 0.0));
  for (std::size_t j = 0; j < n; ++j) {
    std::vector<double> count(shots, 0.0);
    for_rows(comparison, projected, j, [&](std::size_t s, std::size_t, double e) {
      out.excess += e * e - 1.0;
      out.squares[j][s] += e * e;
      count[s] += 1.0;
    });
    for (std::size_t s = 0; s < shots; ++s) out.squares[j][s] /= std::max(1.0, count[s]);
  }
  return out;
}

/// When each shot begins, recordings one after the other, s.
std::vector<double> times_of_shots(const Comparison& comparison) {
  std::vector<double> out;
  double elapsed = 0.0;
  for (std::size_t s = 0; s < comparison.shots.size(); ++s) {
    const Source& source = comparison.sources[comparison.shots[s].source];
    if (s > 0 && comparison.shots[s].source != comparison.shots[s - 1].source) {
      const Source& before = comparison.sources[comparison.shots[s - 1].source];
      elapsed += before.drive.t.back() - before.drive.t.front();
    }
    out.push_back(elapsed + source.drive.t[comparison.shots[s].window.first] -
                  source.drive.t.front());
  }
  return out;
}

/// One joint's errors by shot, in a regime and out of it.
std::vector<InAndOut> in_and_out(const Comparison& comparison, const Regimes& regimes,
                                 const Eigen::VectorXd& projected, std::size_t joint,
                                 std::size_t regime) {
  std::vector<InAndOut> out(comparison.shots.size());
  for_rows(comparison, projected, joint, [&](std::size_t s, std::size_t row, double e) {
    InAndOut& here = out[s];
    if (regimes.in(comparison.shots[s].source, joint, regime, row)) {
      here.in += e * e, here.n_in += 1.0, here.sum_in += e;
    } else {
      here.out += e * e, here.n_out += 1.0;
    }
  });
  return out;
}

/// The cells with q for p, sorted: called ones first (q < 0.05), then by share log(lift).
std::vector<LocationCell> called(std::vector<LocationCell> cells) {
  std::vector<double> p;
  p.reserve(cells.size());
  for (const LocationCell& c : cells) p.push_back(c.q_value);
  const std::vector<double> q = false_discovery_rate(p);
  for (std::size_t i = 0; i < q.size(); ++i) cells[i].q_value = q[i];
  std::stable_sort(cells.begin(), cells.end(), [](const LocationCell& a, const LocationCell& b) {
    const bool called_a = a.q_value < 0.05, called_b = b.q_value < 0.05;
    return called_a != called_b ? called_a
                                : a.share * std::log(std::max(a.lift, 1.0)) >
                                      b.share * std::log(std::max(b.lift, 1.0));
  });
  return cells;
}

/// One cell from its shots s, e in noise levels, n rows; `in` and `out` are sums of e^2:
///
///   lift  = (in / n_in) / (out / n_out)
///   share = (in - n_in) / total_excess                       clamped to [0, 1]
///   z     = sum_s d_s / sqrt(sum_s d_s^2),  d_s = in_s - n_in_s (out / n_out)
///
/// A shot is one observation: neighbouring rows of one shot are not independent. q_value holds
/// p = P(N(0, 1) > z) until the caller adjusts it over all cells.
LocationCell cell_of(const std::vector<InAndOut>& shots, double total_excess) {
  LocationCell cell;
  InAndOut all;
  for (const InAndOut& s : shots) {
    all.in += s.in, all.out += s.out, all.n_in += s.n_in, all.n_out += s.n_out,
        all.sum_in += s.sum_in;
  }
  cell.rows = all.n_in;
  if (all.n_in < 1.0 || all.n_out < 1.0) return cell;
  const double outside = std::max(all.out / all.n_out, 1e-12);
  cell.lift = (all.in / all.n_in) / outside;
  cell.share = total_excess > 0.0 ? std::clamp((all.in - all.n_in) / total_excess, 0.0, 1.0) : 0.0;
  cell.mean = all.sum_in / all.n_in;
  double sum = 0.0, square = 0.0;
  for (const InAndOut& s : shots) {
    const double d = s.in - s.n_in * outside;
    sum += d, square += d * d;
  }
  cell.q_value = square > 0.0 ? normal_tail(sum / std::sqrt(square)) : 1.0;
  return cell;
}

}  // namespace

LocationMap locate(const Comparison& comparison, const Regimes& regimes,
                   const Eigen::VectorXd& projected) {
  LocationMap map;
  const std::size_t n = comparison.joints.size();
  TimeStrip strip = time_strip(comparison, projected);
  map.time_strip = std::move(strip.squares);
  map.shot_time = times_of_shots(comparison);
  map.heat.assign(n, std::vector<double>(regimes.names.size(), NAN));
  for (std::size_t j = 0; j < n; ++j) {
    for (std::size_t g = 0; g < regimes.names.size(); ++g) {
      const std::vector<InAndOut> shots = in_and_out(comparison, regimes, projected, j, g);
      LocationCell cell = cell_of(shots, strip.excess);
      cell.where = comparison.joints[j];
      cell.regime = regimes.names[g];
      if (cell.rows > 0.0) {
        double energy = 0.0;
        for (const InAndOut& s : shots) energy += s.in;
        map.heat[j][g] = energy / cell.rows;
      }
      if (cell.rows >= 20.0) map.cells.push_back(std::move(cell));
    }
  }
  map.cells = called(std::move(map.cells));
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
