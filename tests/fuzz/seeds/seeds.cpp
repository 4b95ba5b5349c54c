// One of each kind, small, and for the controller behind the seal one life for each thing that a
// host may do wrongly.
#include "tests/fuzz/seeds/seeds.h"

#include <array>
#include <span>

#include "shared/base/pose_report.h"
#include "shared/servo_bus/encode.h"
#include "shared/wire/codec.h"
#include "tests/fuzz/link/attacked_controller.h"
#include "tools/emulator/emulated_robot.h"

namespace sanso::fuzz {
namespace {

using wire::CommandKind;
using wire::UploadKind;

template <class Packet>
Bytes bytes_of(const Packet& packet) {
  return {packet.view().begin(), packet.view().end()};
}

void add(Bytes& to, std::span<const std::uint8_t> more) {
  to.insert(to.end(), more.begin(), more.end());
}

std::map<std::string, Bytes> servo_bus_seeds() {
  namespace bus = servo_bus;
  const std::array<std::uint8_t, 3> ids{7, 8, 9};
  const std::array<std::uint8_t, 12> goals{0xff, 0xff, 0xfd, 0, 1, 8, 0, 0, 2, 8, 0, 0};
  std::map<std::string, Bytes> all;
  bus::PacketBuffer packet;
  const auto keep = [&](const char* name) { all[name] = bytes_of(packet); };
  (void)bus::encode_ping(packet, 7);
  keep("ping");
  (void)bus::encode_read(packet, 200, 26, 1);
  keep("read");
  (void)bus::encode_fast_sync_read(packet, 126, 10, ids);
  keep("fast_sync_read");
  (void)bus::encode_sync_write(packet, 116, 4, ids, goals);
  keep("sync_write_stuffed");
  (void)bus::encode_status(packet, 7, 0x80, goals);
  keep("status_with_alert");
  Bytes& line = all["noise_and_two"] = {0xff, 0xff, 0xfd, 0x00, 0x07, 0xff};
  add(line, all["ping"]);
  add(line, all["status_with_alert"]);
  bus::FastStatusWriter writer;
  (void)writer.begin(packet, 1 + ids.size() * 8);
  for (std::size_t i = 0; i < ids.size(); ++i)
    (void)writer.append(packet, ids[i], 0, std::span(goals).subspan(4 * i, 4));
  keep("fast_status");
  return all;
}

template <class Message>
Bytes encoded(const Message& message) {
  Bytes bytes(wire::kMaxDatagram);
  bytes.resize(*wire::encode(message, bytes));
  return bytes;
}

wire::UploadChunk small_chunk() {
  wire::UploadChunk chunk;
  chunk.upload_id = 3;
  chunk.count = 2;
  chunk.total_bytes = wire::kChunkPayload + 4;
  (void)chunk.payload.try_append(std::array<std::uint8_t, 4>{1, 2, 3, 4});
  return chunk;
}

std::map<std::string, Bytes> wire_seeds() {
  const auto pose = encode_pose_report({});
  return {{"command", encoded(wire::Command{.sequence = 5, .kind = CommandKind::arm})},
          {"command_ack", encoded(wire::CommandAck{5, 1, wire::SupervisorState::hold, 0})},
          {"observation", encoded(wire::Observation{})},
          {"upload_chunk", encoded(small_chunk())},
          {"upload_ack", encoded(wire::UploadAck{})},
          {"pose", {pose.begin(), pose.end()}}};
}

/// What strangers can send: right length and header, nothing that opens.
std::map<std::string, Bytes> secure_seeds() {
  Bytes hello(wire::SecureChannel::kHelloBytes, 0x5a), message(64, 0);
  hello[0] = message[0] = wire::kProtocolVersion;
  hello[1] = static_cast<std::uint8_t>(wire::MessageType::hello);
  hello[2] = static_cast<std::uint8_t>(wire::Role::host);
  message[1] = static_cast<std::uint8_t>(wire::MessageType::command);
  return {{"hello", hello}, {"message", message}};
}

std::map<std::string, Bytes> policy_seeds() {
  std::map<std::string, Bytes> all;
  const auto keep = [&](const char* name, std::uint8_t selector, UploadKind kind) {
    Bytes& bytes = all[name] = {selector};
    add(bytes, whole_upload(kind, 1));
  };
  keep("upper", 0, UploadKind::upper_policy);
  keep("middle", 1, UploadKind::middle_table);
  keep("primitives", 2, UploadKind::primitives);
  return all;
}

std::map<std::string, Bytes> config_seeds() {
  const auto bytes = [](std::string_view text) { return Bytes(text.begin(), text.end()); };
  return {{"bus", bytes("[device]\nbus = \"/dev/ttyUSB0\"\n[bus]\nposition_p_gain_raw = 560\n")},
          {"imu", bytes("[imu]\nfrom_board = true\nquat_base_sensor_w = 1.0\n")},
          {"wrong", bytes("[guard]\nmax_target_rate_rad_s = \"fast\"\n")}};
}

// --- lives of a controller behind the seal -------------------------------------------------------

/// Writes an input as AttackedController reads it.
class Life {
 public:
  explicit Life(Start start) { number(static_cast<std::uint32_t>(start), 1); }
  Life& ticks(std::uint8_t n) { return word(Word::ticks).number(n, 1); }
  Life& command(CommandKind kind, std::uint8_t trial = 1, std::uint8_t age = 0,
                std::uint32_t duration = 0) {
    word(Word::command).number(static_cast<std::uint32_t>(kind), 1).number(trial, 1);
    return number(policy::LayerSwitches::kAll, 1).number(age, 1).number(duration, 4);
  }
  Life& message(const Bytes& bytes) { return word(Word::message).block(bytes); }
  Life& datagram(const Bytes& bytes) { return word(Word::datagram).block(bytes); }
  Life& upload(UploadKind kind, const Bytes& bytes) {
    return word(Word::upload).number(static_cast<std::uint32_t>(kind) - 1, 1).block(bytes);
  }
  Life& chunk(std::uint8_t index, std::uint8_t count, std::uint32_t total, const Bytes& bytes) {
    word(Word::chunk).number(0, 1).number(index, 1).number(count, 1);
    return number(total, 4).block(bytes);
  }
  Life& mutant(UploadKind kind, std::uint16_t place, std::uint32_t value) {
    word(Word::mutant).number(static_cast<std::uint32_t>(kind) - 1, 1);
    return number(place, 2).number(value, 4);
  }
  Life& other() { return word(Word::other); }
  Life& silence(std::uint8_t slot) { return word(Word::silence).number(slot, 1); }
  operator Bytes() const { return bytes_; }  // NOLINT: implicit on purpose

