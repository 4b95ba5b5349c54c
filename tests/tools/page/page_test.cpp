// The page's server as a browser, a foreign page and a slow viewer see it. All of it runs in
// several threads: the thread sanitizer looks on.
#include <gtest/gtest.h>
#include <httplib.h>

#include <atomic>
#include <thread>

#undef _res  // resolv.h makes a macro of what Eigen calls a parameter

#include "shared/model/joints.h"
#include "tools/page/broadcast.h"
#include "tools/page/live_page.h"
#include "tools/page/scene.h"
#include "tools/page/server.h"

namespace sanso::page {
namespace {

constexpr Nanoseconds kSoon = 10 * kSecond;
constexpr int kForbidden = 403, kRefused = 409, kOk = 200;

TEST(Broadcast, AViewerThatDoesNotReadLosesTheOldestFramesAndNoWords) {
  Broadcast broadcast;
  const auto viewer = broadcast.join({"hello"});
  constexpr int kFrames = 100;
  for (int i = 0; i < kFrames; ++i) {
    broadcast.publish("frame " + std::to_string(i), true);
    if (i % 10 == 0) broadcast.publish("word " + std::to_string(i), false);
  }
  std::vector<std::string> frames, words;
  for (std::string s = viewer->next(0); !s.empty(); s = viewer->next(0))
    (s.starts_with("frame") ? frames : words).push_back(s);
  ASSERT_EQ(frames.size(), Broadcast::kQueue);
  EXPECT_EQ(frames.back(), "frame 99");
  EXPECT_EQ(frames.front(), "frame 92");
  EXPECT_EQ(words.size(), 11u);
  EXPECT_EQ(words.front(), "hello");
  EXPECT_EQ(broadcast.dropped(), kFrames - Broadcast::kQueue);
}

TEST(Broadcast, ClosingWakesEverybodyWhoWaits) {
  Broadcast broadcast;
  std::vector<std::thread> waiting;
  std::atomic<int> woken{0};
  for (int i = 0; i < 4; ++i)
    waiting.emplace_back([&, viewer = broadcast.join({})] {
      EXPECT_EQ(viewer->next(100 * kSoon), "");
      ++woken;
    });
  broadcast.close();
  for (std::thread& t : waiting) t.join();
  EXPECT_EQ(woken, 4);
}

TEST(Broadcast, AViewerThatHasGoneCountsNoMore) {
  Broadcast broadcast;
  auto viewer = broadcast.join({});
  EXPECT_EQ(broadcast.viewers(), 1u);
  viewer.reset();
  EXPECT_EQ(broadcast.viewers(), 0u);
  broadcast.publish("to nobody", true);
}

struct ServerTest : testing::Test {
  std::string asked;
  Server server{0,
                {.scene = [] { return std::string("{\"here\": true}"); },
                 .greeting = [] { return std::vector{event("session", "{}")}; },
                 .control =
                     [this](const std::string& text) {
                       if (text == "bad") throw std::runtime_error("not that");
                       asked = text;
                       return std::string("done");
                     }}};
  httplib::Client client{"127.0.0.1", server.port()};
  std::string with_token(const std::string& path) const {
    const std::string address = server.address();
    return path + address.substr(address.find("?token="));
  }
  int get(const std::string& path, const httplib::Headers& headers = {}) {
    const auto answer = client.Get(path, headers);
    return answer ? answer->status : -1;
  }
  int post(const std::string& path, const std::string& body, const httplib::Headers& headers = {}) {
    const auto answer = client.Post(path, headers, body, "application/json");
    return answer ? answer->status : -1;
  }
};

TEST_F(ServerTest, NobodyGetsInWithoutTheToken) {
  for (const char* path : {"/", "/scene.json", "/events", "/control", "/nothing"}) {
    EXPECT_EQ(get(path), kForbidden) << path;
    EXPECT_EQ(get(std::string(path) + "?token="), kForbidden) << path;
    std::string almost = with_token(path);
    almost.back() = almost.back() == '0' ? '1' : '0';
    EXPECT_EQ(get(almost), kForbidden) << path;
  }
  EXPECT_EQ(post("/control?token=0", "{}"), kForbidden);
  EXPECT_EQ(asked, "");
  EXPECT_EQ(get(with_token("/scene.json")), kOk);
}

TEST_F(ServerTest, TwoServersHaveTwoTokens) {
  const Server other(0, {.scene = [] { return std::string(); }, .greeting = {}, .control = {}});
  EXPECT_NE(other.address().substr(other.address().find('?')), with_token(""));
}

TEST_F(ServerTest, APageOfAnotherOriginIsRefusedEvenWithTheToken) {
  for (const char* origin : {"http://example.org", "null", "https://127.0.0.1",
                             "http://127.0.0.1:1", "http://127.0.0.1.example.org"})
    EXPECT_EQ(post(with_token("/control"), "{}", {{"Origin", origin}}), kForbidden) << origin;
  EXPECT_EQ(get(with_token("/scene.json"), {{"Sec-Fetch-Site", "cross-site"}}), kForbidden);
  EXPECT_EQ(asked, "");
  const std::string own = "http://127.0.0.1:" + std::to_string(server.port());
  EXPECT_EQ(post(with_token("/control"), "{}", {{"Origin", own}}), kOk);
}

TEST_F(ServerTest, AnotherNameForThisMachineIsRefused) {  // DNS rebinding
  EXPECT_EQ(get(with_token("/scene.json"), {{"Host", "robot.example.org"}}), kForbidden);
  EXPECT_EQ(
      get(with_token("/scene.json"), {{"Host", "localhost:" + std::to_string(server.port())}}),
      kOk);
}

TEST_F(ServerTest, ControlAnswersInWordsAndRefusesInWords) {
  const auto good = client.Post(with_token("/control"), "{\"do\":\"estop\"}", "application/json");
  ASSERT_TRUE(good);
  EXPECT_EQ(good->body, "done");
  EXPECT_EQ(asked, "{\"do\":\"estop\"}");
  const auto bad = client.Post(with_token("/control"), "bad", "application/json");
  ASSERT_TRUE(bad);
  EXPECT_EQ(bad->status, kRefused);
  EXPECT_NE(bad->body.find("not that"), std::string::npos);
}

TEST(Server, WithoutControlThePageIsForLooking) {
  Server server(0, {.scene = [] { return std::string(); }, .greeting = {}, .control = {}});
  httplib::Client client("127.0.0.1", server.port());
  const std::string address = server.address();
  const auto answer =
      client.Post("/control" + address.substr(address.find('?')), "{}", "application/json");
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->status, kForbidden);
}

TEST(Server, ATakenPortIsAnErrorThatNamesIt) {
  const Server first(0, {.scene = {}, .greeting = {}, .control = {}});
  try {
    const Server second(first.port(), {.scene = {}, .greeting = {}, .control = {}});
    FAIL() << "two servers on one port";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find(std::to_string(first.port())), std::string::npos);
  }
}

