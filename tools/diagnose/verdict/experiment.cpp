// The menu of experiments, each tried by simulation. With c the chosen model, J the derivatives of
// the rival and d = r rival - r chosen, what the rival cannot imitate is
//
//   separation = d'Md - d'MJ (J'MJ + prior)^-1 J'Md,   nats = separation / 2, a second of recording
#include "tools/diagnose/verdict/experiment.h"

#include <fmt/format.h>
#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <functional>

#include "tools/diagnose/compare/parallel.h"

namespace sanso::diagnose {
namespace {

/// A change of the robot's settings or of its commands.
struct MenuEntry {
  std::string what;
  ExperimentKind kind;
  std::function<void(Source&)> change;
};

void scale_commands(Source& source, double amplitude, double speed) {
  for (std::size_t j = 0; j < source.drive.joints.size(); ++j) {
    std::vector<double>& command = source.drive.joints[j].command;
    double centre = 0.0, count = 0.0;
    for (const double u : command) {
      if (std::isfinite(u)) centre += u, count += 1.0;
    }
    centre /= std::max(count, 1.0);
    for (double& u : command) u = centre + amplitude * (u - centre);
    for (double& q : source.motion.q[j]) q = centre + amplitude * (q - centre);
    for (double& dq : source.motion.dq[j]) dq *= amplitude * speed;
  }
  for (double& t : source.drive.t) t /= speed;
}

std::vector<MenuEntry> menu(const Comparison& comparison) {
  const SimParams& nominal = comparison.sources.front().nominal;
  std::vector<MenuEntry> out;
  const auto each = [](const std::function<void(JointParams&)>& change) {
    return [change](Source& s) {
      for (JointParams& joint : s.nominal.joints) change(joint);
    };
  };
  const bool loop =
      std::any_of(nominal.joints.begin(), nominal.joints.end(), [](const JointParams& j) {
        return j.nominal.actuator == Actuator::dc_servo ||
               j.nominal.actuator == Actuator::position_pd;
      });
  const bool servo =
      std::any_of(nominal.joints.begin(), nominal.joints.end(),
                  [](const JointParams& j) { return j.nominal.actuator == Actuator::dc_servo; });
  if (loop) {
    out.push_back({"halve the P gain and repeat the motions", ExperimentKind::setting,
                   each([](JointParams& j) { j.nominal.p_gain *= 0.5, j.nominal.kp *= 0.5; })});
    out.push_back({"double the P gain and repeat the motions", ExperimentKind::setting,
                   each([](JointParams& j) { j.nominal.p_gain *= 2.0, j.nominal.kp *= 2.0; })});
  }
  if (servo) {
    out.push_back({"raise the supply by a tenth and repeat the motions", ExperimentKind::setting,
                   each([](JointParams& j) { j.nominal.voltage *= 1.1; })});
    out.push_back({"switch the torque off and let the joints swing from the recorded postures",
                   ExperimentKind::setting, [](Source& s) {
                     for (JointData& joint : s.drive.joints)
                       std::fill(joint.command.begin(), joint.command.end(), NAN);
                   }});
  }
  const TreeJoint& last = nominal.tree.joints.back();
  const double mass = 0.3 * std::max(last.body.mass, 0.05);
  out.push_back({fmt::format("fasten {:.2g} kg at the centre of mass of {} and repeat the motions",
                             mass, last.link),
                 ExperimentKind::setting,
                 [mass](Source& s) { s.nominal.tree.joints.back().body.mass += mass; }});
  out.push_back({"tilt the base by 20 degrees and repeat the motions", ExperimentKind::setting,
                 [](Source& s) {
                   const Vec3 g = s.nominal.gravity;
                   const double c = std::cos(0.349), si = std::sin(0.349);
                   s.nominal.gravity = {c * g[0] + si * g[2], g[1], -si * g[0] + c * g[2]};
                 }});
  if (loop) {
    out.push_back({"the same motions with half the amplitude", ExperimentKind::motion,
                   [](Source& s) { scale_commands(s, 0.5, 1.0); }});
    out.push_back({"the same motions at half the speed", ExperimentKind::motion,
                   [](Source& s) { scale_commands(s, 1.0, 0.5); }});
    out.push_back({"the same motions at 1.5 times the speed", ExperimentKind::motion,
                   [](Source& s) { scale_commands(s, 1.0, 1.5); }});
  }
  return out;
}

/// Whitened difference of two models in this experiment that `rival`'s parameters and the nuisances
/// cannot imitate, squared.
double separation(const Problem& problem, const Library& library, const Model& chosen,
                  const Model& rival) {
  const Eigen::VectorXd r_chosen = prediction_error(problem, library, chosen),
                        r_rival = prediction_error(problem, library, rival);
  const Surroundings around = make_surroundings(problem, library, rival);
  const FitResult linear = fit(around, rival, 0);
  Eigen::MatrixXd columns(r_chosen.size(), linear.J.cols() + 1);
  columns << linear.J, r_rival - r_chosen;
  const Eigen::MatrixXd gram = around.starts.gram(columns);
  const Eigen::Index n = linear.J.cols();
  const double tolerated = problem->settings.tolerances.precision;
  Eigen::MatrixXd H = gram.topLeftCorner(n, n);
  for (Eigen::Index i = 0; i < n; ++i) H(i, i) += i < linear.parameters ? 1e-6 : tolerated;
  const Eigen::VectorXd cross = gram.topRightCorner(n, 1);
  return std::max(0.0, gram(n, n) - cross.dot(H.ldlt().solve(cross)));
}

/// A few shots suffice to compare entries of the menu.
Comparison small(const Comparison& comparison) {
  Comparison out = comparison;
  const auto enough = static_cast<std::size_t>(comparison.settings.remains.experiment_shots);
  if (out.shots.size() > enough) {
    std::vector<Shot> kept;
    for (std::size_t i = 0; i < enough; ++i)
      kept.push_back(out.shots[i * out.shots.size() / enough]);
    out.shots = kept;
  }
  out.size = 0;
  for (Shot& s : out.shots) s.offset = out.size, out.size += s.rows * out.channels.size();
  return out;
}

/// Names that the data cannot tell apart, and of each finding the fitted models that stand behind
/// them: three of all findings together.
struct Undecided {
  std::vector<Model> rivals;
  std::vector<std::string> names;
};
Undecided undecided(const Library& library, const Selection& selection,
                    const std::vector<Finding>& findings) {
  Undecided out;
  std::vector<const Accepted*> named;  // the effects that became findings, in the same order
  for (const Accepted& entry : selection.accepted) {
    if (entry.contradicted.empty()) named.push_back(&entry);
  }
  for (std::size_t i = 0; i < findings.size(); ++i) {
    const std::vector<std::string>& set = findings[i].one_of;
    if (set.size() < 2) continue;
    for (const Alternative& a : named[i]->alternatives) {
      const bool listed =
          std::find(set.begin(), set.end(), library[a.candidate].effect) != set.end();
      if (listed && out.rivals.size() < 3) out.rivals.push_back(a.fit.model);
    }
    for (const std::string& name : set)
      if (std::find(out.names.begin(), out.names.end(), name) == out.names.end())
        out.names.push_back(name);
  }
  return out;
}

/// What would be recorded under this entry of the menu.
Comparison changed(Comparison out, const MenuEntry& entry) {
  for (Source& s : out.sources) entry.change(s);
  for (Shot& shot : out.shots) {
    const MeasuredMotion& motion = out.sources[shot.source].motion;
    for (std::size_t j = 0; j < motion.q.size(); ++j) {
      shot.window.q[j] = motion.q[j][shot.window.first];
      shot.window.dq[j] = motion.dq[j][shot.window.first];
    }
  }
  return out;
}

double seconds_of(const Comparison& comparison) {
  double seconds = 0.0;
  for (const Shot& s : comparison.shots) {
    const std::vector<double>& t = comparison.sources[s.source].drive.t;
    seconds += t[s.window.last] - t[s.window.first];
  }
  return seconds;
}

/// The entry that tells most in a second. A setting wins over a motion unless the motion is clearly
/// better: it changes what a motion cannot.
std::size_t best_entry(const std::vector<MenuEntry>& entries, const std::vector<double>& nats) {
  std::size_t pick = 0;
  for (std::size_t e = 1; e < entries.size(); ++e) {
    const bool motion_for_setting =
        entries[e].kind == ExperimentKind::motion && entries[pick].kind == ExperimentKind::setting;
    if (nats[e] > (motion_for_setting ? 1.5 : 1.0) * nats[pick]) pick = e;
  }
  return pick;
}

}  // namespace

const char* to_string(ExperimentKind kind) {
  return kind == ExperimentKind::motion ? "motion" : "setting";
}

std::optional<NextExperiment> next_experiment(const Problem& problem, const Library& library,
                                              const Selection& selection,
                                              const std::vector<Finding>& findings) {
  const Undecided open = undecided(library, selection, findings);
  if (open.rivals.empty()) return std::nullopt;
  const Comparison base = small(*problem);
  const double seconds = seconds_of(base);
  const std::vector<MenuEntry> entries = menu(*problem);
  std::vector<double> nats(entries.size(), 0.0);
  parallel_for(entries.size(), [&](std::size_t e) {
    const Problem tried{std::make_shared<const Comparison>(changed(base, entries[e])),
                        problem.scales, problem.correction};
    double least = INFINITY;  // the worst pair decides
    for (const Model& rival : open.rivals)
      least = std::min(least, 0.5 * separation(tried, library, selection.final.model, rival));
    nats[e] = least / std::max(seconds, 1e-9);
  });
  const std::size_t pick = best_entry(entries, nats);
  if (nats[pick] < problem->settings.next.least) return std::nullopt;
  NextExperiment best;
  best.what = entries[pick].what;
  best.kind = entries[pick].kind;
  best.separates = open.names;
  best.nats_per_second = nats[pick];
  best.seconds_to_100_to_1 = std::log(100.0) / nats[pick];
  return best;
}

}  // namespace sanso::diagnose
