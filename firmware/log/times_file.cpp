// Medians and tails of the four histograms, in microseconds.
#include "firmware/log/times_file.h"

#include <array>
#include <cstdio>
#include <sstream>
#include <utility>

#include "shared/files/atomic_file.h"

namespace sanso::firmware {
namespace {

double us(Nanoseconds duration) { return static_cast<double>(duration) / kMicrosecond; }

std::array<std::pair<const char*, const TimeHistogram*>, 4> named(const TickTimes& times) {
  return {{{"wake-up", &times.wake},
           {"tick", &times.tick},
           {"reply", &times.reply},
           {"imu age", &times.imu_age}}};
}

}  // namespace

std::string times_line(const TickTimes& times) {
  std::string line = "sanso-firmware: " + std::to_string(times.tick.count()) + " ticks; us:";
  for (const auto& [name, histogram] : named(times)) {
    char text[160];
    std::snprintf(text, sizeof text, " %s p50 %.0f p99 %.0f p99.9 %.0f longest %.0f;", name,
                  us(histogram->quantile(0.5)), us(histogram->quantile(0.99)),
                  us(histogram->quantile(0.999)), us(histogram->longest()));
    line += text;
  }
  line.back() = '\n';
  return line;
}

bool write_times(const TickTimes& times, const std::string& file) {
  std::ostringstream out;
  out << "less_than_us,wake,tick,reply,imu_age\n";
  for (std::size_t bin = 0; bin < TimeHistogram::kBins; ++bin) {
    if (bin + 1 < TimeHistogram::kBins)
      out << us(TimeHistogram::end_of(bin));
    else
      out << "inf";
    for (const auto& [name, histogram] : named(times)) out << ',' << histogram->count(bin);
    out << '\n';
  }
  try {
    files::write_atomically(file, out.str());
    return true;
  } catch (const files::WriteError&) {
    return false;
  }
}

}  // namespace sanso::firmware
