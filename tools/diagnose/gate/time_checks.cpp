// Checks of the file's shape and clock.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "tools/diagnose/gate/checks.h"
#include "tools/diagnose/stats/robust.h"

namespace sanso::diagnose {

std::vector<Defect> inspect_file(const std::string& path, const GateSettings& settings) {
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  if (error) return {{path, "", -1, defect::kUnreadable, "cannot be opened: " + error.message()}};
  if (size == 0)
    return {{path, "", -1, defect::kEmpty,
             "0 bytes; expected a header line and rows (docs/model-folder.md)"}};
  if (size >> 20 >= static_cast<std::uintmax_t>(settings.largest_file)) {
    return {{path, "", -1, defect::kTooLarge,
             fmt::format("{} MB; at most {} MB are read: cut it into recordings of one motion each",
                         size >> 20, settings.largest_file)}};
  }
  return {};
}

namespace gate {

namespace {

std::vector<double> intervals(std::span<const double> t) {
  std::vector<double> out;
  for (std::size_t i = 1; i < t.size(); ++i) out.push_back(t[i] - t[i - 1]);
  return out;
}

}  // namespace

double sampling_interval(std::span<const double> t) { return median(intervals(t)); }

std::string uneven_sampling(const std::string& file, std::span<const double> t) {
  const double interval = sampling_interval(t);
  const double jitter = robust_sigma(intervals(t)) / std::max(interval, 1e-12);
  return jitter > 0.1 ? fmt::format("{}: sampling varies by {:.0f} % of {:.3g} s", file,
                                    100 * jitter, interval)
                      : std::string();
}

std::vector<Defect> check_size(const GateRecording& r, const GateSettings& settings) {
  if (r.t.empty())
    return {{r.file, "t", -1, defect::kHeaderOnly,
             fmt::format("no data rows; expected at least {}", settings.least_rows)}};
  if (r.t.size() < static_cast<std::size_t>(settings.least_rows) ||
      r.t.back() - r.t.front() < settings.least_seconds) {
    return {{r.file, "t", -1, defect::kTooShort,
             fmt::format("{} rows, {:.3g} s; expected at least {} rows and {} s", r.t.size(),
                         r.t.back() - r.t.front(), settings.least_rows, settings.least_seconds)}};
  }
  return {};
}

std::vector<Defect> check_time(const GateRecording& r, const GateSettings& settings) {
  std::vector<Defect> out;
  const double interval = sampling_interval(r.t);
  bool backwards = false, duplicate = false, gap = false;
  for (std::size_t i = 0; i < r.t.size(); ++i) {
    const auto row = static_cast<long>(i);
    if (!std::isfinite(r.t[i])) {
      out.push_back({r.file, "t", row, defect::kNotANumber, "t must be a number in every row"});
      return out;
    }
    if (i == 0) continue;
    const double step = r.t[i] - r.t[i - 1];
    if (step < 0.0 && !backwards) {
      out.push_back(
          {r.file, "t", row, defect::kBackwards,
           fmt::format("t goes from {} to {}; expected increasing seconds", r.t[i - 1], r.t[i])});
      backwards = true;
    } else if (step == 0.0 && !duplicate) {
      out.push_back(
          {r.file, "t", row, defect::kDuplicateTime, fmt::format("t = {} twice", r.t[i])});
      duplicate = true;
    } else if (step > std::max(settings.gap_periods * interval, settings.gap_seconds) && !gap) {
      out.push_back(
          {r.file, "t", row, defect::kGap,
           fmt::format("{:.3g} s without a row (usual step {:.3g} s); split the file there", step,
                       interval)});
      gap = true;
    }
  }
  return out;
}

std::vector<Defect> check_required(const GateRecording& r, const Joints& joints,
                                   const GateSettings& settings) {
  std::vector<Defect> out;
  bool any_position = false;
  for (const GateJoint& joint : joints) {
    const GateChannel* q = r.find("q:" + joint.name);
    any_position |= q != nullptr && finite_values(q->values).size() >=
                                        static_cast<std::size_t>(settings.least_rows);
  }
  if (!any_position) {
    out.push_back({r.file, joints.empty() ? "q:" : "q:" + joints.front().name, -1,
                   defect::kMissingChannel,
                   "no position column of any joint of the model; expected e.g. q:" +
                       (joints.empty() ? std::string("joint") : joints.front().name)});
  }
  for (const GateChannel& c : r.channels) {
    for (std::size_t i = 0; i < c.values.size(); ++i) {
      if (std::isinf(c.values[i])) {
        out.push_back(
            {r.file, c.name, static_cast<long>(i), defect::kNotANumber, "infinite value"});
        break;
      }
    }
  }
  return out;
}

std::vector<Defect> check_copies(const std::vector<GateRecording>& recordings) {
  std::vector<Defect> out;
  // the positions decide: a copy with another name, shifted clock or another condition is still the
  // same motion
  const auto same = [](const GateRecording& a, const GateRecording& b) {
    if (a.t.size() != b.t.size() || a.t.empty()) return false;
    bool compared = false;
    for (const GateChannel& c : a.channels) {
      if (c.name.rfind("q:", 0) != 0) continue;
      const GateChannel* other = b.find(c.name);
      if (other == nullptr) return false;
      for (std::size_t i = 0; i < c.values.size(); ++i) {
        const bool both_empty = std::isnan(c.values[i]) && std::isnan(other->values[i]);
        if (!both_empty && c.values[i] != other->values[i]) return false;
      }
      compared = true;
    }
    return compared;
  };
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      if (!same(recordings[i], recordings[k])) continue;
      out.push_back({recordings[i].file, "", -1, defect::kCopyOfFile,
                     "every position equals " + recordings[k].file +
                         "; a copy proves nothing, leave it out"});
      break;
    }
  }
  return out;
}

}  // namespace gate
}  // namespace sanso::diagnose
