// A link and a controller on servos that answer at once, and two hosts that hold the key: what a
// fuzz target or a corpus does behind the seal. One input is one life of the controller.
#pragma once

#include <deque>
#include <memory>
#include <vector>

#include "firmware/app/controller.h"
#include "firmware/link/link.h"
#include "tools/bench/instant_bus.h"

namespace sanso::fuzz {

/// How far the controller has come before the attack.
enum class Start : std::uint8_t { boot, idle, hold, run };

/// The bytes of an input: the start, then steps of one of these words with what belongs to it.
enum class Word : std::uint8_t {
  ticks,     // u8: so many
  command,   // u8 kind, u8 trial, u8 layers, u8 tick's age, i32 duration
  message,   // u16 length, bytes: sealed as they are
  upload,    // u8 kind, u16 length, bytes: in sealed pieces, with the right checksum
  chunk,     // u8 kind, u8 index, u8 count, u32 total, u16 length, bytes: one piece that may lie
  mutant,    // u8 kind, u16 place, u32 value: a whole upload of ours with a word overwritten
  datagram,  // u16 length, bytes: not sealed
  other,     // the other host speaks from now on
  silence,   // u8: servos from this slot on are silent; 20 and more: none
  count
};

/// Reads an input; past its end everything is 0.
class Input {
 public:
  Input(const std::uint8_t* bytes, std::size_t size) : rest_(bytes, size) {}
  bool empty() const { return rest_.empty(); }
  std::uint32_t number(std::size_t bytes);
  std::span<const std::uint8_t> block(std::size_t longest);

 private:
  std::span<const std::uint8_t> rest_;
};

/// Bytes of a motion, a table or a policy that the controller takes.
std::vector<std::uint8_t> whole_upload(wire::UploadKind kind, std::uint32_t trial);

class AttackedController {
 public:
  explicit AttackedController(Start start);
  /// Does what the next word says; aborts when a law is broken.
  void step(Input& input);
  const firmware::Controller& controller() const { return controller_; }
  int commands_taken() const { return commands_taken_; }

 private:
  class Network : public board::Datagram {
   public:
    Status send(board::Bytes data, const board::Peer& to) override;
    Result<std::size_t> receive(board::Buffer buffer, board::Peer& from, Nanoseconds) override;
    struct Item {
      std::vector<std::uint8_t> bytes;
      std::uint8_t host = 0;
    };
    std::deque<Item> in, out;
  };
  class Clock : public board::Clock {
   public:
    Nanoseconds now() override { return time; }
    Nanoseconds time = kSecond;
  };

  void join(std::uint8_t host);
  void read_replies();
  void tick();
  void look();
  void send_sealed(std::span<const std::uint8_t> message);
  void send_command(const wire::Command& command);
  void send_upload(wire::UploadKind kind, std::span<const std::uint8_t> blob);
  void send_chunk(Input& input);
  void bring_to(Start start);
  bool reach(wire::SupervisorState state);

  bench::InstantBus bus_;
  Clock clock_;
  Network network_;
  std::unique_ptr<firmware::Handover> handover_;
  firmware::Controller controller_;
  firmware::Link link_;
  std::array<std::unique_ptr<wire::SecureChannel>, 2> hosts_;
  std::uint8_t host_ = 0;  // that speaks
  std::uint32_t sequence_ = 0, upload_ = 0;
  std::uint64_t seen_tick_ = 0;
  int commands_taken_ = 0;
  bool torque_ = false;
  std::uint32_t imu_ = 0;
  wire::SupervisorState state_ = wire::SupervisorState::boot;
  model::Input target_ = model::Input::Zero();
};

}  // namespace sanso::fuzz
