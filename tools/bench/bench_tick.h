// `sanso bench tick` and `sanso bench bus`: the controller's own cost, and what the bus leaves of a
// tick.
#pragma once

namespace sanso::bench {

/// CPU time of a tick with all layers, estimator, guard and packets: p50, p99, p99.9, max, page
/// faults. Exit code.
int bench_tick(bool json);

/// Time of one bus cycle by arithmetic (bytes, reply latency) for the speeds that the servos know.
/// Exit code.
int bench_bus(bool json);

}  // namespace sanso::bench
