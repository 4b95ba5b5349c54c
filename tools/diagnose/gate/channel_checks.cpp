// Checks inside one channel: wrapped registers, clipped and stuck values.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tools/diagnose/gate/checks.h"
#include "tools/diagnose/gate/noise.h"
#include "tools/diagnose/stats/robust.h"

namespace sanso::diagnose::gate {

namespace {

/// How a sample stands among its four neighbours.
struct Neighbours {
  double centre = 0.0;     // median of five
  double departure = 0.0;  // of the sample from it
  double step = 0.0;       // largest step between neighbours, on either side and across the sample
};
Neighbours neighbours_of(std::span<const double> v, std::size_t i) {
  double w[5] = {v[i - 2], v[i - 1], v[i], v[i + 1], v[i + 2]};
  std::sort(w, w + 5);
  return {w[2], std::abs(v[i] - w[2]),
          std::max({std::abs(v[i - 1] - v[i - 2]), std::abs(v[i + 2] - v[i + 1]),
                    std::abs(v[i + 1] - v[i - 1])})};
}

}  // namespace

std::vector<double> without_glitches(std::span<const double> x, int* replaced,
                                     const GateSettings& settings) {
  std::vector<double> out(x.begin(), x.end()), v;
  std::vector<std::size_t> rows;  // of the samples that there are
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (std::isfinite(x[i])) v.push_back(x[i]), rows.push_back(i);
  }
  std::vector<Neighbours> around(v.size());
  std::vector<double> departures;  // rows at rest would make the limit that of rest alone
  for (std::size_t i = 2; i + 2 < v.size(); ++i) {
    around[i] = neighbours_of(v, i);
    if (around[i].step > 0.0 || around[i].departure > 0.0)
      departures.push_back(around[i].departure);
  }
  std::vector<double> steps;
  for (std::size_t i = 1; i < v.size(); ++i) {
    if (v[i] != v[i - 1]) steps.push_back(std::abs(v[i] - v[i - 1]));
  }
  int count = 0;
  if (!departures.empty()) {
    const double usual =
        settings.glitch_deviations * (robust_sigma(departures) + quantile(departures, 0.9));
    const double floor = std::max(usual, settings.glitch_quanta * quantile(steps, 0.1));
    for (std::size_t i = 2; i + 2 < v.size(); ++i) {
      // what moves past its neighbours at the speed that they have, or turns there, is motion
      const double limit = std::max(floor, settings.glitch_steps * around[i].step);
      if (around[i].departure > limit) out[rows[i]] = around[i].centre, ++count;
    }
  }
  if (replaced != nullptr) *replaced = count;
  return out;
}

namespace {

/// First row where the step to the next finite value is `size` (within 5 %); -1: none. A wrap is a
/// jump of one sample, several times larger than anything next to it.
long first_jump(std::span<const double> x, double size) {
  double previous = NAN, before = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (!std::isfinite(x[i])) continue;
    if (std::isfinite(previous)) {
      const double step = x[i] - previous;
      if (std::abs(std::abs(step) - size) < 0.05 * size &&
          std::abs(step) > 4.0 * std::abs(before)) {
        return static_cast<long>(i);
      }
      before = step;
    }
    previous = x[i];
  }
  return -1;
}

/// Signed 16-bit register logged as unsigned: the channel leaps by 65536 of its own quanta, or is
/// larger than it can be.
std::optional<Defect> check_16_bit(const GateRecording& r, const GateChannel& c) {
  const double quantum = quantisation_step(c.values);
  if (quantum > 0.0) {
    const double low = quantile(c.values, 0.0), high = quantile(c.values, 1.0);
    if (high - low > 60000.0 * quantum) {
      const long row = first_jump(c.values, high - low);
      if (row >= 0) {
        return Defect{
            r.file, c.name, row, defect::k16BitWrap,
            fmt::format("jumps by {:.6g} = {:.0f} register steps; log the register as signed",
                        high - low, (high - low) / quantum)};
      }
    }
  }
  if (c.name.rfind("pwm:", 0) != 0) return std::nullopt;
  for (std::size_t i = 0; i < c.values.size(); ++i) {
    const double v = std::abs(c.values[i]);
    if (!(v > 1.2)) continue;
    // 65536 counts are 74 times full scale for 885 counts a unit, 64 for 1000; a percentage or raw
    // count is smaller or has no empty space between
    const bool leap = v > 20.0 && quantile(c.values, 0.5) < 0.2 * v;
    return Defect{r.file, c.name, static_cast<long>(i),
                  leap ? defect::k16BitWrap : defect::kWrongUnit,
                  fmt::format("duty {:.4g}; expected -1..1", c.values[i])};
  }
  return std::nullopt;
}

}  // namespace

