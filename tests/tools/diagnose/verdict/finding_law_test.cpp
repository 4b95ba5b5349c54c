// Findings: statuses by what is held against them, in every combination; rows that refute.
#include "tools/diagnose/verdict/finding.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tools/diagnose/effects/effect.h"

namespace sanso::diagnose {
namespace {

/// A finding against which these things are held.
Finding with(bool rivals, bool bound, bool terms, bool null) {
  Finding f;
  f.effect = "cogging";
  f.one_of = {"cogging"};
  if (rivals) f.one_of.emplace_back("cable_spring");
  f.parameters["size"] = {0.5, 0.4, 0.6, "N m", bound};
  if (terms) f.terms = {"cable_spring"}, f.terms_of = kOfAngle;
  f.spans_null = null;
  return f;
}

TEST(FindingStatus, FollowsFromWhatIsHeldAgainstIt) {
  for (int bits = 0; bits < 16; ++bits) {
    const bool rivals = bits & 1, bound = bits & 2, terms = bits & 4, null = bits & 8;
    const VerdictStatus status = status_of(with(rivals, bound, terms, null));
    const VerdictStatus expected = terms || null ? VerdictStatus::present_unnamed
                                   : rivals      ? VerdictStatus::one_of
                                   : bound       ? VerdictStatus::present_unnamed
                                                 : VerdictStatus::confirmed;
    EXPECT_EQ(status, expected) << "bits " << bits;
  }
}

TEST(FindingStatus, NothingIsHeldAgainstWhatIsConfirmed) {
  for (int bits = 0; bits < 16; ++bits) {
    const Finding f = with(bits & 1, bits & 2, bits & 4, bits & 8);
    if (status_of(f) == VerdictStatus::confirmed) {
      EXPECT_EQ(reserve(f), "") << "bits " << bits;
    }
    if (status_of(f) == VerdictStatus::present_unnamed) {
      EXPECT_NE(reserve(f), "") << "bits " << bits;
    }
  }
}

TEST(FindingStatus, EveryStatusHasItsOwnWord) {
  std::vector<std::string> words;
  for (const VerdictStatus s :
       {VerdictStatus::confirmed, VerdictStatus::one_of, VerdictStatus::present_unnamed,
        VerdictStatus::absent, VerdictStatus::refused})
    words.emplace_back(to_string(s));
  EXPECT_EQ(words, (std::vector<std::string>{"CONFIRMED", "ONE_OF", "PRESENT_UNNAMED", "ABSENT",
                                             "REFUSED"}));
}

TEST(StoppedAtBounds, NamesEveryParameterThatIs) {
  Finding f;
  f.parameters["width"] = {1, 1, 1, "rad", true};
  f.parameters["loss"] = {1, 1, 1, "-", false};
  f.parameters["order"] = {1, 1, 1, "-", true};
  EXPECT_EQ(stopped_at_bounds(f), "order, width ends at a bound of the library");
  EXPECT_EQ(stopped_at_bounds(Finding{}), "");
}

IncidenceRow row(Signal signal, const char* regime, double low, double high) {
  return {{signal, regime}, 20.0, 0.5 * (low + high), low, high};
}

TEST(Refutation, NeedsTheWholeIntervalOutside) {
  EXPECT_EQ(refuted_by({row(Signal::q, "", 0.3, 0.8)}, DecisionSettings{}), "");
  EXPECT_EQ(refuted_by({row(Signal::q, "", 1.2, 2.8)}, DecisionSettings{}), "");
  EXPECT_NE(refuted_by({row(Signal::q, "", -0.3, 0.49)}, DecisionSettings{}), "")
      << "it did not happen";
  EXPECT_NE(refuted_by({row(Signal::q, "", 2.01, 4.0)}, DecisionSettings{}), "")
      << "it happened several times over";
}

TEST(Refutation, NamesTheFirstRowThatDoes) {
  const std::string why =
      refuted_by({row(Signal::q, "", 0.9, 1.1), row(Signal::q, "reversal", -0.1, 0.1),
                  row(Signal::pwm, "", -0.1, 0.1)},
                 DecisionSettings{});
  EXPECT_TRUE(why.starts_with(to_string(ErrorPart{Signal::q, "reversal"}) + ":")) << why;
  EXPECT_EQ(refuted_by({}, DecisionSettings{}), "");
}

TEST(ErrorPart, ReadsAsTheFileHasIt) {
  EXPECT_EQ(to_string(ErrorPart{Signal::q, ""}), "position");
  EXPECT_EQ(to_string(ErrorPart{Signal::q, "reversal"}), "position, reversal");
  EXPECT_EQ(to_string(ErrorPart{Signal::pwm, ""}), "duty");
}

}  // namespace
}  // namespace sanso::diagnose
