// report.html of a diagnosis: one self-contained page that a person reads from top to bottom.
#pragma once

#include <string>

#include "tools/diagnose/run/diagnose.h"

namespace sanso::diagnose {

/// The whole text of report.html.
std::string diagnosis_report(const Diagnosis& diagnosis);

}  // namespace sanso::diagnose
