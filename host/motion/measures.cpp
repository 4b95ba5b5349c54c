// A new measure is a function and a row of the table; motion files name it, docs/motions.md
// explains it.
#include "host/motion/measures.h"

#include <algorithm>
#include <cmath>

namespace sanso::motion {
namespace {

constexpr double kDegree = M_PI / 180.0;
constexpr double kGroundClearance_m = 0.003;  // below it a sole counts as on the ground
constexpr double kStepClearance_m = 0.005;    // a swing lower than this is no step
constexpr double kShortestSwing_s = 0.05;
constexpr double kFlight_s = 0.02;

using Samples = std::vector<EpisodeSample>;

const EpisodeSample& first(const MeasureInput& in) { return in.episode.samples.front(); }
const EpisodeSample& last(const MeasureInput& in) { return in.episode.samples.back(); }

const model::State& reference_at(const MeasureInput& in, std::size_t k) {
  return in.reference.x[std::min(k, in.reference.x.size() - 1)];
}

template <class Value>
double largest(const MeasureInput& in, Value&& value) {
  double most = -std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < in.episode.samples.size(); ++k) {
    const double v = value(in.episode.samples[k], k);
    if (std::isnan(v)) return v;
    most = std::max(most, v);
  }
  return most;
}

bool in_window(const MeasureInput& in, std::size_t k) {
  const double t = static_cast<double>(k) * in.episode.dt_s;
  return t >= in.window.from_s && t <= in.window.to_s;
}

/// Share of the samples in the window for which `holds` (NaN when a sample is unknown or the window
/// was not reached).
template <class Holds>
double share(const MeasureInput& in, Holds&& holds) {
  int all = 0, good = 0;
  for (std::size_t k = 0; k < in.episode.samples.size(); ++k) {
    if (!in_window(in, k)) continue;
    const EpisodeSample& s = in.episode.samples[k];
    if (std::isnan(s.foot_load_N[0] + s.foot_load_N[1])) return EpisodeSample::kUnknown;
    ++all;
    good += holds(s) ? 1 : 0;
  }
  return all > 0 ? static_cast<double>(good) / all : EpisodeSample::kUnknown;
}

/// Longest unbroken time in seconds for which `holds`.
template <class Holds>
double longest(const MeasureInput& in, Holds&& holds) {
  int run = 0, best = 0;
  for (const EpisodeSample& s : in.episode.samples) {
    run = holds(s) ? run + 1 : 0;
    best = std::max(best, run);
  }
  return best * in.episode.dt_s;
}

// --- upright ---

double cost(const MeasureInput& in) { return in.episode.cost; }

double completed(const MeasureInput& in) { return in.episode.completed ? 1.0 : 0.0; }

double tilt_deg(const MeasureInput& in) {
  return largest(in, [](const EpisodeSample& s, std::size_t) {
    const math::Mat3 R = math::rotation_matrix(model::base_quat(s.x));
    return std::acos(std::clamp(R(2, 2), -1.0, 1.0)) / kDegree;
  });
}

double base_height_m(const MeasureInput& in) {
  return -largest(in, [](const EpisodeSample& s, std::size_t) { return -s.x[2]; });
}

double below_reference_m(const MeasureInput& in) {
  return largest(
      in, [&](const EpisodeSample& s, std::size_t k) { return reference_at(in, k)[2] - s.x[2]; });
}

double base_drift_m(const MeasureInput& in) {
  return largest(in, [&](const EpisodeSample& s, std::size_t) {
    return (s.x.head<2>() - first(in).x.head<2>()).norm();
  });
}

double yaw_deg(const MeasureInput& in) {
  return largest(in, [&](const EpisodeSample& s, std::size_t k) {
    return std::abs(
               math::quat_minus(model::base_quat(s.x), model::base_quat(reference_at(in, k)))[2]) /
           kDegree;
  });
}

// --- on a profile ---

/// Angle of the base's vertical to the normal of the surface below the base.
double surface_tilt_deg(const MeasureInput& in) {
  return largest(in, [&](const EpisodeSample& s, std::size_t) {
    const double slope = model::ground_slope(in.ground, s.x[0]);
    const math::Vec3 normal = math::Vec3(-slope, 0.0, 1.0).normalized();
    const math::Vec3 up = math::rotation_matrix(model::base_quat(s.x)).col(2);
    return std::acos(std::clamp(up.dot(normal), -1.0, 1.0)) / kDegree;
  });
}

/// Distance of the base from the surface's tangent below it.
double above_surface_m(const MeasureInput& in) {
  return -largest(in, [&](const EpisodeSample& s, std::size_t) {
    const double slope = model::ground_slope(in.ground, s.x[0]);
    return (model::ground_height(in.ground, s.x[0]) - s.x[2]) / std::sqrt(1.0 + slope * slope);
  });
}

double place_m(const MeasureInput& in) {
  return largest(in, [](const EpisodeSample& s, std::size_t) { return s.x[0]; });
}

double speed_share(const MeasureInput& in) {
  const auto speed = [](const model::State& x) { return x.segment<3>(model::kXVel).norm(); };
  double most = 0.0;
  for (const model::State& x : in.reference.x) most = std::max(most, speed(x));
  return largest(in, [&](const EpisodeSample& s, std::size_t) { return speed(s.x); }) / most;
}

// --- feet ---

double both_feet_loaded_share(const MeasureInput& in) {
  return share(in, [](const EpisodeSample& s) {
    return s.foot_load_N[0] > kUnloaded_N && s.foot_load_N[1] > kUnloaded_N;
  });
}

double double_support_share(const MeasureInput& in) { return both_feet_loaded_share(in); }

double stance_share(const MeasureInput& in) {
  return std::max(share(in, [](const EpisodeSample& s) { return s.foot_load_N[0] > kUnloaded_N; }),
                  share(in, [](const EpisodeSample& s) { return s.foot_load_N[1] > kUnloaded_N; }));
}

double longest_gap_s(const MeasureInput& in) {
  return std::max(
      longest(in,
              [](const EpisodeSample& s) { return s.foot_clearance_m[0] > kGroundClearance_m; }),
      longest(in,
              [](const EpisodeSample& s) { return s.foot_clearance_m[1] > kGroundClearance_m; }));
}

double foot_slip_m(const MeasureInput& in) {
  return largest(in, [&](const EpisodeSample& s, std::size_t) {
    return std::max((s.foot_m[0] - first(in).foot_m[0]).norm(),
                    (s.foot_m[1] - first(in).foot_m[1]).norm());
  });
}

// --- swaying, squatting ---

double amplitude(const std::vector<double>& values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return *high - *low;
}

struct LateralPaths {
  std::vector<double> robot, reference;
};
LateralPaths lateral_paths(const MeasureInput& in) {
  LateralPaths paths;
  for (std::size_t k = 0; k < in.episode.samples.size(); ++k) {
    paths.robot.push_back(in.episode.samples[k].x[1]);
    paths.reference.push_back(reference_at(in, k)[1]);
  }
  return paths;
}

double lateral_amplitude_share(const MeasureInput& in) {
  const LateralPaths paths = lateral_paths(in);
  return amplitude(paths.robot) / amplitude(paths.reference);
}

double lateral_correlation(const MeasureInput& in) {
  const LateralPaths paths = lateral_paths(in);
  const auto n = static_cast<double>(paths.robot.size());
  double sr = 0, sd = 0, srr = 0, sdd = 0, srd = 0;
  for (std::size_t k = 0; k < paths.robot.size(); ++k) {
    const double r = paths.reference[k], d = paths.robot[k];
    sr += r;
    sd += d;
    srr += r * r;
    sdd += d * d;
    srd += r * d;
  }
  return (n * srd - sr * sd) / std::sqrt((n * srr - sr * sr) * (n * sdd - sd * sd));
}

double depth_share(const MeasureInput& in) {
  double lowest = first(in).x[2], lowest_reference = in.reference.x.front()[2];
  for (const auto& s : in.episode.samples) lowest = std::min(lowest, s.x[2]);
  for (const auto& x : in.reference.x) lowest_reference = std::min(lowest_reference, x[2]);
  return (first(in).x[2] - lowest) / (in.reference.x.front()[2] - lowest_reference);
}

double return_height_error_m(const MeasureInput& in) {
  return std::abs(last(in).x[2] - first(in).x[2]);
}

// --- one leg ---

constexpr double kLift_m = 0.010;

double longest_lift_s(const MeasureInput& in) {
  return longest(in, [](const EpisodeSample& s) {
    return std::max(s.foot_clearance_m[0], s.foot_clearance_m[1]) >= kLift_m;
  });
}

/// Of the moments with a foot up: those in which the other sole, and only it, carries. Ground only
/// pushes, so the centre of pressure is then inside that sole.
double single_support_share(const MeasureInput& in) {
  int all = 0, single = 0;
  for (const EpisodeSample& s : in.episode.samples) {
    const int up = s.foot_clearance_m[1] > s.foot_clearance_m[0] ? 1 : 0;
    if (!(s.foot_clearance_m[up] >= kLift_m)) continue;
    if (std::isnan(s.foot_load_N[0] + s.foot_load_N[1])) return EpisodeSample::kUnknown;
    ++all;
    single += s.foot_load_N[up] < kUnloaded_N && s.foot_load_N[1 - up] > kUnloaded_N ? 1 : 0;
  }
  return all > 0 ? static_cast<double>(single) / all : EpisodeSample::kUnknown;
}

// --- gaits ---

struct Step {
  int side;
  double peak_m, from_s, to_s;
};
/// Swings: a sole clear of the ground for at least 50 ms, in order of lifting.
std::vector<Step> steps(const MeasureInput& in) {
  std::vector<Step> found;
  const Samples& samples = in.episode.samples;
  for (int side : {0, 1}) {
    for (std::size_t k = 0; k < samples.size(); ++k) {
      if (!(samples[k].foot_clearance_m[side] > kGroundClearance_m)) continue;
      Step step{side, 0.0, static_cast<double>(k) * in.episode.dt_s, 0.0};
      for (; k < samples.size() && samples[k].foot_clearance_m[side] > kGroundClearance_m; ++k) {
        step.peak_m = std::max(step.peak_m, samples[k].foot_clearance_m[side]);
      }
      step.to_s = static_cast<double>(k) * in.episode.dt_s;
      if (step.to_s - step.from_s >= kShortestSwing_s) found.push_back(step);
    }
  }
  std::sort(found.begin(), found.end(),
            [](const Step& a, const Step& b) { return a.from_s < b.from_s; });
  return found;
}

double step_count(const MeasureInput& in) {
  const auto all = steps(in);
  return static_cast<double>(std::count_if(
      all.begin(), all.end(), [](const Step& s) { return s.peak_m >= kStepClearance_m; }));
}

double lowest_step_clearance_m(const MeasureInput& in) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const Step& s : steps(in)) lowest = std::min(lowest, s.peak_m);
  return std::isfinite(lowest) ? lowest : EpisodeSample::kUnknown;
}