std::vector<Defect> check_wraps(const GateRecording& r, const Joints& joints,
                                const GateSettings& /*settings*/) {
  std::vector<Defect> out;
  for (const GateJoint& joint : joints) {
    const GateChannel* q = r.find("q:" + joint.name);
    if (q != nullptr && !joint.prismatic) {
      const long row = first_jump(q->values, 2.0 * std::numbers::pi);
      if (row >= 0) {
        out.push_back(
            {r.file, q->name, row, defect::kEncoderWrap,
             "the angle jumps by one turn in one sample; unwrap it (add or subtract 2 pi from "
             "there on)"});
      }
    }
    for (const char* kind : {"pwm:", "i:", "tau:", "dq:", "q:"}) {
      const GateChannel* c = r.find(kind + joint.name);
      if (c != nullptr) append(out, check_16_bit(r, *c));
    }
  }
  return out;
}

namespace {

double range_of(std::span<const double> x) { return quantile(x, 1.0) - quantile(x, 0.0); }

/// Runs of exactly `extreme`, entered and left at speed while the command (when there is one) moved
/// on. A mechanical stop also holds a position, but it is left slowly; a servo at rest does not
/// move either, but then its command rests too.
int flat_tops(std::span<const double> x, std::span<const double> u, double extreme, double fast,
              const GateSettings& settings, long* first) {
  const auto least = static_cast<std::size_t>(settings.flat_rows),
             approach = static_cast<std::size_t>(settings.flat_position_approach);
  const auto rows = static_cast<double>(approach);
  int runs = 0;
  for (std::size_t i = approach + 1; i + 1 < x.size(); ++i) {
    if (x[i] != extreme || x[i - 1] == extreme) continue;
    std::size_t end = i;
    while (end < x.size() && x[end] == extreme) ++end;
    if (end - i < least || end + approach >= x.size()) continue;
    // mean speed over the samples before and after the run (the crossing sample itself is cut
    // short)
    const double entry = std::abs(x[i - 1] - x[i - 1 - approach]) / rows,
                 exit = std::abs(x[end + approach] - x[end]) / rows;
    // rows in which the command moves: a held goal makes a flat top of its own
    std::size_t changes = 0;
    for (std::size_t k = i; k < end && !u.empty(); ++k) changes += u[k] != u[k - 1];
    const bool rests = !u.empty() && 2 * changes < end - i;
    if (!(entry > fast) || !(exit > fast) || rests) continue;
    if (runs++ == 0) *first = static_cast<long>(i);
  }
  return runs;
}

}  // namespace

std::vector<Defect> check_clipping(const GateRecording& r, const Joints& joints,
                                   const GateSettings& settings) {
  std::vector<Defect> out;
  for (const GateJoint& joint : joints) {
    const GateChannel* q = r.find("q:" + joint.name);
    const GateChannel* u = r.find("u:" + joint.name);
    if (q == nullptr ||
        finite_values(q->values).size() < static_cast<std::size_t>(settings.least_rows))
      continue;
    std::vector<double> steps;
    for (std::size_t i = 1; i < q->values.size(); ++i)
      steps.push_back(std::abs(q->values[i] - q->values[i - 1]));
    const double fast = std::max(0.4 * quantile(steps, 0.9), 0.5 * quantisation_step(q->values));
    for (const double extreme : {quantile(q->values, 0.0), quantile(q->values, 1.0)}) {
      long first = -1;
      const int runs = flat_tops(q->values, u != nullptr ? u->values : std::span<const double>{},
                                 extreme, fast, settings, &first);
      if (runs < settings.flat_tops) continue;
      out.push_back(
          {r.file, q->name, first, defect::kClipped,
           fmt::format(
               "{} flat tops at {:.6g}, entered and left at speed; raise the logger's range", runs,
               extreme)});
      break;
    }
  }
  return out;
}

namespace {

/// Evidence, gathered while a position does not change at all, that the joint must have moved.
class Hang {
 public:
  Hang(double t, double u) : start_(t), u_start_(u) {}
  void add(double t, double u, double dq, double step, double command_range) {
    if (std::isfinite(dq)) travel_ += std::abs(dq) * step;
    if (!std::isfinite(u_start_)) u_start_ = u;
    if (std::abs(u - u_start_) > 0.5 * command_range) away_ += step;
    last_ = t;
  }
  double seconds() const { return last_ - start_; }
  /// Long against what friction or play can hold: the command stayed half its range away for half a
  /// second, or the velocity channel says that the joint went `distance`.
  bool proven(double distance) const {
    return seconds() > 1.0 && (away_ > 0.5 || travel_ > distance);
  }

 private:
  double start_, u_start_, last_ = 0.0, travel_ = 0.0, away_ = 0.0;
};

}  // namespace

