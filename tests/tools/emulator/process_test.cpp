// The emulator on the real clock: pty, packet sockets, control commands, configuration file.
// Nothing here judges times.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "shared/base/pose_report.h"
#include "tests/support/temp_folder.h"
#include "tests/tools/emulator/master.h"
#include "tools/emulator/control_client.h"
#include "tools/emulator/emulator_process.h"
#include "tools/plant/world_error.h"

namespace sanso::emulator {
namespace {

/// An emulator in a thread, and its clients' ends.
struct Process : testing::Test {
  Process() {
    EmulatorConfig config;
    config.world = "nominal";
    config.directory = directory;
    process = std::make_unique<EmulatorProcess>(config);
    thread = std::thread([this] { process->run(stop); });
  }
  ~Process() override {
    stop = 1;
    thread.join();
    process.reset();
  }
  nlohmann::json tell(const nlohmann::json& command) {
    return nlohmann::json::parse(tell_emulator(directory, command.dump()));
  }
  static std::vector<std::uint8_t> receive(int fd, int timeout_ms = 60'000) {
    pollfd wait{fd, POLLIN, 0};
    if (poll(&wait, 1, timeout_ms) != 1) return {};
    std::vector<std::uint8_t> buffer(2048);
    const ssize_t size = read(fd, buffer.data(), buffer.size());
    buffer.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
    return buffer;
  }

  test::TempFolder folder;
  std::string directory = folder.path().string();
  volatile std::sig_atomic_t stop = 0;
  std::unique_ptr<EmulatorProcess> process;
  std::thread thread;
};

TEST_F(Process, BoardAnswersOnThePty) {
  const FileDescriptor bus(open((directory + "/bus").c_str(), O_RDWR | O_NOCTTY));
  ASSERT_TRUE(bus.open());
  servo_bus::PacketBuffer wire;
  servo_bus::encode_ping(wire, servo_bus::opencr::kId);
  ASSERT_EQ(write(bus.get(), wire.data(), wire.size()), static_cast<ssize_t>(wire.size()));
  servo_bus::PacketParser parser;
  servo_bus::Packet packet;
  auto event = servo_bus::ParseEvent::none;
  while (event == servo_bus::ParseEvent::none) {
    const auto bytes = receive(bus.get());
    ASSERT_FALSE(bytes.empty()) << "no reply";
    parser.feed(bytes);
    event = parser.next(packet);
  }
  EXPECT_EQ(event, servo_bus::ParseEvent::packet);
  EXPECT_EQ(packet.id, servo_bus::opencr::kId);
}

TEST_F(Process, PulledPlugEndsThePtyAndANewOneComesBack) {
  const FileDescriptor bus(open((directory + "/bus").c_str(), O_RDWR | O_NOCTTY));
  ASSERT_TRUE(bus.open());
  EXPECT_TRUE(tell({{"command", "unplug_bus"}})["ok"]);
  tell({{"command", "truth"}});  // the plug is out once the next command is answered
  std::uint8_t byte = 0;
  EXPECT_LE(read(bus.get(), &byte, 1), 0);
  EXPECT_FALSE(std::filesystem::exists(directory + "/bus"));
  EXPECT_TRUE(tell({{"command", "replug_bus"}})["ok"]);
  tell({{"command", "truth"}});
  EXPECT_TRUE(std::filesystem::exists(directory + "/bus"));
}

TEST_F(Process, ImuSocketGivesDescriptorThenReportsOnceSwitchedOn) {
  const FileDescriptor imu = connect_packets(directory + "/imu");
  const auto descriptor = receive(imu.get());
  EXPECT_EQ(descriptor.size(), EmulatedRobot::imu_descriptor().size());
  const std::uint8_t feature[] = {2, 1, 1, 5, 0, 0, 0};
  ASSERT_EQ(send(imu.get(), feature, sizeof feature, 0), 7);
  const auto report = receive(imu.get());
  ASSERT_EQ(report.size(), 15u);
  EXPECT_EQ(report[0], 2);
}

TEST_F(Process, PoseSocketStreams) {
  const FileDescriptor pose = connect_packets(directory + "/pose");
  const auto report = decode_pose_report(receive(pose.get()));
  ASSERT_TRUE(report.ok());
  EXPECT_NEAR(report->p_world_base[2], 0.247, 0.02);
}

TEST_F(Process, ControlCommands) {
  EXPECT_TRUE(tell({{"command", "place"}, {"pose", "crouch"}})["ok"]);
  const auto truth = tell({{"command", "truth"}});
  EXPECT_NEAR(truth["p_world_base"][2].get<double>(), 0.13, 0.03);
  EXPECT_EQ(truth["leg_state"].size(), 37u);
  EXPECT_TRUE(tell({{"command", "fault"}, {"kind", "servo_silent"}, {"id", 7}})["ok"]);
  EXPECT_TRUE(tell({{"command", "push"}, {"force", {0, 5, 0}}})["ok"]);
  const auto refused = tell({{"command", "fault"}, {"kind", "gremlins"}});
  EXPECT_FALSE(refused["ok"]);
  EXPECT_NE(refused["error"].get<std::string>().find("servo_silent"), std::string::npos);
  EXPECT_FALSE(nlohmann::json::parse(tell_emulator(directory, "{nonsense"))["ok"]);
}

TEST(EmulatorConfig, ReadsFaultsAndRefusesWhatItDoesNotKnow) {
  const test::TempFolder folder;
  const std::string directory = folder.path().string();
  const auto load = [&](const std::string& text) {
    const std::string path = directory + "/robot.toml";
    std::ofstream(path) << text;
    return load_emulator_config(path);
  };
  const EmulatorConfig config = load(
      "world = \"hard\"\nseed = 4\nbaud = 1000000\n[[fault]]\nkind = \"bus_drop\"\nid = 9\n"
      "start_s = 2.0\n"
      "probability = 0.1\n");
  EXPECT_EQ(config.world, "hard");
  ASSERT_EQ(config.faults.size(), 1u);
  EXPECT_EQ(config.faults[0].start, 2 * kSecond);
  EXPECT_THROW(load("wrold = \"hard\"\n"), plant::WorldError);
  EXPECT_THROW(load("baud = 12345\n"), plant::WorldError);
  EXPECT_THROW(load("[[fault]]\nid = 1\n"), plant::WorldError);
  EXPECT_THROW(tell_emulator(directory, "{}"), plant::WorldError);
}

}  // namespace
}  // namespace sanso::emulator
