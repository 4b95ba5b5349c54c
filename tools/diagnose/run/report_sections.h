// The sections of the diagnosis report, in the order of the page. Each adds its heading, tables and
// figures, or nothing where it has nothing to tell.
#pragma once

#include "tools/diagnose/run/diagnose.h"
#include "tools/report/html.h"

namespace sanso::diagnose {

/// The defects that kept the recordings from being used.
void tell_refusal(report::HtmlPage& page, const Verdict& v);

/// The robot in three dimensions, doing what was recorded and simulated; nothing where the page was
/// not built.
void tell_robot(report::HtmlPage& page, const Verdict& v, const ModelFolder& model,
                const ShownMotions& shown);

/// Map joint by regime, error over time, and the cells that stand out.
void tell_where(report::HtmlPage& page, const Diagnosis& d);

/// A finding: its parameters, what it promised, its rivals.
void tell_finding(report::HtmlPage& page, const Finding& f);

/// The missing torque against what the joint was doing, before and after the patch.
void tell_curves(report::HtmlPage& page, const Diagnosis& d);

/// One joint's missing torque against one quantity, nominal and patched.
report::LineChart curve_chart(const std::string& joint, bool slides, const ShapeCurve& before,
                              const std::vector<ShapeCurve>& all_after);

/// Of a base that floats: where, when and how drives and motion disagree, three pictures. Slower
/// than `creeping` a joint stands still.
void tell_stance(report::HtmlPage& page, const Verdict& v, const RobotTree& tree,
                 const StanceShown& shown, double creeping);

/// Scores and roll-outs on data that were not fitted.
void tell_proof(report::HtmlPage& page, const Diagnosis& d);

/// What stays without a name, and the stretches that the last model misses.
void tell_unexplained(report::HtmlPage& page, const Verdict& v);

/// What to record next.
void tell_next_experiment(report::HtmlPage& page, const Verdict& v);

/// What could not be tested, and the smallest sizes that would have been seen.
void tell_limits(report::HtmlPage& page, const Verdict& v);

/// The steps of the run, and the verdict's notes.
void tell_log(report::HtmlPage& page, const Verdict& v, const std::vector<std::string>& log);

}  // namespace sanso::diagnose
