// How long the ticks took, for people: a line, and the histograms as CSV.
#pragma once

#include <string>

#include "firmware/exchange/tick_times.h"

namespace sanso::firmware {

/// "5000 ticks: woken 12 us late (median; 99.9 %: 45, longest 61), ..."
std::string times_line(const TickTimes& times);
/// Columns: less_than_us and a count for each of wake, tick, reply, imu_age. False: not written.
bool write_times(const TickTimes& times, const std::string& file);

}  // namespace sanso::firmware
