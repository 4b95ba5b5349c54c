// Findings: statuses by what is held against them, in every combination; rows that refute.
#include "tools/diagnose/verdict/finding.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

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

/// An effect with a tolerated size at a joint that turns and states dry friction of 0.1 N m.
struct SmallEffect {
  explicit SmallEffect(const std::string& effect) {
    candidate.effect = effect;
    candidate.joints = {0};
    for (const EffectParameter& p : find_effect(effect)->parameters) {
      CandidateParameter here;
      here.name = p.name, here.null = p.null, here.structural = p.structural;
      candidate.parameters.push_back(here);
    }
    nominal.tree.joints.resize(1);
    nominal.joints.resize(1);
    nominal.joints[0].nominal.coulomb = 0.1;
  }
  /// Sine and cosine at this phase, each known to `half`.
  Finding at(double amplitude, double phase, double half) const {
    Finding f;
    for (const CandidateParameter& p : candidate.parameters)
      f.parameters[p.name] = {p.null, p.null, p.null, "", false};
    const auto set = [&](const char* name, double value) {
      f.parameters[name] = {value, value - half, value + half, "", false};
    };
    set("sine", amplitude * std::sin(phase)), set("cosine", amplitude * std::cos(phase));
    return f;
  }
  bool tolerated(const Finding& f) const {
    return is_tolerated(f, candidate, nominal, ToleranceSettings{});
  }
  Candidate candidate;
  SimParams nominal;
};

TEST(Tolerated, AnAmplitudeIsWhateverItsPhase) {
  const ToleranceSettings within;
  const struct {
    const char* effect;
    double size;
  } ripples[] = {{"gear_kinematic_error", within.zero},
                 {"encoder_nonlinearity", within.zero},
                 {"position_friction", 0.1 * within.friction}};
  for (const auto& [effect, size] : ripples) {
    const SmallEffect ripple(effect);
    for (int k = 0; k < 16; ++k) {
      const double phase = k * std::numbers::pi / 8;
      EXPECT_TRUE(ripple.tolerated(ripple.at(0.95 * size, phase, 0.01 * size))) << effect << k;
      EXPECT_FALSE(ripple.tolerated(ripple.at(1.1 * size, phase, 0.01 * size))) << effect << k;
      EXPECT_TRUE(ripple.tolerated(ripple.at(2.0 * size, phase, 1.2 * size))) << effect << k;
    }
  }
}

TEST(Tolerated, NothingElseOfTheEffectMayStandBesideIt) {
  const SmallEffect ripple("encoder_nonlinearity");
  Finding f = ripple.at(0.0005, 1.0, 0.0001);
  EXPECT_TRUE(ripple.tolerated(f));
  f.parameters["scale"] = {0.01, 0.008, 0.012, "-", false};
  EXPECT_FALSE(ripple.tolerated(f)) << "a scale is no ripple";
}

TEST(Tolerated, HysteresisOfLittleTorqueWhateverItsShape) {
  const SmallEffect slip("maxwell_slip_friction");
  Finding f = slip.at(0.0, 0.0, 0.0);
  f.parameters["stiffness"] = {300, 290, 310, "N m/rad", false};
  f.parameters["spread"] = {2, 1.9, 2.1, "-", false};
  const double size = 0.1 * ToleranceSettings{}.friction;
  f.parameters["torque"] = {size, 0.8 * size, 1.2 * size, "N m", false};
  EXPECT_TRUE(slip.tolerated(f));
  f.parameters["torque"] = {1.5 * size, 1.2 * size, 1.8 * size, "N m", false};
  EXPECT_FALSE(slip.tolerated(f));
}

TEST(Tolerated, WithoutStatedFrictionNoSmallEffectItIs) {
  SmallEffect ripple("position_friction");
  ripple.nominal.joints[0].nominal.coulomb = 0.0;
  EXPECT_FALSE(ripple.tolerated(ripple.at(1e-6, 1.0, 1e-7)));
}

TEST(Tolerated, ASlideHasNoAngle) {
  SmallEffect ripple("gear_kinematic_error");
  const Finding f = ripple.at(1e-4, 1.0, 1e-6);
  EXPECT_TRUE(ripple.tolerated(f));
  ripple.nominal.tree.joints[0].prismatic = true;
  EXPECT_FALSE(ripple.tolerated(f));
}

/// What acts on the whole robot names no joint: that is every joint, and not none.
TEST(Tolerated, ASupplyThatIsFarLowerIsNoTolerance) {
  SmallEffect supply("battery_drift");
  supply.candidate.joints.clear();
  const double gain = ToleranceSettings{}.gain;
  Finding f;
  const auto tolerated = [&](double level, double slope, bool bound = false) {
    f.parameters["level"] = {level, level - 0.001, level + 0.001, "-", bound};
    f.parameters["slope"] = {slope, slope - 0.001, slope + 0.001, "1/min", false};
    return supply.tolerated(f);
  };
  EXPECT_TRUE(tolerated(0.5 * gain, 0.0));
  EXPECT_FALSE(tolerated(-5.0 * gain, 0.0)) << "a tenth lower";
  EXPECT_FALSE(tolerated(0.5 * gain, 0.02)) << "it falls";
  f.parameters["level"] = {-0.2, -0.2, 0.1, "-", true};
  EXPECT_FALSE(supply.tolerated(f)) << "at its bound the interval has one side";
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
