// Trials of a session as recordings: what the controller said is what is written, the planner's
// model is the planner's, a session that cannot be asked is refused in words, and one that can
// comes to a verdict of the usual form.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>

#include "host/learn/session/session.h"
#include "host/motion/make/body_kinematics.h"
#include "host/motion/motion.h"
#include "shared/model/joints.h"
#include "tests/support/temp_folder.h"
#include "tools/diagnose/run/planner_model.h"
#include "tools/diagnose/run/session_recordings.h"
#include "tools/diagnose/wholebody/diagnose_whole.h"
#include "tools/diagnose/wholebody/kinematics.h"
#include "tools/inprocess/inprocess_access.h"
#include "tools/recording/csv_reader.h"
#include "tools/recording/csv_writer.h"

namespace sanso::diagnose {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Every number of it is another one.
learn::Episode counted(int ticks) {
  learn::Episode e;
  e.trial = 6;
  double next = 0.0;
  const auto number = [&] { return 1e-3 * std::sin(next += 1.0); };
  for (int k = 0; k < ticks; ++k) {
    wire::Observation o;
    o.time = 5 * kSecond + k * 10 * kMillisecond;
    o.trial_tick = k;
    o.pose_age_ticks = k % 10 == 3 ? 255 : 1;
    o.x = model::neutral_state();
    for (int i = 0; i < model::kNx; ++i)
      if (i < model::kXQuat || i >= model::kXJoint) o.x[i] += number();
    for (int j = 0; j < model::kNumJoints; ++j) {
      o.u_out[j] = number();
      o.current_raw[static_cast<std::size_t>(j)] = static_cast<std::int16_t>(7 * k - 11 * j);
    }
    for (int i = 0; i < 3; ++i) {
      o.imu_acc[static_cast<std::size_t>(i)] = number();
      o.imu_gyro[static_cast<std::size_t>(i)] = number();
    }
    o.voltage_V = static_cast<float>(12.0 + number());
    e.ticks.push_back(o);
  }
  return e;
}

void expect_column(const recording::Recording& r, const std::string& name, std::size_t row,
                   double value) {
  const auto column = r.find(name);
  ASSERT_EQ(column.size(), r.rows()) << name;
  EXPECT_EQ(column[row], value) << name << " row " << row;
}

TEST(SessionRecording, HoldsWhatTheControllerSaidAndReadsBackTheSame) {
  const test::TempFolder folder;
  const learn::Episode e = counted(60);
  recording::write_csv(recording_of(e), (folder.path() / "trial_0007.csv").string());
  const recording::Recording r = recording::read_csv((folder.path() / "trial_0007.csv").string());
  ASSERT_EQ(r.rows(), e.ticks.size());
  EXPECT_TRUE(r.ignored.empty());
  for (const std::size_t k : {0u, 3u, 41u, 59u}) {
    const wire::Observation& o = e.ticks[k];
    EXPECT_NEAR(r.t[k], 0.01 * static_cast<double>(k), 1e-12);
    for (int j = 0; j < model::kNumJoints; ++j) {
      const auto i = static_cast<std::size_t>(j);
      const std::string name = model::kJoints[i].name;
      expect_column(r, "q:" + name, k, o.x[7 + j]);
      expect_column(r, "dq:" + name, k, o.x[25 + j]);
      expect_column(r, "u:" + name, k, o.u_out[j]);
      const auto current = r.find("i:" + name);
      ASSERT_FALSE(current.empty());
      EXPECT_NEAR(current[k], 2.69e-3 * o.current_raw[i], 1e-12);
    }
    for (int i = 0; i < 4; ++i) expect_column(r, std::string("base_q:") + "wxyz"[i], k, o.x[3 + i]);
    for (int i = 0; i < 3; ++i) {
      const std::string axis(1, "xyz"[i]);
      expect_column(r, "base_w:" + axis, k, o.x[22 + i]);
      expect_column(r, "imu_acc:" + axis, k, o.imu_acc[static_cast<std::size_t>(i)]);
      expect_column(r, "imu_gyro:" + axis, k, o.imu_gyro[static_cast<std::size_t>(i)]);
      if (o.pose_age_ticks == 255) {
        EXPECT_TRUE(std::isnan(r.find("base_p:" + axis)[k]));
      } else {
        expect_column(r, "base_p:" + axis, k, o.x[i]);
        expect_column(r, "base_v:" + axis, k, o.x[19 + i]);
      }
    }
  }
}

TEST(SessionRecording, ARobotThatNobodySawHasNoPosition) {
  learn::Episode e = counted(60);
  for (wire::Observation& o : e.ticks) o.pose_age_ticks = 255;
  const recording::Recording r = recording_of(e);
  EXPECT_FALSE(r.has("base_p:x"));
  EXPECT_FALSE(r.has("base_v:x"));
  EXPECT_TRUE(r.has("base_q:w"));
}

TEST(SessionRecording, EndsWhereTheRobotFalls) {
  learn::Episode e = counted(60);
  for (std::size_t k = 40; k < 60; ++k) {
    e.ticks[k].x[3] = std::cos(0.3), e.ticks[k].x[5] = std::sin(0.3);  // 0.6 rad
  }
  EXPECT_EQ(recording_of(e).rows(), 40u);
  EXPECT_EQ(recording_of(learn::Episode{}).rows(), 0u);
}

/// Place in the tree of every joint of the planner.
std::vector<int> places(const WholeBody& body) {
  std::vector<int> out;
  for (const model::JointInfo& joint : model::kJoints)
    out.push_back(body.model.tree.index_of(joint.name));
  return out;
}

TEST(PlannerModel, MovesAsThePlannerDoes) {
  const WholeBody body = planner_body(model::nominal_parameters());
  EXPECT_EQ(body.root, "body_link");
  ASSERT_EQ(body.model.tree.size(), model::kNumJoints);
  const std::vector<int> place = places(body);
  BodyKinematics kinematics(body);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> angle(-0.6, 0.6);
  for (int pose = 0; pose < 10; ++pose) {
    model::State x = model::neutral_state();
    Eigen::VectorXd q(model::kNumJoints);
    for (int j = 0; j < model::kNumJoints; ++j)
      q[place[static_cast<std::size_t>(j)]] = x[model::kXJoint + j] = angle(random);
    kinematics.set(M3::Identity(), V3(x.head<3>()), q);
    const motion::BodyPoints points = motion::body_points(x);
    EXPECT_LT((kinematics.com() - points.centre_of_mass()).norm(), 1e-12);
    for (const std::size_t side : {0u, 1u}) {
      const V3 foot = kinematics.origin(place[side == 0 ? 5 : 11]);
      EXPECT_LT((foot - points.p_world_foot[side]).norm(), 1e-12);
    }
  }
}

TEST(PlannerModel, WeighsAndPullsAsThePlannerDoes) {
  const model::ModelParameters theta = model::nominal_parameters();
  const WholeBody body = planner_body(theta);
  const std::vector<int> place = places(body);
  EXPECT_EQ(body.base.mass, theta.body[0].mass);
  for (std::size_t j = 0; j < place.size(); ++j) {
    ASSERT_GE(place[j], 0);
    const auto at = static_cast<std::size_t>(place[j]);
    const recording::JointSettings& s = body.model.joints[at];
    EXPECT_EQ(s.actuator, recording::Actuator::position_pd);
    EXPECT_EQ(s.kp, theta.servo[j].stiffness);
    EXPECT_EQ(s.kd, theta.servo[j].damping);
    EXPECT_EQ(s.armature, theta.servo[j].armature);
    const BodyInertia& b = body.model.tree.joints[at].body;
    EXPECT_DOUBLE_EQ(b.mass, theta.body[j + 1].mass);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_DOUBLE_EQ(b.com[i], theta.body[j + 1].com[i]);
    EXPECT_DOUBLE_EQ(b.about_com[1], theta.body[j + 1].inertia[1]);
    EXPECT_DOUBLE_EQ(b.about_com[8], theta.body[j + 1].inertia[5]);
  }
}

TEST(PlannerModel, StandsOnItsSoles) {
  const WholeBody body = planner_body(model::nominal_parameters());
  ASSERT_EQ(body.shapes.size(), 2u);
  for (const CollisionShape& sole : body.shapes) {
    double lowest = 1.0, front = -1.0, back = 1.0;
    for (const Vec3& p : sole.points) {
      lowest = std::min(lowest, p[2]);
      front = std::max(front, p[0]), back = std::min(back, p[0]);
    }
    EXPECT_NEAR(lowest, model::kSoleHeight, 1e-12);
    EXPECT_NEAR(front, model::kSoleFront, 1e-12);
    EXPECT_NEAR(back, model::kSoleBack, 1e-12);
  }
}

struct Session : testing::Test {
  test::TempFolder temporary;
  fs::path folder = temporary.path() / "session", out = temporary.path() / "out";

