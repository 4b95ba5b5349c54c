// Every term against a formula written here: made data give the truth back within its interval,
// the signs are those of physics, and the bounds hold.
#include "tools/diagnose/torque/effort_terms.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <limits>
#include <map>
#include <numbers>
#include <stdexcept>

#include "tests/support/made_effort.h"
#include "tools/diagnose/torque/effort_fit.h"

namespace sanso::diagnose {
namespace {

using namespace test;

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNoise = 0.01;
constexpr const char* kStated =
    "actuator = \"torque\"\nviscous = 0.05\ncoulomb = 0.04\narmature = 0.02\n";

double sign(double x) { return x > 0.0 ? 1.0 : (x < 0.0 ? -1.0 : 0.0); }
double nothing(int, const MotionSample&, const NeededEffort&) { return 0.0; }

std::vector<EffortTerm> matching(const EffortRows& rows, const std::string& effect,
                                 const std::string& where, bool nuisance = false) {
  std::vector<EffortTerm> out;
  for (EffortTerm& t : effort_terms(rows, Settings{})) {
    if (t.effect == effect && t.where.front() == where && t.nuisance == nuisance)
      out.push_back(std::move(t));
  }
  return out;
}

EffortTerm the(const EffortRows& rows, const std::string& effect, const std::string& where,
               bool nuisance = false) {
  const std::vector<EffortTerm> all = matching(rows, effect, where, nuisance);
  if (all.empty()) throw std::runtime_error("no term " + effect + " at " + where);
  return all.front();
}

struct Fitted {
  Eigen::VectorXd value, deviation;
  double left = 0.0;  // mean squared error over the noise's variance
};

/// Weighted fit of these terms alone; deviations as normal noise of known size leaves them.
Fitted fitted(const EffortRows& rows, const std::vector<EffortTerm>& terms) {
  EffortDesign design(rows);
  design.append(terms);
  const auto n = static_cast<Eigen::Index>(rows.rows.size());
  design.set_weights(Eigen::VectorXd::Constant(n, 1.0 / (kNoise * kNoise)));
  std::vector<std::size_t> active;
  for (std::size_t t = 0; t < terms.size(); ++t) active.push_back(t);
  Fitted out;
  out.value = design.fit(active, BlockCounts(rows.blocks, 1.0));
  const Eigen::MatrixXd G = design.X().transpose() * design.X() / (kNoise * kNoise);
  out.deviation = G.inverse().diagonal().cwiseSqrt();
  out.left = design.residual(out.value).squaredNorm() / (kNoise * kNoise * static_cast<double>(n));
  return out;
}

/// The values are the truth within 3.5 deviations, are told from zero, and leave noise alone.
void expect_truth(const EffortRows& rows, const std::vector<EffortTerm>& terms,
                  const std::vector<double>& truth) {
  const Fitted f = fitted(rows, terms);
  ASSERT_EQ(static_cast<std::size_t>(f.value.size()), truth.size());
  for (std::size_t c = 0; c < truth.size(); ++c) {
    const auto i = static_cast<Eigen::Index>(c);
    EXPECT_NEAR(f.value[i], truth[c], 3.5 * f.deviation[i]) << c;
    EXPECT_LT(5.0 * f.deviation[i], std::abs(truth[c])) << c;
  }
  EXPECT_NEAR(f.left, 1.0, 0.15);
}

struct JointLaw {
  std::string effect;
  std::vector<double> truth;
  // the law, written out: motion of the joint, its load, and load less external torque
  std::function<double(double q, double dq, double ddq, double load, double squeezed)> law;
};

const std::vector<JointLaw>& joint_laws() {
  static const std::vector<JointLaw> laws{
      {"coulomb_friction", {0.12}, [](auto, auto v, auto...) { return 0.12 * sign(v); }},
      {"viscous_friction", {0.07}, [](auto, auto v, auto...) { return 0.07 * v; }},
      {"rotor_inertia", {0.015}, [](auto, auto, auto a, auto...) { return 0.015 * a; }},
      {"load_friction",
       {0.09},
       [](auto, auto v, auto, auto, auto s) { return 0.09 * std::abs(s) * sign(v); }},
      {"quadratic_load_friction",
       {0.05},
       [](auto, auto v, auto, auto, auto s) { return 0.05 * s * s * sign(v); }},
      {"asymmetric_friction",
       {0.06, -0.03},
       [](auto, auto v, auto...) { return 0.06 - 0.03 * std::abs(v); }},
      {"air_drag", {0.02}, [](auto, auto v, auto...) { return 0.02 * v * std::abs(v); }},
      {"cable_spring", {0.3, 0.1}, [](auto q, auto...) { return 0.3 * q - 0.1; }},
      {kEffortOffset.id, {-0.08}, [](auto...) { return -0.08; }},
  };
  return laws;
}

EffortRows with_law(const JointLaw& law, const ModelFolder& model, int at) {
  return made_effort(model, kNoise, [&](int j, const MotionSample& m, const NeededEffort& need) {
    const auto i = static_cast<std::size_t>(j);
    return j == at ? law.law(m.q[i], m.dq[i], m.ddq[i], need.load, need.load - need.external) : 0.0;
  });
}

TEST(EffortTerms, JointLawsAreFoundWithTheirSizes) {
  const ModelFolder model = arm(kStated);
  for (int j = 0; j < 3; ++j) {
    for (const JointLaw& law : joint_laws()) {
      SCOPED_TRACE(law.effect + " at joint " + std::to_string(j));
      const EffortRows rows = with_law(law, model, j);
      const std::string& name = model.tree.joints[static_cast<std::size_t>(j)].name;
      expect_truth(rows, {the(rows, law.effect, name)}, law.truth);
    }
  }
}

TEST(EffortTerms, FrictionsSideBySideKeepTheirOwnSizes) {
  const ModelFolder model = two_links(kStated);
  const EffortRows rows =
      made_effort(model, kNoise, [](int j, const MotionSample& m, const NeededEffort& need) {
        if (j != 0) return 0.0;
        const double v = m.dq[0];
        return sign(v) * (0.1 + 0.2 * std::abs(need.load - need.external)) + 0.06 * v +
               0.02 * m.ddq[0] + 0.03 * v * std::abs(v) + 0.05;
      });
  expect_truth(rows,
               {the(rows, "coulomb_friction", "a"), the(rows, "load_friction", "a"),
                the(rows, "viscous_friction", "a"), the(rows, "rotor_inertia", "a"),
                the(rows, "air_drag", "a"), the(rows, kEffortOffset.id, "a")},
               {0.1, 0.2, 0.06, 0.02, 0.03, 0.05});
}

TEST(EffortTerms, StribeckIsOfferedAtSharesOfTheUsualSpeed) {
  const ModelFolder model = pendulum(kStated);
  const EffortRows quiet = made_effort(model, kNoise, nothing);
  std::vector<double> speed;
  for (const MotionSample& m : quiet.recordings[0].motion) speed.push_back(std::abs(m.dq[0]));
  std::sort(speed.begin(), speed.end());
  const double usual = speed[speed.size() / 2];
  const std::vector<EffortTerm> terms = matching(quiet, "stribeck_friction", "a");
  ASSERT_EQ(terms.size(), 3u);
  const double share[] = {0.1, 0.3, 1.0};
  for (std::size_t s = 0; s < 3; ++s) {
    const double at = share[s] * usual;
    EXPECT_NEAR(terms[s].fixed.at("speed"), at, 1e-12);
    const EffortRows rows =
        made_effort(model, kNoise, [at](int, const MotionSample& m, const NeededEffort&) {
          return 0.2 * sign(m.dq[0]) * std::exp(-std::abs(m.dq[0]) / at);
        });
    expect_truth(rows, {terms[s]}, {0.2});
  }
}

TEST(EffortTerms, RipplesHaveTheSignOfTheirSide) {
  const ModelFolder model = pendulum(kStated);
  // cogging pushes the joint, so the motor gives the opposite; friction is what the motor overcomes
  const EffortRows cogging =
      made_effort(model, kNoise, [](int, const MotionSample& m, const NeededEffort&) {
        return -0.05 * std::sin(7 * m.q[0]) - 0.03 * std::cos(7 * m.q[0]);
      });
  expect_truth(cogging, {ripple_term(cogging, *find_effect("cogging"), 0, 7)}, {0.05, 0.03});
  const EffortRows rubs =
      made_effort(model, kNoise, [](int, const MotionSample& m, const NeededEffort&) {
        return sign(m.dq[0]) * (0.05 * std::sin(3 * m.q[0]) - 0.03 * std::cos(3 * m.q[0]));
      });
  expect_truth(rubs, {ripple_term(rubs, *find_effect("position_friction"), 0, 3)}, {0.05, -0.03});
  // another order, or the other kind, leaves what is there
  EXPECT_GT(fitted(cogging, {ripple_term(cogging, *find_effect("cogging"), 0, 6)}).left, 2.0);
  EXPECT_GT(fitted(rubs, {ripple_term(rubs, *find_effect("cogging"), 0, 3)}).left, 2.0);
}

TEST(EffortTerms, FrictionTakesEnergyAndSpringsGiveItBack) {
  const EffortRows rows = made_effort(two_links(kStated), 0.0, nothing);
  const EffortRecording& r = rows.recordings.front();
  for (const char* id : {"coulomb_friction", "viscous_friction", "stribeck_friction",
                         "load_friction", "quadratic_load_friction", "air_drag"}) {
    const ColumnsAt at = the(rows, id, "b").columns(r);
    for (std::size_t k = 0; k < r.t.size(); ++k) {
      std::vector<double> out(2, 0.0);
      at(r.motion[k], r.nominal_needs[k], out);
      EXPECT_EQ(out[0], 0.0) << id;
      EXPECT_GT(out[1] * r.motion[k].dq[1], 0.0) << id;
    }
  }
  // once round and back to where it was: no work
  std::vector<EffortTerm> stores{the(rows, "cable_spring", "b"),
                                 ripple_term(rows, *find_effect("cogging"), 1, 5)};
  for (const EffortTerm& term : stores) {
    const ColumnsAt at = term.columns(r);
    double work[2] = {0.0, 0.0};
    for (int k = 0; k < 1000; ++k) {
      const double phase = 2.0 * std::numbers::pi * k / 1000.0;
      MotionSample m;
      m.q[1] = 0.3 + 0.8 * std::sin(phase), m.dq[1] = 0.8 * std::cos(phase);
      std::vector<double> out(4, 0.0);
      at(m, std::vector<NeededEffort>(2), out);
      for (std::size_t c = 0; c < 2; ++c) work[c] += out[2 + c] * m.dq[1] / 1000.0;
    }
    EXPECT_NEAR(work[0], 0.0, 1e-12) << term.effect;
    EXPECT_NEAR(work[1], 0.0, 1e-12) << term.effect;
  }
}

/// Effort of the links of a model with `change` made by hand, less that of the nominal one.
EffortRows with_links(const ModelFolder& model, const std::function<void(BodyInertia&)>& change,
                      std::size_t link) {
  SimParams params = params_with_effects(model);
  change(params.tree.joints[link].body);
  InverseEffort changed(params);
  return made_effort(model, kNoise, [&](int j, const MotionSample& m, const NeededEffort& need) {
    JointVector load{};
    changed.loads(m, load);
    return load[static_cast<std::size_t>(j)] - need.load;
  });
}

TEST(EffortTerms, LinksAreFoundByMassCentreAndInertia) {
  const ModelFolder model = arm(kStated);
  const char* links[] = {"upper", "lower", "rod"};
  for (std::size_t k = 0; k < 3; ++k) {
    SCOPED_TRACE(links[k]);
    const EffortRows heavier = with_links(
        model,
        [](BodyInertia& b) {
          b.mass *= 1.15;
          for (double& i : b.about_com) i *= 1.15;
        },
        k);
    expect_truth(heavier, {the(heavier, "link_mass", links[k])}, {0.15});
    // inertia is quadratic in the centre of mass: a change as small as the column's own step
    const EffortRows moved = with_links(
        model, [](BodyInertia& b) { b.com[0] += 0.002, b.com[2] -= 0.002; }, k);
    const Fitted com = fitted(moved, {the(moved, "link_com", links[k])});
    if (k > 0) {
      EXPECT_NEAR(com.value[0], 0.002, 3.5 * com.deviation[0] + 1e-5);
      EXPECT_NEAR(com.value[1], 0.0, 3.5 * com.deviation[1] + 1e-5);
      EXPECT_NEAR(com.value[2], -0.002, 3.5 * com.deviation[2] + 1e-5);
    }
    EXPECT_NEAR(com.left, 1.0, 0.15);
    const BodyInertia& body = model.tree.joints[k].body;
    // the body grows in its shape until the inertia about its joint is 1.3 times as large
    const Vec3& axis = model.tree.joints[k].axis;
    double own = 0.0, far = 0.0, ahead = 0.0;
    for (std::size_t r = 0; r < 3; ++r) {
      far += body.com[r] * body.com[r], ahead += axis[r] * body.com[r];
      for (std::size_t c = 0; c < 3; ++c) own += axis[r] * body.about_com[3 * r + c] * axis[c];
    }
    if (model.tree.joints[k].prismatic) {  // turns about no axis of its own: the mean of three
      own = (body.about_com[0] + body.about_com[4] + body.about_com[8]) / 3.0;
      ahead = 0.0;
    }
    const double about_joint = own + body.mass * (far - ahead * ahead);
    const EffortRows rounder = with_links(
        model,
        [&](BodyInertia& b) {
          for (double& i : b.about_com) i *= 1.0 + 0.3 * about_joint / own;
        },
        k);
    expect_truth(rounder, {the(rounder, "link_inertia", links[k])}, {0.3});
  }
}

TEST(EffortTerms, AZeroOfTheEncoderTurnsThePoseInWhichLinksAreWeighed) {
  const ModelFolder model = two_links(kStated);
  InverseEffort inverse(params_with_effects(model));
  // the encoder of b shows 0.001 rad more than there is
  const EffortRows rows =
      made_effort(model, kNoise, [&](int j, const MotionSample& m, const NeededEffort& need) {
        MotionSample there = m;
        there.q[1] -= 0.001;
        JointVector load{};
        inverse.loads(there, load);
        return load[static_cast<std::size_t>(j)] - need.load;
      });
  EffortTerm zero = the(rows, "encoder_offset", "b", true);
  EXPECT_EQ(zero.high.front(), ToleranceSettings{}.zero);
  zero.precision = 0.0;
  const Fitted f = fitted(rows, {zero});
  EXPECT_NEAR(f.value[0], 0.001, 3.5 * f.deviation[0]);
  EXPECT_GT(f.value[0], 2.0 * f.deviation[0]);
}

TEST(EffortTerms, AMotorBehindTheBendActsOnBothJointsWithOnePower) {
  const ModelFolder model = two_links(kStated);
  const EffortRows rows =
      made_effort(model, kNoise, [](int j, const MotionSample& m, const NeededEffort&) {
        const double w = m.dq[1] - m.dq[0], a = m.ddq[1] - m.ddq[0];
        return (j == 0 ? -1.0 : 1.0) * (0.1 * sign(w) + 0.05 * w + 0.01 * a);
      });
  const std::vector<EffortTerm> terms = matching(rows, kCoupledDrive.id, "a");
  ASSERT_EQ(terms.size(), 2u);
  const bool first = terms[0].fixed.at("ratio") < 0.0;
  expect_truth(rows, {terms[first ? 0 : 1]}, {0.1, 0.05, 0.01});
  EXPECT_GT(fitted(rows, {terms[first ? 1 : 0]}).left, 2.0);
  // no motor is shared with a slide
  const EffortRows sliding = made_effort(arm(kStated), kNoise, nothing);
  EXPECT_EQ(matching(sliding, kCoupledDrive.id, "a").size(), 2u);
  EXPECT_TRUE(matching(sliding, kCoupledDrive.id, "b").empty());
}

TEST(EffortTerms, NoMoreCanBeTakenAwayThanTheModelStates) {
  const ModelFolder model = pendulum(kStated);
  const EffortRows rows =
      made_effort(model, kNoise, [](int, const MotionSample& m, const NeededEffort&) {
        return -0.3 * sign(m.dq[0]) - 0.3 * m.dq[0] - 0.3 * m.ddq[0];
      });
  const Fitted f =
      fitted(rows, {the(rows, "coulomb_friction", "a"), the(rows, "viscous_friction", "a"),
                    the(rows, "rotor_inertia", "a")});
  EXPECT_NEAR(f.value[0], -0.04, 1e-9);
  EXPECT_NEAR(f.value[1], -0.05, 1e-9);
  EXPECT_NEAR(f.value[2], -0.02, 1e-9);
  for (const char* id :
       {"stribeck_friction", "load_friction", "quadratic_load_friction", "air_drag"})
    EXPECT_EQ(fitted(rows, {the(rows, id, "a")}).value[0], 0.0) << id;
  EXPECT_EQ(the(rows, "cable_spring", "a").low, (std::vector<double>{0.0, -kInf}));
  EXPECT_EQ(the(rows, "asymmetric_friction", "a").low, (std::vector<double>{-kInf, -kInf}));
}

TEST(EffortTerms, LinksKeepAMassAndACentreWithinReach) {
  const EffortRows rows = made_effort(two_links(kStated), 0.0, nothing);
  EXPECT_EQ(the(rows, "link_mass", "lower").low, std::vector<double>{-1.0});
  const EffortTerm com = the(rows, "link_com", "lower");
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(com.low[c], -0.4, 1e-12);
    EXPECT_NEAR(com.high[c], 0.4, 1e-12);
  }
  EXPECT_EQ(com.joints, (std::vector<std::size_t>{0, 1}));
  EXPECT_EQ(the(rows, "link_com", "upper").joints, std::vector<std::size_t>{0});
}

TEST(EffortTerms, NuisancesStayWithinWhatAModelMayBeWrongBy) {
  const EffortRows rows = made_effort(arm(kStated), 0.0, nothing);
  Settings settings;
  settings.tolerances.reach = 2.0;
  const ToleranceSettings& t = settings.tolerances;
  const std::map<std::string, double> within{{"coulomb_friction", 0.04 * t.friction},
                                             {"viscous_friction", 0.05 * t.damping},
                                             {"rotor_inertia", 0.02 * t.armature},
                                             {"torque_constant", t.motor},
                                             {"link_mass", t.mass}};
  std::map<std::string, int> seen;
  for (const EffortTerm& term : effort_terms(rows, settings)) {
    if (!term.nuisance) continue;
    ++seen[term.effect];
    if (!within.contains(term.effect)) continue;
    const double tolerance = within.at(term.effect);
    EXPECT_NEAR(term.low.front(), -2.0 * tolerance, 1e-12) << term.effect;
    EXPECT_NEAR(term.high.front(), 2.0 * tolerance, 1e-12) << term.effect;
    EXPECT_NEAR(term.precision * tolerance * tolerance, t.precision, 1e-9) << term.effect;
  }
  for (const auto& entry : within) EXPECT_EQ(seen[entry.first], 3) << entry.first;
  EXPECT_EQ(seen["encoder_offset"], 2);  // a slide's zero changes no weight
  // what the model does not state cannot be stated wrongly
  const EffortRows bare = made_effort(arm("actuator = \"torque\"\n"), 0.0, nothing);
  for (const char* id : {"coulomb_friction", "viscous_friction", "rotor_inertia"})
    EXPECT_TRUE(matching(bare, id, "a", true).empty()) << id;
}

TEST(EffortTerms, AJointIsAskedOnlyWhatItsChannelCanSay) {
  EffortRows rows = made_effort(arm(kStated), 0.0, nothing);
  std::vector<EffortChannel>& channels = rows.recordings.front().channels;
  channels[0].known = false;
  channels[1].column.clear();  // passive
  channels[2].gain_unknown = true;
  EXPECT_TRUE(matching(rows, "coulomb_friction", "a").empty());
  EXPECT_TRUE(matching(rows, "torque_constant", "a", true).empty());
  EXPECT_FALSE(matching(rows, "link_mass", "upper").empty());
  EXPECT_FALSE(matching(rows, "coulomb_friction", "b").empty());
  EXPECT_TRUE(matching(rows, "torque_constant", "b").empty());
  EXPECT_TRUE(matching(rows, "torque_constant", "b", true).empty());
  EXPECT_TRUE(matching(rows, "torque_constant", "c").empty());
  const EffortTerm gain = the(rows, "torque_constant", "c", true);
  EXPECT_EQ(gain.high.front(), kInf);
  EXPECT_EQ(gain.precision, 0.0);
  EXPECT_EQ(the(rows, "coulomb_friction", "c").units.front(), "N");
  EXPECT_EQ(the(rows, "rotor_inertia", "c").units.front(), "kg");
}

TEST(EffortTerms, AGainIsAShareOfAllThatIsNeeded) {
  const EffortRows rows = made_effort(two_links(kStated), kNoise,
                                      [](int j, const MotionSample&, const NeededEffort& need) {
                                        return j == 1 ? -0.2 * need.total() : 0.0;
                                      });
  expect_truth(rows, {the(rows, "torque_constant", "b")}, {-0.2});
}

}  // namespace
}  // namespace sanso::diagnose
