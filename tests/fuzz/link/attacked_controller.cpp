// The hosts are real ends of the secure channel; only what they say is anybody's.
#include "tests/fuzz/link/attacked_controller.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "shared/base/crc32.h"
#include "shared/policy/primitives.h"
#include "shared/wire/codec.h"

namespace sanso::fuzz {
namespace {

using wire::SupervisorState;

constexpr double kMaxStep_rad = 0.15 + 1e-9;
constexpr std::uint32_t kTrial = 1;
const wire::Key kKey{1, 2, 3};

[[noreturn]] void broken(const char* law) {
  std::fprintf(stderr, "broken behind the seal: %s\n", law);
  std::abort();
}

/// Quick passages: an input is a life.
firmware::Settings settings() {
  firmware::Settings s;
  s.bus.power_up_wait_s = s.bus.listen_s = 0;
  s.supervisor.stand_up_s = s.supervisor.lower_s = 1.0;
  s.supervisor.approach_s = s.supervisor.soft_stop_s = 0.3;
  s.guard.fall_height_m = 0;  // there is no ground to fall to
  return s;
}

policy::Knot small_knot() {
  policy::Knot knot;
  knot.u.setConstant(1e-3);
  knot.x[model::kXPos + 2] = 0.245;
  knot.K.setConstant(1e-3);
  return knot;
}

template <class Policy>
std::vector<std::uint8_t> bytes_of(const Policy& policy, std::size_t most) {
  std::vector<std::uint8_t> bytes(most);
  const Result<std::size_t> n = policy::to_bytes(policy, bytes);
  bytes.resize(n.ok() ? *n : 0);
  return bytes;
}

/// One tick may take two steps of the table: what was asked, and what follows by itself.
bool legal(SupervisorState from, SupervisorState to) {
  if (from == to || to == SupervisorState::fault) return true;
  const auto leads = [](SupervisorState a, SupervisorState b) {
    return std::ranges::any_of(firmware::kTransitions, [&](const firmware::Transition& t) {
      return t.from == a && t.to == b;
    });
  };
  return leads(from, to) ||
         std::ranges::any_of(firmware::kTransitions, [&](const firmware::Transition& t) {
           return t.from == from && leads(t.to, to);
         });
}

}  // namespace

std::uint32_t Input::number(std::size_t bytes) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < bytes && !rest_.empty(); ++i, rest_ = rest_.subspan(1))
    value |= static_cast<std::uint32_t>(rest_[0]) << (8 * i);
  return value;
}

std::span<const std::uint8_t> Input::block(std::size_t longest) {
  const std::size_t n = std::min({std::size_t{number(2)}, longest, rest_.size()});
  const auto taken = rest_.first(n);
  rest_ = rest_.subspan(n);
  return taken;
}

std::vector<std::uint8_t> whole_upload(wire::UploadKind kind, std::uint32_t trial) {
  if (kind == wire::UploadKind::primitives) {
    auto set = std::make_unique<policy::PrimitiveSet>();
    set->duration_s = 1.0;
    return bytes_of(*set, policy::kMaxPrimitiveBytes);
  }
  if (kind == wire::UploadKind::middle_table) {
    auto table = std::make_unique<policy::MiddleTable>();
    table->trial_id = trial;
    for (int k = 0; k < 3; ++k) (void)table->knots.try_push(small_knot());
    return bytes_of(*table, policy::kMaxMiddleBytes);
  }
  policy::UpperPolicy policy;
  policy.trial_id = trial;
  policy.sequence = 1;
  for (int k = 0; k < 2; ++k) (void)policy.knots.try_push(small_knot());
  return bytes_of(policy, policy::kMaxUpperBytes);
}

// --- network -------------------------------------------------------------------------------------

Status AttackedController::Network::send(board::Bytes data, const board::Peer& to) {
  out.push_back({{data.begin(), data.end()}, to.bytes[0]});
  return Status::ok;
}

Result<std::size_t> AttackedController::Network::receive(board::Buffer buffer, board::Peer& from,
                                                         Nanoseconds) {
  if (in.empty()) return std::size_t{0};
  const Item item = std::move(in.front());
  in.pop_front();
  from.size = 1;
  from.bytes[0] = item.host;
  const std::size_t n = std::min(item.bytes.size(), buffer.size());
  std::copy_n(item.bytes.begin(), n, buffer.begin());
  return n;
}