  std::string refusal() const {
    try {
      read_session(folder);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "";
  }
  void expect_refusal(const std::string& words) const {
    EXPECT_NE(refusal().find(words), std::string::npos) << refusal();
    EXPECT_NE(refusal().find("session"), std::string::npos) << "names no folder: " << refusal();
  }
  void store(const learn::Episode& e) const {
    fs::create_directories(folder);
    learn::save_episode(folder / (e.trial == 0 ? "trial_0000.episode" : "trial_0006.episode"), e);
  }
  void say(const std::string& world) const {
    std::ofstream(folder / "summary.json") << json{{"world", world}}.dump();
  }
};

TEST_F(Session, ThatIsNoneIsRefused) {
  expect_refusal("no such folder");
  fs::create_directories(folder);
  expect_refusal("holds no trial");
}

TEST_F(Session, HalfWrittenIsRefused) {
  store(counted(60));
  expect_refusal("summary.json");
  std::ofstream(folder / "summary.json") << "{\"world\": \"la";
  expect_refusal("half written");
  say("lab");
  EXPECT_EQ(refusal(), "");
  const fs::path file = folder / "trial_0006.episode";
  fs::resize_file(file, fs::file_size(file) / 2);
  expect_refusal("trial_0006.episode");
}

TEST_F(Session, OnWheelsIsRefused) {
  store(counted(60));
  say("lab+ramp+wheels");
  expect_refusal("wheels");
}

TEST_F(Session, TrialsThatHoldNothingAreLeftOutByName) {
  learn::Episode fell;
  fell.end = learn::TrialEnd::fell_before;
  store(fell);
  say("lab");
  expect_refusal("trial 1");
  store(counted(60));
  const SessionTrials trials = read_session(folder);
  ASSERT_EQ(trials.recordings.size(), 1u);
  EXPECT_EQ(trials.recordings.front().file, "trial_0007.csv");
  ASSERT_EQ(trials.left_out.size(), 1u);
  EXPECT_NE(trials.left_out.front().find("trial 1"), std::string::npos);
}

/// Short trials of standing in a world, as a person would leave them.
void run_session(const fs::path& folder, const std::string& world) {
  const motion::Motion stand = motion::MotionLibrary().load("stand");
  inprocess::InProcessAccess robot(world);
  mpc::UpperLayer upper(mpc::MpcSettings{}, host::AugmentedModel{});
  learn::SessionSettings settings;
  settings.iterations = 3;
  settings.out = folder;
  settings.world = world;
  settings.bring_up.on = false;
  learn::Session session({"stand", stand.primitives, stand.weights, {}}, settings, robot, upper);
  session.run([](const learn::TrialSummary&) {});
}

const Finding* drive_finding(const Verdict& v) {
  for (const Finding& f : v.findings)
    if (f.family == "electrical" || f.family == "friction") return &f;
  return nullptr;
}

/// Trials of a robot whose servos are not what the planner believes.
DiagnoseOptions trials_of(const std::string& name, int trials, const fs::path& folder,
                          const fs::path& out, const std::string& servo) {
  const fs::path world = folder.parent_path() / "hidden.toml";
  std::ofstream(world) << "name = \"hidden\"\n[servo]\nviscous_Nms_rad = 0.15\n" << servo;
  const motion::Motion motion = motion::MotionLibrary().load(name);
  inprocess::InProcessAccess robot(world.string());
  mpc::UpperLayer upper(mpc::MpcSettings{}, host::AugmentedModel{});
  learn::SessionSettings settings;
  settings.iterations = trials;
  settings.out = folder;
  settings.world = "hidden";
  settings.bring_up.on = false;
  learn::Session session({name, motion.primitives, motion.weights, {}}, settings, robot, upper);
  session.run([](const learn::TrialSummary&) {});
  DiagnoseOptions options;
  options.out = out.string(), options.quiet = true;
  use_sessions({folder}, options);
  return options;
}

/// What four squats of it say.
Verdict of_squats(const fs::path& folder, const fs::path& out, const std::string& servo) {
  const DiagnoseOptions options = trials_of("squat", 4, folder, out, servo);
  WholeOptions whole;
  whole.model = options.model, whole.recordings = options.recordings;
  return diagnose_whole(whole, [](const std::string&) {}).verdict;
}

TEST_F(Session, OfAPlannersOwnRobotAccusesNoDrive) {
  const Verdict v = of_squats(folder, out, "");
  EXPECT_EQ(drive_finding(v), nullptr) << v.answer;
}

TEST_F(Session, NamesADriveThatIsSofter) {
  const Verdict v = of_squats(folder, out, "p_divisor = 170.0\n");  // 128 / 170 = 0.753
  const Finding* f = drive_finding(v);
  ASSERT_NE(f, nullptr) << v.answer;
  EXPECT_EQ(f->effect, "servo_p_gain");
  EXPECT_EQ(f->where.size(), static_cast<std::size_t>(model::kNumJoints));
  EXPECT_EQ(f->status, VerdictStatus::confirmed);
  EXPECT_NEAR(f->parameters.at("gain").value, 128.0 / 170.0, 0.02);
}

TEST_F(Session, NamesDryFrictionAndNoTurnedImu) {
  const Verdict v = of_squats(folder, out, "coulomb_Nm = 0.3\n");
  const Finding* f = drive_finding(v);
  ASSERT_NE(f, nullptr) << v.answer;
  EXPECT_EQ(v.findings.size(), 1u) << v.answer;
  EXPECT_EQ(f->effect, "coulomb_friction");
  EXPECT_NEAR(f->parameters.at("coulomb").value, 0.3, 0.03);
}

std::size_t times(const std::string& text, const std::string& word) {
  std::size_t out = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1))
    ++out;
  return out;
}

