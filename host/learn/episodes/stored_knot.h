// A knot of a policy as files hold it: trials and sessions store the same fields in the same order.
#pragma once

namespace sanso::learn {

/// Calls `io` with every field of a `policy::Knot` in the stored order.
void visit_knot(auto& knot, auto&& io) { io(knot.u), io(knot.x), io(knot.K); }

}  // namespace sanso::learn