/// Unit vector of the reference's travel.
Eigen::Vector2d travel(const MeasureInput& in) {
  const Eigen::Vector2d d = in.reference.x.back().head<2>() - in.reference.x.front().head<2>();
  return d.normalized();
}

double distance_share(const MeasureInput& in) {
  const Eigen::Vector2d wanted = in.reference.x.back().head<2>() - in.reference.x.front().head<2>();
  return travel(in).dot(last(in).x.head<2>() - first(in).x.head<2>()) / wanted.norm();
}

/// Largest deviation from the reference across its travel: weight shifts belong to the gait and are
/// no drift.
double cross_drift_m(const MeasureInput& in) {
  const Eigen::Vector2d along = travel(in), across(-along.y(), along.x());
  return largest(in, [&](const EpisodeSample& s, std::size_t k) {
    return std::abs(across.dot(s.x.head<2>() - reference_at(in, k).head<2>()));
  });
}

double airborne_s(const MeasureInput& in) {
  int run = 0, best = 0;
  for (const EpisodeSample& s : in.episode.samples) {
    if (std::isnan(s.foot_load_N[0] + s.foot_load_N[1])) return EpisodeSample::kUnknown;
    run = s.foot_load_N[0] < kUnloaded_N && s.foot_load_N[1] < kUnloaded_N ? run + 1 : 0;
    best = std::max(best, run);
  }
  return best * in.episode.dt_s;
}

