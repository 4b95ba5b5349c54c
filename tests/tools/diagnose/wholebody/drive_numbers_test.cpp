// What a term says to a person: scales as they are, lengths as lengths, sizes where they are
// surest.
#include "tools/diagnose/wholebody/drive_numbers.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sanso::diagnose {
namespace {

DriveTerm term_of(std::size_t numbers) {
  DriveTerm out;
  out.effect = "link_com";
  for (std::size_t i = 0; i < numbers; ++i) {
    out.parameters.push_back(std::string(1, static_cast<char>('x' + i)));
    out.units.emplace_back("m");
  }
  return out;
}

TEST(DriveNumbers, AnUncertainDirectionHidesNoneThatIsSure) {
  const JudgedDriveTerm j = with_numbers(term_of(3), Eigen::Vector3d(0.012, 0.0, 0.006),
                                         Eigen::Vector3d(0.0005, 0.0005, 0.0075));
  EXPECT_NEAR(j.size, 0.012, 1e-4);
  EXPECT_NEAR(j.sigma, 0.0005, 1e-4);
}

TEST(DriveNumbers, AFirstMomentIsReadAsALength) {
  DriveTerm term = term_of(3);
  term.mass = 2.0;
  const JudgedDriveTerm j =
      with_numbers(term, Eigen::Vector3d(0.04, 0.0, 0.0), Eigen::Vector3d::Constant(0.01));
  EXPECT_NEAR(j.parameters[0].value, 0.02, 1e-12);
  EXPECT_NEAR(j.parameters[0].high - j.parameters[0].low, 2 * 1.96 * 0.005, 1e-4);
}

TEST(DriveNumbers, AScaleOfATorqueIsTheInverseOfWhatIsMissing) {
  DriveTerm term = term_of(1);
  term.inverse = true, term.nothing = 1.0;
  const JudgedDriveTerm j = with_numbers(term, Eigen::VectorXd::Constant(1, 1.0 - 1.0 / 0.8),
                                         Eigen::VectorXd::Constant(1, 0.01));
  EXPECT_NEAR(j.parameters[0].value, 0.8, 1e-12);
}

}  // namespace
}  // namespace sanso::diagnose