TEST_F(ServerTest, EventsArriveInOrderAndTheServerEndsWhileSomebodyLooks) {
  std::string seen;
  std::thread viewer([&] {
    httplib::Client own("127.0.0.1", server.port());
    own.Get(with_token("/events"), [&](const char* data, std::size_t size) {
      seen.append(data, size);
      return seen.find("\"k\":3") == std::string::npos;
    });
  });
  while (server.broadcast().viewers() == 0) std::this_thread::yield();
  for (int k = 1; k <= 3; ++k)
    server.broadcast().publish(event("trial", "{\"k\":" + std::to_string(k) + "}"), false);
  viewer.join();
  EXPECT_LT(seen.find("event: session"), seen.find("\"k\":1"));
  EXPECT_LT(seen.find("\"k\":1"), seen.find("\"k\":2"));
  EXPECT_LT(seen.find("\"k\":2"), seen.find("\"k\":3"));
  std::thread stays([&] {
    httplib::Client own("127.0.0.1", server.port());
    own.Get(with_token("/events"), [](const char*, std::size_t) { return true; });
  });
  while (server.broadcast().viewers() == 0) std::this_thread::yield();
  server.broadcast().close();
  stays.join();
}

// --- the live page ---------------------------------------------------------------------------

wire::Observation standing(std::uint64_t tick) {
  wire::Observation o;
  o.tick = tick;
  o.time = static_cast<Nanoseconds>(tick) * kTickPeriod;
  o.state = wire::SupervisorState::hold;
  o.x[model::kXPos + 2] = 0.27;
  return o;
}

LivePageSettings with_buttons() {
  LivePageSettings settings;
  settings.control = true;
  settings.scene = scene_of(plant::load_world("nominal"));
  settings.scene["motions"] = {"squat", "stand"};
  return settings;
}

std::string press(const LivePage& page, const std::string& json) {
  const std::string address = page.address();
  const std::size_t at = address.find("/?");
  httplib::Client client(address.substr(0, at));
  const auto answer = client.Post("/control" + address.substr(at + 1), json, "application/json");
  return answer ? answer->body : "no answer";
}

