// Every kind of broken base channel is refused by name, and a healthy one is not.
#include <gtest/gtest.h>

#include "tests/tools/diagnose/wholebody/made_body.h"

namespace sanso::diagnose {
namespace {

using namespace test;

/// A ball that is carried about and turned by hand, all channels there.
recording::Recording carried() {
  recording::Recording r;
  r.file = "carried.csv";
  for (double t = 0.0; t < 6.0; t += 0.01) r.t.push_back(t);
  const auto q = [&](double t) {
    return Eigen::Quaterniond(Eigen::AngleAxisd(0.9 * std::sin(1.3 * t), V3::UnitZ()) *
                              Eigen::AngleAxisd(0.8 * std::sin(0.9 * t + 1.0), V3::UnitX()) *
                              Eigen::AngleAxisd(0.7 * std::sin(1.7 * t), V3::UnitY()));
  };
  const auto p = [](double t) {
    return V3(0.3 * std::sin(1.9 * t), 0.2 * std::cos(1.1 * t), 0.5 + 0.1 * std::sin(0.7 * t));
  };
  constexpr double h = 1e-5;
  put(r, "base_q", "wxyz", [&](auto k, auto i) { return part_of(q(r.t[k]), i); });
  put(r, "base_p", "xyz", [&](auto k, auto i) { return p(r.t[k])[static_cast<long>(i)]; });
  put(r, "base_v", "xyz", [&](auto k, auto i) {
    return (p(r.t[k] + h) - p(r.t[k] - h))[static_cast<long>(i)] / (2 * h);
  });
  put(r, "base_w", "xyz", [&](auto k, auto i) {
    const Eigen::AngleAxisd turn(q(r.t[k] - h).conjugate() * q(r.t[k] + h));
    return turn.axis()[static_cast<long>(i)] * turn.angle() / (2 * h);
  });
  return r;
}

std::vector<double>& column(recording::Recording& r, const std::string& name) {
  for (recording::Channel& c : r.channels) {
    if (c.name == name) return c.values;
  }
  throw std::logic_error("no column " + name);
}

void scale(recording::Recording& r, const std::string& kind, double factor) {
  for (recording::Channel& c : r.channels) {
    if (c.name.starts_with(kind + ":"))
      for (double& v : c.values) v *= factor;
  }
}

std::vector<Defect> defects(const recording::Recording& r, const char* urdf = kBall,
                            const Settings& settings = {}) {
  return judge_whole({r}, body_of("", urdf), settings).defects;
}

TEST(BaseChecks, AHealthyRecordingPasses) {
  const auto found = defects(carried());
  EXPECT_TRUE(found.empty()) << found.front().message;
}

TEST(BaseChecks, SignsOfAQuaternionMayFlip) {
  recording::Recording r = carried();
  for (std::size_t k = 200; k < 300; ++k) {
    for (const char* c : {"w", "x", "y", "z"}) column(r, std::string("base_q:") + c)[k] *= -1.0;
  }
  EXPECT_TRUE(defects(r).empty());
}

struct Case {
  const char* what;
  std::function<void(recording::Recording&)> broken;
  const char *channel, *defect;
};

std::vector<Case> cases() {
  return {
      {"x y z w",
       [](auto& r) {
         const recording::Recording was = r;
         const char* order[] = {"x", "y", "z", "w"};
         const char* names[] = {"w", "x", "y", "z"};
         for (int i = 0; i < 4; ++i) {
           const auto values = was.find(std::string("base_q:") + order[i]);
           r.set(std::string("base_q:") + names[i], {values.begin(), values.end()});
         }
       },
       "base_q:w", defect::kSwapped},
      {"quaternion of length 2", [](auto& r) { scale(r, "base_q", 2.0); }, "base_q:w",
       defect::kWrongUnit},
      {"degrees per second", [](auto& r) { scale(r, "base_w", 57.3); }, "base_w:x",
       defect::kWrongUnit},
      {"turning the other way", [](auto& r) { scale(r, "base_w", -1.0); }, "base_w:x",
       defect::kWrongSign},
      {"millimetres", [](auto& r) { scale(r, "base_p", 1000.0); }, "base_p:x", defect::kWrongUnit},
      {"velocity in mm/s", [](auto& r) { scale(r, "base_v", 1000.0); }, "base_v:x",
       defect::kWrongUnit},
      {"velocity backwards", [](auto& r) { scale(r, "base_v", -1.0); }, "base_v:x",
       defect::kWrongSign},
      {"a part is missing",
       [](auto& r) {
         std::erase_if(r.channels, [](const auto& c) { return c.name == "base_q:z"; });
       },
       "base_q:z", defect::kMissingChannel},
      {"nothing says where the base is",
       [](auto& r) {
         std::erase_if(r.channels, [](const auto& c) { return c.name.starts_with("base_q"); });
       },
       "base_q:w", defect::kMissingChannel},
      {"infinite", [](auto& r) { column(r, "base_p:y")[7] = INFINITY; }, "base_p:y",
       defect::kNotANumber},
      {"time backwards", [](auto& r) { std::swap(r.t[5], r.t[6]); }, "t", defect::kBackwards},
      {"a foot nobody knows", [](auto& r) { r.set("fz:paw", std::vector<double>(r.rows(), 5.0)); },
       "fz:paw", "unknown link"},
      {"kilograms", [](auto& r) { r.set("fz:ball", std::vector<double>(r.rows(), 0.5)); },
       "fz:ball", defect::kWrongUnit},
      {"pulled into the ground",
       [](auto& r) { r.set("fz:ball", std::vector<double>(r.rows(), -4.9)); }, "fz:ball",
       defect::kWrongSign},
      {"g",
       [](auto& r) { put(r, "imu_acc", "xyz", [](auto, auto i) { return i == 2 ? 1.0 : 0.0; }); },
       "imu_acc:x", defect::kWrongUnit},
  };
}

TEST(BaseChecks, EveryKindOfBreakIsNamed) {
  for (const Case& c : cases()) {
    recording::Recording r = carried();
    c.broken(r);
    const auto found = defects(r);
    ASSERT_FALSE(found.empty()) << c.what;
    EXPECT_EQ(found.front().defect, c.defect) << c.what << ": " << found.front().message;
    EXPECT_EQ(found.front().channel, c.channel) << c.what;
    EXPECT_FALSE(found.front().message.empty());
  }
}

/// Calls see(name, settings) with every threshold of the checks halved, and doubled.
void for_half_and_twice(const std::function<void(const std::string&, const Settings&)>& see) {
  BaseSettings all;
  int count = 0;
  all.visit([&](const char*, auto&, auto&&...) { ++count; });
  for (const double factor : {0.5, 2.0}) {
    for (int which = 0; which < count; ++which) {
      Settings s;
      std::string name;
      int at = 0;
      s.base.visit([&](const char* key, auto& value, auto&&...) {
        if (at++ != which) return;
        name = std::string(key) + (factor < 1.0 ? " halved" : " doubled");
        value = static_cast<std::decay_t<decltype(value)>>(value * factor);
      });
      see(name, s);
    }
  }
}

TEST(BaseChecks, NoAnswerHangsOnAThreshold) {
  const recording::Recording healthy = carried();
  for_half_and_twice([&](const std::string& name, const Settings& settings) {
    const auto none = defects(healthy, kBall, settings);
    EXPECT_TRUE(none.empty()) << name << ": " << none.front().message;
    for (const Case& c : cases()) {
      recording::Recording r = healthy;
      c.broken(r);
      const auto found = defects(r, kBall, settings);
      ASSERT_FALSE(found.empty()) << name << ": " << c.what;
      EXPECT_EQ(found.front().defect, c.defect) << name << ": " << c.what;
    }
  });
}

TEST(BaseChecks, AngularVelocityInWorldAxesIsToldFromBaseAxes) {
  recording::Recording r = carried();
  const recording::Recording was = r;
  const auto at = [&](const std::string& name, std::size_t k) { return was.find(name)[k]; };
  put(r, "base_w", "xyz", [&](auto k, auto i) {
    const Eigen::Quaterniond q(at("base_q:w", k), at("base_q:x", k), at("base_q:y", k),
                               at("base_q:z", k));
    const V3 w(at("base_w:x", k), at("base_w:y", k), at("base_w:z", k));
    return (q * w)[static_cast<long>(i)];
  });
  const auto found = defects(r);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found.front().channel, "base_w:x");
  EXPECT_EQ(found.front().defect, defect::kSwapped);
}

TEST(BaseChecks, JointsThatCarryMuchHaveToBeRecorded) {
  const auto found = defects(carried(), kTwoLegs);
  EXPECT_TRUE(found.empty()) << "two feet are a fifth of the mass: " << found.front().message;
  const WholeBody body = body_of("", kTwoLegs);
  Settings strict;
  strict.base.unrecorded_mass = 0.1;
  const auto refused = judge_whole({carried()}, body, strict).defects;
  ASSERT_FALSE(refused.empty());
  EXPECT_EQ(refused.front().channel, "q:l");
  EXPECT_EQ(refused.front().defect, defect::kMissingChannel);
}

TEST(BaseChecks, AGapSplitsAndDoesNotRefuse) {
  recording::Recording r = carried();
  for (std::size_t k = 300; k < r.rows(); ++k) r.t[k] += 2.0;
  const WholeData data = judge_whole({r}, body_of("", kBall), {});
  ASSERT_TRUE(data.defects.empty()) << data.defects.front().message;
  EXPECT_EQ(data.recordings.front().piece.back(), 1);
}

}  // namespace
}  // namespace sanso::diagnose