 private:
  Life& word(Word word) { return number(static_cast<std::uint32_t>(word), 1); }
  Life& number(std::uint32_t value, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i)
      bytes_.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
    return *this;
  }
  Life& block(const Bytes& bytes) {
    number(static_cast<std::uint32_t>(bytes.size()), 2);
    add(bytes_, bytes);
    return *this;
  }
  Bytes bytes_;
};

std::map<std::string, Bytes> behind_seal_seeds() {
  constexpr std::uint32_t kHuge = 0x7f7fffff, kNotANumber = 0x7fc00000;  // as floats
  constexpr std::uint16_t kFirstKnot = policy::kUpperHeaderBytes;
  std::map<std::string, Bytes> all;
  all["boot_every_command"] = Life(Start::boot).command(CommandKind::arm).ticks(5);
  for (std::uint8_t kind = 0; kind < 8; ++kind) {
    const auto what = static_cast<CommandKind>(kind);
    all["run_command_" + std::to_string(kind)] =
        Life(Start::run).command(what).ticks(60).command(what).ticks(200).command(what);
  }
  all["idle_arm_and_lower"] = Life(Start::idle)
                                  .command(CommandKind::arm)
                                  .ticks(30)
                                  .command(CommandKind::lower)
                                  .ticks(250)
                                  .command(CommandKind::arm)
                                  .ticks(50);
  all["run_stale_and_foreign"] = Life(Start::run)
                                     .command(CommandKind::stop, 1, 90)
                                     .ticks(20)
                                     .other()
                                     .command(CommandKind::disarm);
  all["run_huge_policy"] =
      Life(Start::run).mutant(UploadKind::upper_policy, kFirstKnot, kHuge).ticks(30);
  all["run_no_number"] =
      Life(Start::run).mutant(UploadKind::upper_policy, kFirstKnot, kNotANumber).ticks(30);
  all["hold_huge_gain"] = Life(Start::hold)
                              .mutant(UploadKind::middle_table, 900, kHuge)
                              .command(CommandKind::start_trial)
                              .ticks(100);
  all["hold_other_motion"] = Life(Start::hold)
                                 .mutant(UploadKind::primitives, 40, kHuge)
                                 .ticks(50)
                                 .command(CommandKind::start_trial)
                                 .ticks(200);
  all["boot_lying_pieces"] = Life(Start::boot)
                                 .chunk(3, 2, 0xffffffff, {1, 2})
                                 .chunk(0, 2, 2000, Bytes(1280, 7))
                                 .chunk(1, 2, 2000, Bytes(720, 7))
                                 .chunk(0, 0, 0, {})
                                 .ticks(2);
  all["boot_lying_messages"] = Life(Start::boot)
                                   .message({2, 5})
                                   .message({2, 3, 9, 9, 9, 9})
                                   .message({2, 2, 0})
                                   .message(encoded(small_chunk()))
                                   .datagram({2, 7})
                                   .ticks(2);
  all["boot_short_upload"] = Life(Start::boot).upload(UploadKind::primitives, {1, 2, 3}).ticks(1);
  all["run_silent_servos"] = Life(Start::run)
                                 .silence(5)
                                 .ticks(40)
                                 .command(CommandKind::clear_fault)
                                 .command(CommandKind::lower)
                                 .silence(20)
                                 .ticks(200)
                                 .command(CommandKind::clear_fault)
                                 .ticks(250);
  return all;
}

}  // namespace

std::map<std::string, std::map<std::string, Bytes>> seeds() {
  const auto descriptor = emulator::EmulatedRobot::imu_descriptor();
  return {{"fuzz_servo_bus", servo_bus_seeds()},
          {"fuzz_wire_codec", wire_seeds()},
          {"fuzz_secure_channel", secure_seeds()},
          {"fuzz_policy_bytes", policy_seeds()},
          {"fuzz_hid_descriptor", {{"example", Bytes(descriptor.begin(), descriptor.end())}}},
          {"fuzz_program_config", config_seeds()},
          {"fuzz_behind_seal", behind_seal_seeds()}};
}

}  // namespace sanso::fuzz