TEST_F(Session, OfWalkingNamesADriveThatIsSofterOnAPageForPeople) {
  const DiagnoseOptions options = trials_of("walk_forward", 3, folder, out, "p_divisor = 170.0\n");
  EXPECT_EQ(run_diagnose(options), 1);
  std::ifstream in(out / "verdict.json");
  const json verdict = json::parse(in);
  ASSERT_EQ(verdict.at("findings").size(), 1u) << verdict.at("answer");
  const json& f = verdict["findings"][0];
  EXPECT_EQ(f.at("effect"), "servo_p_gain");
  EXPECT_EQ(f.at("where").size(), static_cast<std::size_t>(model::kNumJoints));
  EXPECT_NEAR(f.at("parameters").at("gain").at("value").get<double>(), 128.0 / 170.0, 0.03);
  std::ostringstream text;
  text << std::ifstream(out / "report.html").rdbuf();
  const std::string page = text.str();
  EXPECT_EQ(times(page, "<svg"), 3u) << "where, when, how";
  const std::size_t words = page.find(verdict.at("summary").get<std::string>().substr(0, 40));
  ASSERT_NE(words, std::string::npos);
  EXPECT_LT(words, page.find("CONFIRMED")) << "plain words come first";
  EXPECT_LT(page.find("CONFIRMED"), page.find("<svg"));
}

TEST_F(Session, IsDiagnosedAsItIs) {
  const fs::path world = temporary.path() / "turned.toml";
  std::ofstream(world) << "name = \"turned\"\n[servo]\nviscous_Nms_rad = 0.15\ncoulomb_Nm = 0.1\n"
                          "[imu]\naccel_bias_m_s2 = [0.9, 0.0, 0.0]\n";
  run_session(folder, world.string());
  DiagnoseOptions options;
  options.out = out.string(), options.quiet = true;
  use_sessions({folder}, options);
  EXPECT_EQ(options.recordings.size(), 3u);
  EXPECT_NE(run_diagnose(options), 2);
  std::ifstream in(out / "verdict.json");
  const json verdict = json::parse(in);
  const json usual = json::parse(verdict_json(Verdict{}));
  for (const auto& [key, value] : usual.items()) EXPECT_TRUE(verdict.contains(key)) << key;
  EXPECT_NE(verdict.at("status"), "REFUSED") << verdict.dump(1);
  EXPECT_TRUE(fs::exists(out / "report.html"));
  EXPECT_TRUE(fs::exists(out / "model" / "model.toml"));
}

}  // namespace
}  // namespace sanso::diagnose