void AttackedController::read_replies() {
  std::array<std::uint8_t, wire::kMaxDatagram> message{}, reply{};
  for (const Network::Item& item : network_.out) {
    const auto opened = hosts_[item.host]->open(item.bytes, message, reply);
    wire::Observation seen;
    wire::CommandAck ack;
    const auto whole = std::span(message).first(opened.message_bytes);
    if (opened.status != Status::ok) continue;
    if (wire::decode(whole, seen) == Status::ok) seen_tick_ = seen.tick;
    if (wire::decode(whole, ack) == Status::ok) commands_taken_ += ack.accepted;
  }
  network_.out.clear();
}

void AttackedController::join(std::uint8_t host) {
  hosts_[host] = std::make_unique<wire::SecureChannel>(wire::Role::host, kKey);
  std::vector<std::uint8_t> hello(wire::kMaxDatagram);
  hello.resize(*hosts_[host]->make_hello(hello, true));
  network_.in.push_back({hello, host});
  link_.poll(0);
  read_replies();
  host_ = host;
  send_command({});
}

void AttackedController::send_sealed(std::span<const std::uint8_t> message) {
  std::vector<std::uint8_t> sealed(wire::kMaxDatagram);
  const Result<std::size_t> n = hosts_[host_]->seal(message, sealed);
  if (!n.ok()) return;  // too long, or no message
  sealed.resize(*n);
  network_.in.push_back({std::move(sealed), host_});
  link_.poll(0);
}

void AttackedController::send_command(const wire::Command& command) {
  std::array<std::uint8_t, wire::kMaxDatagram> plain{};
  const Result<std::size_t> n = wire::encode(command, plain);
  if (n.ok()) send_sealed(std::span(plain).first(*n));
}

void AttackedController::send_upload(wire::UploadKind kind, std::span<const std::uint8_t> blob) {
  wire::UploadChunk chunk;
  chunk.kind = kind;
  chunk.upload_id = ++upload_;
  chunk.total_bytes = static_cast<std::uint32_t>(blob.size());
  chunk.checksum = crc32(blob);
  chunk.count =
      static_cast<std::uint16_t>((blob.size() + wire::kChunkPayload - 1) / wire::kChunkPayload);
  for (; chunk.index < chunk.count; ++chunk.index) {
    const auto rest = blob.subspan(chunk.index * wire::kChunkPayload);
    chunk.payload.clear();
    (void)chunk.payload.try_append(rest.first(std::min(rest.size(), wire::kChunkPayload)));
    std::array<std::uint8_t, wire::kMaxDatagram> plain{};
    const Result<std::size_t> n = wire::encode(chunk, plain);
    if (n.ok()) send_sealed(std::span(plain).first(*n));
  }
}

void AttackedController::send_chunk(Input& input) {
  wire::UploadChunk chunk;
  chunk.kind = static_cast<wire::UploadKind>(1 + input.number(1) % 3);
  chunk.upload_id = 77;  // several of these belong together
  chunk.index = static_cast<std::uint16_t>(input.number(1));
  chunk.count = static_cast<std::uint16_t>(input.number(1));
  chunk.total_bytes = input.number(4);
  const auto payload = input.block(wire::kChunkPayload);
  chunk.checksum = crc32(payload);
  (void)chunk.payload.try_append(payload);
  std::array<std::uint8_t, wire::kMaxDatagram> plain{};
  const Result<std::size_t> n = wire::encode(chunk, plain);
  if (n.ok()) send_sealed(std::span(plain).first(*n));
}

// --- life ----------------------------------------------------------------------------------------

AttackedController::AttackedController(Start start)
    : handover_(std::make_unique<firmware::Handover>()),
      controller_(settings(), bus_, clock_, *handover_),
      link_(kKey, network_, clock_, *handover_, "attacked") {
  join(1);
  join(0);
  bring_to(start);
}

bool AttackedController::reach(SupervisorState state) {
  for (int i = 0; i < 3000 && controller_.state() != state; ++i) {
    if (i % 10 == 0) send_command({});
    tick();
  }
  return controller_.state() == state;
}