std::vector<Defect> check_stuck(const GateRecording& r, const Joints& joints,
                                const GateSettings& /*settings*/) {
  std::vector<Defect> out;
  for (const GateJoint& joint : joints) {
    const GateChannel* q = r.find("q:" + joint.name);
    const GateChannel* u = r.find("u:" + joint.name);
    const GateChannel* dq = r.find("dq:" + joint.name);
    if (q == nullptr || (u == nullptr && dq == nullptr)) continue;
    const double command_range =
        u != nullptr ? std::max(range_of(u->values), 20.0 * quantisation_step(q->values))
                     : INFINITY;
    // m, rad: far above any velocity channel's resting noise
    const double distance = joint.prismatic ? 0.02 : 0.2;
    double value = NAN;
    Hang hang(0.0, NAN);
    for (std::size_t i = 1; i < q->values.size(); ++i) {
      const double x = q->values[i], goal = u != nullptr ? u->values[i] : NAN;
      if (!std::isfinite(x)) continue;
      if (x != value) value = x, hang = Hang(r.t[i], goal);
      hang.add(r.t[i], goal, dq != nullptr ? dq->values[i] : NAN, r.t[i] - r.t[i - 1],
               command_range);
      if (!hang.proven(distance)) continue;
      out.push_back(
          {r.file, q->name, static_cast<long>(i), defect::kStuck,
           fmt::format(
               "exactly {:.6g} for {:.2g} s while command or velocity moved on; the sensor or the "
               "logger hangs",
               x, hang.seconds())});
      break;
    }
  }
  return out;
}

namespace {

/// Rows [first, last] of one value, after which a channel is elsewhere at once.
struct Frozen {
  std::size_t first = 0, last = 0;
};

/// Longer than 0.1 s, ended by a step that no motion of this channel makes.
std::vector<Frozen> frozen_runs(const GateRecording& r, std::span<const double> x,
                                const GateSettings& settings) {
  std::vector<double> speeds;
  for (std::size_t i = 1; i < x.size(); ++i) {
    const double v = std::abs(x[i] - x[i - 1]) / (r.t[i] - r.t[i - 1]);
    if (std::isfinite(v)) speeds.push_back(v);
  }
  if (speeds.empty()) return {};
  const double fastest = quantile(speeds, 0.99);
  const double least = settings.jump_quanta * quantisation_step(x);
  std::vector<Frozen> out;
  Frozen run;
  for (std::size_t i = 1; i < x.size(); ++i) {
    if (!std::isfinite(x[i]) || x[i] == x[run.first]) {
      if (std::isfinite(x[i])) run.last = i;
      continue;
    }
    const double step = std::abs(x[i] - x[run.first]), dt = r.t[i] - r.t[run.last];
    const bool at_once = step > std::max(least, 3.0 * fastest * dt);
    if (at_once && r.t[run.last] - r.t[run.first] > 0.1) out.push_back(run);
    run = {i, i};
  }
  return out;
}

std::span<const double> rows_of(std::span<const double> x, const Frozen& run) {
  return x.subspan(run.first, run.last - run.first + 1);
}

/// What drives the joint: goals, or torques.
const GateChannel* command_of(const GateRecording& r, const std::string& joint) {
  for (const char* kind : {"u:", "tau_cmd:"}) {
    if (const GateChannel* c = r.find(kind + joint); c != nullptr) return c;
  }
  return nullptr;
}

/// Nothing in these rows differs from the first of them.
bool written_again(const GateRecording& r, const Frozen& run) {
  return std::all_of(r.channels.begin(), r.channels.end(), [&](const GateChannel& c) {
    const std::vector<double> x = finite_values(rows_of(c.values, run));
    return std::all_of(x.begin(), x.end(), [&](double v) { return v == x.front(); });
  });
}

}  // namespace

std::vector<Defect> check_resumed(const GateRecording& r, const Joints& joints,
                                  const GateSettings& settings) {
  std::vector<Defect> out;
  for (const GateJoint& joint : joints) {
    const GateChannel* q = r.find("q:" + joint.name);
    const GateChannel* command = command_of(r, joint.name);
    if (q == nullptr || command == nullptr) continue;
    const double driven = 0.1 * range_of(command->values);
    int again = 0;
    for (const Frozen& run : frozen_runs(r, q->values, settings)) {
      again += written_again(r, run);
      const bool hangs =
          range_of(rows_of(command->values, run)) > driven && r.t[run.last] - r.t[run.first] > 1.0;
      if (!hangs && again < 3) continue;
      out.push_back(
          {r.file, q->name, static_cast<long>(run.last), defect::kStuck,
           fmt::format("exactly {:.6g} for {:.2g} s and elsewhere in the next row{}; what "
                       "stands there was not read",
                       q->values[run.first], r.t[run.last] - r.t[run.first],
                       hangs ? ", while the command moved" : ", as all channels, several times")});
      break;
    }
  }
  return out;
}

}  // namespace sanso::diagnose::gate
