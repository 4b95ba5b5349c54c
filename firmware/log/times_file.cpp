// Medians and tails of the four histograms, in microseconds.
#include "firmware/log/times_file.h"

#include <array>
#include <cstdio>
#include <utility>

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
  std::FILE* out = std::fopen(file.c_str(), "w");
  if (out == nullptr) return false;
  std::fputs("less_than_us,wake,tick,reply,imu_age\n", out);
  for (std::size_t bin = 0; bin < TimeHistogram::kBins; ++bin) {
    if (bin + 1 < TimeHistogram::kBins)
      std::fprintf(out, "%g", us(TimeHistogram::end_of(bin)));
    else
      std::fputs("inf", out);
    for (const auto& [name, histogram] : named(times))
      std::fprintf(out, ",%u", histogram->count(bin));
    std::fputs("\n", out);
  }
  return std::fclose(out) == 0;
}

}  // namespace sanso::firmware