TEST(LivePage, FramesAreJsonWithTheNewestObservation) {
  LivePage page(with_buttons());
  const auto viewer = page.broadcast().join({});
  std::string text;
  for (std::uint64_t tick = 1; text.empty(); ++tick) {
    page.observe(standing(tick), {14.5, 15.5});
    text = viewer->next(20 * kMillisecond);
  }
  ASSERT_TRUE(text.starts_with("event: frame\ndata: ")) << text;
  const auto frame = nlohmann::json::parse(text.substr(text.find('{')));
  EXPECT_EQ(frame.at("x").size(), 19u);
  EXPECT_NEAR(frame.at("x").at(2).get<double>(), 0.27, 1e-9);
  EXPECT_NEAR(frame.at("F").at(1).at(2).get<double>(), 15.5, 1e-9);
  EXPECT_TRUE(frame.at("r").is_null()) << "outside a trial there is no reference";
}

TEST(LivePage, ALivingRobotNeverWaitsForAViewerWhoDoesNotRead) {
  LivePage page(with_buttons());
  const auto viewer = page.broadcast().join({});
  std::atomic<bool> stop{false};
  std::thread other([&] {
    for (std::uint64_t tick = 1; !stop; ++tick) page.judged(static_cast<double>(tick));
  });
  for (std::uint64_t tick = 1; page.broadcast().dropped() == 0; ++tick)
    page.observe(standing(tick));
  stop = true;
  other.join();
  SUCCEED() << "frames were dropped, nobody was stopped";
}

TEST(LivePage, PauseHoldsTheSessionBetweenTrialsAndStartLetsItGo) {
  LivePage page(with_buttons());
  EXPECT_FALSE(page.ends_session());
  EXPECT_NE(press(page, R"({"do":"stop"})").find("waits"), std::string::npos);
  std::atomic<bool> went_on{false};
  std::thread session([&] {
    EXPECT_FALSE(page.ends_session());
    went_on = true;
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(150));
  EXPECT_FALSE(went_on);
  (void)press(page, R"({"do":"start"})");
  session.join();
}

TEST(LivePage, AnotherMotionEndsTheSessionAndAnUnknownOneIsRefused) {
  LivePage page(with_buttons());
  page.set_button("next", [] { return std::string(); });
  EXPECT_NE(press(page, R"({"do":"next","motion":"fly"})").find("no motion 'fly'"),
            std::string::npos);
  EXPECT_FALSE(page.ends_session());
  (void)press(page, R"({"do":"next","motion":"stand"})");
  EXPECT_TRUE(page.ends_session());
  EXPECT_EQ(page.take_next_motion(), "stand");
  EXPECT_EQ(page.take_next_motion(), "");
}

TEST(LivePage, AButtonThatIsTakenAwayIsNotInUseAnyMore) {
  LivePage page(with_buttons());
  std::atomic<bool> inside{false}, left{false};
  page.set_button("slow", [&] {
    inside = true;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    left = true;
    return std::string("done");
  });
  std::thread person([&] { EXPECT_EQ(press(page, R"({"do":"slow"})"), "done"); });
  while (!inside) std::this_thread::yield();
  page.set_button("slow", {});
  EXPECT_TRUE(left);
  person.join();
  EXPECT_TRUE(press(page, R"({"do":"slow"})").starts_with("refused: "));
}

TEST(LivePage, NonsenseIsRefusedInWords) {
  LivePage page(with_buttons());
  for (const char* nonsense : {"", "{", "[]", "{\"do\":1}", "{\"do\":\"fly\"}"})
    EXPECT_TRUE(press(page, nonsense).starts_with("refused: ")) << nonsense;
}

TEST(Scene, NamesEveryJointOfTheStateOnceInItsMjcf) {
  const nlohmann::json scene = scene_of(plant::load_world("lab"));
  const auto mjcf = scene.at("mjcf").get<std::string>();
  ASSERT_EQ(scene.at("joints").size(), std::size_t{model::kNumJoints});
  for (const auto& joint : scene.at("joints")) {
    const std::string mark = "<joint name=\"" + joint.get<std::string>() + "\"";
    const std::size_t at = mjcf.find(mark);
    ASSERT_NE(at, std::string::npos) << mark;
    EXPECT_EQ(mjcf.find(mark, at + 1), std::string::npos) << mark;
  }
}

}  // namespace
}  // namespace sanso::page