void AttackedController::bring_to(Start start) {
  if (start == Start::boot) return;
  host_ = 1;  // the first host owns the robot
  send_upload(wire::UploadKind::primitives, whole_upload(wire::UploadKind::primitives, kTrial));
  if (!reach(SupervisorState::idle)) broken("an ordinary start comes to idle");
  if (start == Start::idle) return;
  wire::Command command{.sequence = ++sequence_, .kind = wire::CommandKind::arm};
  command.observed_tick = seen_tick_;
  send_command(command);
  if (!reach(SupervisorState::hold)) broken("an ordinary arm comes to hold");
  if (start == Start::hold) return;
  send_upload(wire::UploadKind::middle_table, whole_upload(wire::UploadKind::middle_table, kTrial));
  command = {.sequence = ++sequence_, .kind = wire::CommandKind::start_trial, .trial_id = kTrial};
  command.observed_tick = seen_tick_;
  send_command(command);
  if (!reach(SupervisorState::run)) broken("an ordinary start of a trial comes to run");
}

void AttackedController::tick() {
  clock_.time += kTickPeriod;
  firmware::ImuSample& sample = handover_->imu.back();
  sample.time = clock_.time;
  sample.sequence = sample.changes = ++imu_;
  const double wobble = 1e-3 * std::sin(0.1 * imu_);
  sample.quat_world_base = math::quat_exp({wobble, -wobble, 0.0});
  sample.gyro = {wobble, 0.0, -wobble};
  sample.accel = {0.0, wobble, 9.81};
  handover_->imu.publish();
  controller_.tick(clock_.time);
  look();
  link_.poll(0);
  read_replies();
  firmware::LogRecord record;
  while (handover_->log.pop(record)) {
  }
}

/// What no host can bring about, whatever it says.
void AttackedController::look() {
  const wire::Observation& o = controller_.observation();
  if (!legal(state_, controller_.state())) broken("states follow the table");
  if (!o.u_out.allFinite() || !o.x.allFinite()) broken("numbers are finite");
  if (torque_ && controller_.torque_on() &&
      (o.u_out - target_).cwiseAbs().maxCoeff() > kMaxStep_rad)
    broken("targets do not jump");
  if ((controller_.fault() != firmware::Fault::none) !=
      (controller_.state() == SupervisorState::fault))
    broken("a fault and its state come together");
  std::array<std::uint8_t, wire::kMaxDatagram> bytes{};
  if (!wire::encode(o, bytes).ok()) broken("every observation can be sent");
  state_ = controller_.state();
  torque_ = controller_.torque_on();
  target_ = o.u_out;
}

void AttackedController::step(Input& input) {
  const auto kind = [&] { return static_cast<wire::UploadKind>(1 + input.number(1) % 3); };
  switch (static_cast<Word>(input.number(1) % static_cast<unsigned>(Word::count))) {
    case Word::ticks:
      for (std::uint32_t n = input.number(1); n > 0; --n) tick();
      return;
    case Word::command: {
      wire::Command command{.sequence = ++sequence_};
      command.kind = static_cast<wire::CommandKind>(input.number(1) % 8);
      command.trial_id = input.number(1);
      command.layers = static_cast<std::uint8_t>(input.number(1));
      command.observed_tick = seen_tick_ - std::min<std::uint64_t>(seen_tick_, input.number(1));
      command.duration_ticks = static_cast<std::int32_t>(input.number(4));
      return send_command(command);
    }
    case Word::message:
      return send_sealed(input.block(wire::kMaxDatagram));
    case Word::upload: {
      const wire::UploadKind what = kind();
      return send_upload(what, input.block(0xffff));
    }
    case Word::chunk:
      return send_chunk(input);
    case Word::mutant: {
      const wire::UploadKind what = kind();
      std::vector<std::uint8_t> blob = whole_upload(what, kTrial);
      const std::size_t place = input.number(2) % blob.size();
      for (std::size_t i = 0; i < 4 && place + i < blob.size(); ++i)
        blob[place + i] = static_cast<std::uint8_t>(input.number(1));
      return send_upload(what, blob);
    }
    case Word::datagram: {
      const auto bytes = input.block(wire::kMaxDatagram);
      network_.in.push_back({{bytes.begin(), bytes.end()}, host_});
      return link_.poll(0);
    }
    case Word::other:
      host_ = 1 - host_;
      return;
    case Word::silence:
      return bus_.silence_from(static_cast<int>(std::min(input.number(1), 20u)));
    case Word::count:
      return;
  }
}

}  // namespace sanso::fuzz
