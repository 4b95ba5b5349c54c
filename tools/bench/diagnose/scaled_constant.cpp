#include "tools/bench/diagnose/scaled_constant.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <stdexcept>
#include <variant>

#include "tools/diagnose/constants.h"

namespace sanso::bench {
namespace {

namespace c = diagnose::constants;

struct Scalable {
  const char* name;
  std::variant<double*, int*> value;
};

const std::vector<Scalable> kScalable{
    {"kShotSeconds", &c::kShotSeconds},
    {"kLeastShotRows", &c::kLeastShotRows},
    {"kTorqueWindow", &c::kTorqueWindow},
    {"kFastestRate", &c::kFastestRate},
    {"kMaximumRows", &c::kMaximumRows},
    {"kMaximumShots", &c::kMaximumShots},
    {"kModelFloor", &c::kModelFloor},
    {"kSecondaryFloor", &c::kSecondaryFloor},
    {"kArrivalInflation", &c::kArrivalInflation},
    {"kMassTolerance", &c::kMassTolerance},
    {"kLengthTolerance", &c::kLengthTolerance},
    {"kDampingTolerance", &c::kDampingTolerance},
    {"kFrictionTolerance", &c::kFrictionTolerance},
    {"kGainTolerance", &c::kGainTolerance},
    {"kMotorTolerance", &c::kMotorTolerance},
    {"kZeroTolerance", &c::kZeroTolerance},
    {"kLagTolerance", &c::kLagTolerance},
    {"kArmatureTolerance", &c::kArmatureTolerance},
    {"kTolerancePrecision", &c::kTolerancePrecision},
    {"kToleranceReach", &c::kToleranceReach},
    {"kFamilyWise", &c::kFamilyWise},
    {"kNullDraws", &c::kNullDraws},
    {"kStandardErrors", &c::kStandardErrors},
    {"kGainLevel", &c::kGainLevel},
    {"kGainDraws", &c::kGainDraws},
    {"kTestable", &c::kTestable},
    {"kSameSignature", &c::kSameSignature},
    {"kPracticalSize", &c::kPracticalSize},
    {"kMinimumShare", &c::kMinimumShare},
    {"kStandInShare", &c::kStandInShare},
    {"kAdequate", &c::kAdequate},
    {"kRivals", &c::kRivals},
    {"kMaximumEffects", &c::kMaximumEffects},
    {"kFolds", &c::kFolds},
    {"kBootstrap", &c::kBootstrap},
    {"kShotOutlier", &c::kShotOutlier},
    {"kSearchStep", &c::kSearchStep},
    {"kFineStep", &c::kFineStep},
    {"kIterations", &c::kIterations},
    {"kFirstIterations", &c::kFirstIterations},
    {"kPolishShare", &c::kPolishShare},
    {"kLinearReach", &c::kLinearReach},
    {"kConverged", &c::kConverged},
    {"kInsideBound", &c::kInsideBound},
};

void scale(double* value, double factor) { *value *= factor; }
void scale(int* value, double factor) {
  *value = std::max(1, static_cast<int>(std::lround(*value * factor)));
}

}  // namespace

std::vector<std::string> constant_names() {
  std::vector<std::string> names;
  for (const Scalable& s : kScalable) names.emplace_back(s.name);
  return names;
}

void scale_constant(const std::string& assignment) {
  const std::size_t equals = assignment.find('=');
  const std::string name = assignment.substr(0, equals);
  const double factor =
      equals == std::string::npos ? 0.0 : std::atof(assignment.c_str() + equals + 1);
  const auto found = std::find_if(kScalable.begin(), kScalable.end(),
                                  [&](const Scalable& s) { return name == s.name; });
  if (found == kScalable.end()) {
    throw std::invalid_argument("no constant '" + name +
                                "'; they stand in tools/diagnose/constants.h");
  }
  if (!(factor > 0.0) || !std::isfinite(factor)) {
    throw std::invalid_argument("'" + assignment + "': expected NAME=FACTOR with a factor above 0");
  }
  std::visit([factor](auto* value) { scale(value, factor); }, found->value);
}

}  // namespace sanso::bench
