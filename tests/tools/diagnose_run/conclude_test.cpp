// From the search's result to findings.
#include "tools/diagnose/run/conclude.h"

#include <gtest/gtest.h>

namespace sanso::diagnose {
namespace {

CandidateParameter parameter(const char* name, double null, bool structural = false) {
  CandidateParameter p;
  p.name = name;
  p.null = null;
  p.structural = structural;
  return p;
}

TEST(SpansNull, OneFittedParameterBesideItsNullIsEnough) {
  Candidate c;
  c.parameters = {parameter("resistance", 1.0), parameter("torque", 1.0), parameter("mode", 0.0, true)};
  std::map<std::string, VerdictParameter> found{{"resistance", {0.89, 0.85, 0.94, "-", false}},
                                                {"torque", {1.01, 0.95, 1.07, "-", false}},
                                                {"mode", {1.0, 1.0, 1.0, "-", false}}};
  EXPECT_FALSE(spans_null(c, found));
  found["resistance"] = {0.89, 0.78, 1.0, "-", false};  // what is chosen and not fitted has no interval
  EXPECT_TRUE(spans_null(c, found));
  found["torque"] = {1.07, 0.95, 1.07, "-", true};  // a bound that stopped it is another reserve
  EXPECT_FALSE(spans_null(c, found));
}

TEST(SpansNull, AChoiceWithoutFittedParametersHasNoInterval) {
  Candidate c;
  c.parameters = {parameter("mode", 0.0, true)};
  EXPECT_FALSE(spans_null(c, {{"mode", {0.0, 0.0, 0.0, "-", false}}}));
}

TEST(SpansNull, ChanceIsJudgedByItsSize) {
  Candidate c;
  c.random = true;
  c.parameters = {parameter("share", 0.0, true), parameter("seed", 0.0, true)};
  EXPECT_FALSE(spans_null(c, {{"share", {0.02, 0.01, 0.03, "-", false}}, {"seed", {1.0, 1.0, 1.0, "-", false}}}));
  EXPECT_TRUE(spans_null(c, {{"share", {0.02, 0.0, 0.03, "-", false}}, {"seed", {1.0, 1.0, 1.0, "-", false}}}));
}

}  // namespace
}  // namespace sanso::diagnose
