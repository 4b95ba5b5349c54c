// Command against position: sign, swapped joints, a command that is only a copy.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/diagnose/gate/checks.h"
#include "tools/diagnose/stats/robust.h"

namespace sanso::diagnose::gate {
namespace {

/// Largest correlation of position with the command delayed by up to `answer_delay`, on changes
/// over 0.2 s (what a tracking servo must show, whatever its delay, friction or load).
double tracking(const GateRecording& r, const GateChannel& q, const GateChannel& u,
                const GateSettings& settings) {
  const double interval = std::max(sampling_interval(r.t), 1e-6);
  const auto stride = std::max<std::size_t>(1, static_cast<std::size_t>(0.2 / interval));
  double strongest = 0.0;
  for (double lag = 0.0; lag <= settings.answer_delay; lag += settings.answer_delay / 8.0) {
    const auto shift = static_cast<std::size_t>(lag / interval);
    std::vector<double> dq, du;
    for (std::size_t i = shift + stride; i < q.values.size();
         i += std::max<std::size_t>(1, stride / 4)) {
      dq.push_back(q.values[i] - q.values[i - stride]);
      du.push_back(u.values[i - shift] - u.values[i - shift - stride]);
    }
    const double c = correlation(dq, du);
    if (std::abs(c) > std::abs(strongest)) strongest = c;
  }
  return strongest;
}

bool is_copy(const GateChannel& q, const GateChannel& u) {
  // equal to the last digit in nearly every moving row, at the same row or a fixed shift of up to 3
  // rows
  for (std::size_t shift = 0; shift <= 3; ++shift) {
    std::size_t moving = 0, equal = 0;
    for (std::size_t i = shift + 1; i < q.values.size(); ++i) {
      if (q.values[i] == q.values[i - 1] || !std::isfinite(u.values[i - shift])) continue;
      ++moving;
      if (q.values[i] == u.values[i - shift]) ++equal;
    }
    if (moving > 20 && static_cast<double>(equal) > 0.95 * static_cast<double>(moving)) return true;
  }
  return false;
}

/// The model's joint that follows another joint's command, and the other way round.
std::vector<Defect> check_swaps(const GateRecording& r, const std::vector<GateJoint>& joints,
                                const GateSettings& settings) {
  std::vector<Defect> out;
  const std::size_t n = joints.size();
  std::vector<std::vector<double>> follows(n, std::vector<double>(n, 0.0));
  const auto channel = [&](const char* kind, std::size_t j) {
    return r.find(kind + joints[j].name);
  };
  std::vector<bool> own_fails(n, false);
  for (std::size_t j = 0; j < n; ++j) {
    const GateChannel* q = channel("q:", j);
    const GateChannel* u = channel("u:", j);
    if (q == nullptr || u == nullptr) continue;
    follows[j][j] = tracking(r, *q, *u, settings);
    own_fails[j] = std::abs(follows[j][j]) < settings.does_not_answer;
  }
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = i + 1; j < n; ++j) {
      if (!own_fails[i] || !own_fails[j]) continue;
      const double ij = tracking(r, *channel("q:", i), *channel("u:", j), settings);
      const double ji = tracking(r, *channel("q:", j), *channel("u:", i), settings);
      if (ij > settings.answers && ji > settings.answers) {
        out.push_back(
            {r.file, "q:" + joints[i].name, -1, defect::kSwapped,
             fmt::format("q:{} follows u:{} and q:{} follows u:{} (correlation {:.2f}, {:.2f})",
                         joints[i].name, joints[j].name, joints[j].name, joints[i].name, ij, ji)});
      }
    }
  }
  return out;
}

}  // namespace

std::vector<Defect> check_commands(const GateRecording& r, const Joints& joints,
                                   const GateSettings& settings) {
  std::vector<Defect> out;
  for (const GateJoint& joint : joints) {
    const GateChannel* q = r.find("q:" + joint.name);
    const GateChannel* u = r.find("u:" + joint.name);
    if (q == nullptr || u == nullptr) continue;
    if (is_copy(*q, *u)) {
      out.push_back(
          {r.file, u->name, -1, defect::kCommandIsCopy,
           "the goal equals the measured position to the last digit; record what was sent to the "
           "servo"});
      continue;
    }
    const double follows = tracking(r, *q, *u, settings);
    if (follows < -settings.answers) {
      out.push_back(
          {r.file, q->name, -1, defect::kWrongSign,
           fmt::format(
               "the position moves against the command (correlation {:.2f}); flip the sign of one "
               "of them",
               follows)});
    }
  }
  append(out, check_swaps(r, joints, settings));
  return out;
}

std::vector<Defect> check_velocity_swaps(const GateRecording& r, const Joints& joints,
                                         const GateSettings& settings) {
  std::vector<Defect> out;
  const auto derivative_matches = [&](std::size_t i, std::size_t j) {
    const GateChannel* q = r.find("q:" + joints[i].name);
    const GateChannel* dq = r.find("dq:" + joints[j].name);
    if (q == nullptr || dq == nullptr) return 0.0;
    const auto stride = std::max<std::size_t>(
        1, static_cast<std::size_t>(0.03 / std::max(sampling_interval(r.t), 1e-6)));
    std::vector<double> a, b;
    for (std::size_t k = stride; k + stride < q->values.size(); k += stride) {
      a.push_back((q->values[k + stride] - q->values[k - stride]) /
                  (r.t[k + stride] - r.t[k - stride]));
      b.push_back(dq->values[k]);
    }
    return correlation(a, b);
  };
  for (std::size_t i = 0; i < joints.size(); ++i) {
    for (std::size_t j = i + 1; j < joints.size(); ++j) {
      // links that swing against each other have velocities of the other's sign
      if (derivative_matches(i, i) > settings.does_not_answer ||
          derivative_matches(j, j) > settings.does_not_answer) {
        continue;
      }
      const double ij = derivative_matches(i, j), ji = derivative_matches(j, i);
      if (ij > settings.answers && ji > settings.answers) {
        out.push_back(
            {r.file, "q:" + joints[i].name, -1, defect::kSwapped,
             fmt::format("d(q:{})/dt is dq:{} and the other way round (correlation {:.2f}, {:.2f})",
                         joints[i].name, joints[j].name, ij, ji)});
      }
    }
  }
  return out;
}

}  // namespace sanso::diagnose::gate