/// Flights (both soles unloaded for 20 ms) over steps, in the window.
double flight_share(const MeasureInput& in) {
  int flights = 0, run = 0;
  for (std::size_t k = 0; k < in.episode.samples.size(); ++k) {
    const EpisodeSample& s = in.episode.samples[k];
    if (std::isnan(s.foot_load_N[0] + s.foot_load_N[1])) return EpisodeSample::kUnknown;
    run = in_window(in, k) && s.foot_load_N[0] < kUnloaded_N && s.foot_load_N[1] < kUnloaded_N
              ? run + 1
              : 0;
    if (run == static_cast<int>(std::lround(kFlight_s / in.episode.dt_s))) ++flights;
  }
  const double count = step_count(in);
  return count > 0 ? flights / count : 0.0;
}

}  // namespace

const std::vector<Measure>& measures() {
  static const std::vector<Measure> kMeasures = {
      {"cost", "J of the trial", cost},
      {"completed", "1 when the trial ran to its last tick", completed},
      {"tilt_deg", "largest angle of the base's vertical to the world's [deg]", tilt_deg},
      {"base_height_m", "lowest height of the base [m]", base_height_m},
      {"below_reference_m", "largest drop of the base below its reference [m]", below_reference_m},
      {"surface_tilt_deg", "largest angle of the base's vertical to the surface's normal [deg]",
       surface_tilt_deg},
      {"above_surface_m", "lowest distance of the base from the surface's tangent [m]",
       above_surface_m},
      {"place_m", "farthest place along x [m]", place_m},
      {"speed_share", "largest speed over the reference's", speed_share},
      {"base_drift_m", "largest horizontal distance of the base from its start [m]", base_drift_m},
      {"yaw_deg", "largest heading error to the reference [deg]", yaw_deg},
      {"both_feet_loaded_share", "share of the moving time with both soles loaded above 1 N",
       both_feet_loaded_share},
      {"double_support_share", "the same, read as the double support of a run",
       double_support_share},
      {"stance_share", "share of the moving time that the busier foot is loaded", stance_share},
      {"longest_gap_s", "longest time a sole is more than 3 mm off the ground [s]", longest_gap_s},
      {"foot_slip_m", "largest displacement of a foot from its start [m]", foot_slip_m},
      {"lateral_amplitude_share", "side-to-side amplitude over the reference's",
       lateral_amplitude_share},
      {"lateral_correlation", "correlation of the base's lateral path with the reference",
       lateral_correlation},
      {"depth_share", "depth of the base over the reference's", depth_share},
      {"return_height_error_m", "height at the end against the start [m]", return_height_error_m},
      {"longest_lift_s", "longest time a sole is 10 mm clear without a break [s]", longest_lift_s},
      {"single_support_share",
       "with a foot up: share of the time that the other sole alone carries", single_support_share},
      {"steps", "swings of at least 5 mm", step_count},
      {"lowest_step_clearance_m", "highest point of the lowest swing [m]", lowest_step_clearance_m},
      {"distance_share", "distance along the reference's travel over its own", distance_share},
      {"cross_drift_m", "largest deviation from the reference across its travel [m]",
       cross_drift_m},
      {"airborne_s", "longest time both feet are loaded by less than 1 N [s]", airborne_s},
      {"flight_share", "flights of at least 20 ms per step", flight_share},
  };
  return kMeasures;
}

const Measure* find_measure(const std::string& name) {
  for (const Measure& m : measures()) {
    if (name == m.name) return &m;
  }
  return nullptr;
}

}  // namespace sanso::motion
