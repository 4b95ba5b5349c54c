// summary.json of a session: the stable record that scripts read (docs/howto/learn.md lists the
// fields).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace sanso::learn {

struct SessionSettings;
struct SessionState;

/// The value below which the fraction `p` of `values` lies (nearest rank); 0 for none.
double percentile(std::vector<float> values, double p);

/// Writes all of it anew, whole or not at all; `robot`: as --robot said it. Throws when it cannot.
void write_summary(const std::filesystem::path& path, const std::string& motion,
                   const SessionSettings& settings, const SessionState& state,
                   const std::string& robot);

}  // namespace sanso::learn
