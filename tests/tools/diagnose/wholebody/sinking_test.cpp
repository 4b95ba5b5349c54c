// Soles that give are sized by how one goes down as the load shifts to it; soles that do not are
// bounded, and a robot that nobody weighs is not asked.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/tools/diagnose/wholebody/made_body.h"
#include "tools/diagnose/wholebody/questions.h"

namespace sanso::diagnose {
namespace {

using namespace test;

constexpr double kWeight = 5.0 * 9.81;  // N, of the body that kTwoLegs is

/// It shifts its weight from foot to foot; each leg's slide is what its sole gives.
struct Swaying {
  double give = 0.0;  // m/N
  std::string ground = "";
  bool forces = true;

  Answered asked() const {
    const WholeBody body = body_of(ground, kTwoLegs);
    std::vector<WholeRecording> recordings;
    for (std::size_t number = 0; number < 6; ++number) recordings.push_back(recorded(body, number));
    const Settings s;
    return ask_sinking(
        Asking{body, recordings, Known{}, s.whole, s.decisions, s.tolerances, 1, s.stance});
  }

 private:
  WholeRecording recorded(const WholeBody& body, std::size_t number) const {
    Random random(7, number);
    WholeRecording r;
    r.file = r.name = "sway " + std::to_string(number), r.attitude = true;
    const Eigen::Index rows = 800;
    r.q.resize(static_cast<Eigen::Index>(body.model.tree.size()), rows);
    const int left = body.model.tree.links.at("l_foot").joint,
              right = body.model.tree.links.at("r_foot").joint;
    FootForce l{"l_foot", left, {}}, f{"r_foot", right, {}};
    // a slide that lets its foot down by a metre a unit, or up
    BodyKinematics kinematics(body);
    const auto down = [&](int joint) {
      Eigen::VectorXd q = Eigen::VectorXd::Zero(r.q.rows());
      kinematics.set(M3::Identity(), V3::Zero(), q);
      const double before = kinematics.origin(joint)[2];
      q[joint] = 1.0;
      kinematics.set(M3::Identity(), V3::Zero(), q);
      return before - kinematics.origin(joint)[2];
    };
    const double l_down = down(left), r_down = down(right);
    for (Eigen::Index k = 0; k < rows; ++k) {
      const double t = 0.01 * static_cast<double>(k);
      const double shift = 0.25 * kWeight * std::sin(2.0 * t + 0.3 * static_cast<double>(number));
      r.t.push_back(t), r.piece.push_back(0), r.R.push_back(M3::Identity());
      l.fz.push_back(0.5 * kWeight + shift), f.fz.push_back(0.5 * kWeight - shift);
      // both soles are on one floor: the leg whose sole is pressed in reaches further down
      r.q(left, k) = (give * l.fz.back() + 2e-5 * random.normal()) / l_down;
      r.q(right, k) = (give * f.fz.back() + 2e-5 * random.normal()) / r_down;
    }
    if (forces) r.feet = {l, f};
    return r;
  }
};

const Finding* compliance(const Answered& answered) {
  for (const Finding& f : answered.answers.findings)
    if (f.effect == name_of(WholeFigure::compliance)) return &f;
  return nullptr;
}

bool untestable(const Answered& answered, const std::string& word) {
  for (const Untestable& u : answered.answers.untestable)
    if (u.effect == name_of(WholeFigure::compliance))
      return u.because.find(word) != std::string::npos;
  return false;
}

TEST(Sinking, OfHardSolesIsBounded) {
  const Answered hard = Swaying{}.asked();
  EXPECT_EQ(compliance(hard), nullptr);
  EXPECT_TRUE(untestable(hard, "would have been seen"));
  EXPECT_EQ(hard.answers.asked, 1u);
}

TEST(Sinking, OfSoftSolesThatNobodyStatedIsNoMismatch) {
  const Answered soft = Swaying{.give = 1e-4}.asked();
  EXPECT_EQ(compliance(soft), nullptr);
  ASSERT_EQ(soft.answers.notes.size(), 1u);
  EXPECT_NE(soft.answers.notes.front().find("0.0001 m/N"), std::string::npos)
      << soft.answers.notes.front();
}

TEST(Sinking, IsNamedAndSizedWhereTheModelStatesAnother) {
  const Answered soft = Swaying{.give = 1e-4, .ground = "[ground]\nstiffness = 40000.0\n"}.asked();
  const Finding* f = compliance(soft);
  ASSERT_NE(f, nullptr);
  EXPECT_EQ(f->status, VerdictStatus::one_of) << "a leg that bends does the same";
  const VerdictParameter& p = f->parameters.at("stiffness");
  EXPECT_NEAR(p.value, std::log(1e4 / 4e4), 0.1);
  EXPECT_LE(p.low, p.value);
  EXPECT_GE(p.high, p.value);
}

TEST(Sinking, AsStatedIsNotAccused) {
  const Answered as_stated =
      Swaying{.give = 1e-4, .ground = "[ground]\nstiffness = 10000.0\n"}.asked();
  EXPECT_EQ(compliance(as_stated), nullptr);
  ASSERT_EQ(as_stated.answers.detectable.size(), 1u);
  EXPECT_GT(as_stated.answers.detectable.front().size, 0.0);
}

TEST(Sinking, WithoutForcesIsUntestable) {
  const Answered blind = Swaying{.give = 1e-4, .forces = false}.asked();
  EXPECT_EQ(blind.answers.asked, 0u);
  EXPECT_TRUE(untestable(blind, "no forces"));
}

}  // namespace
}  // namespace sanso::diagnose
