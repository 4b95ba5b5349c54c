// sanso bench dynamics: time of one 60 ms whole-body step, arithmetic counted, share of the
// machine's peak.
#pragma once

namespace sanso::bench {

/// Prints a table, or JSON. Returns the exit code 0.
int bench_dynamics(bool json);

}  // namespace sanso::bench
