// A controller with an open session: nothing that a stranger sends may open, and the session
// survives it.
#include <array>
#include <cstdlib>

#include "shared/wire/codec.h"
#include "shared/wire/secure_channel.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace sanso;
  static const wire::Key key{1, 2, 3};
  static wire::SecureChannel host(wire::Role::host, key), controller(wire::Role::controller, key);
  static std::array<std::uint8_t, wire::kMaxDatagram> a, b, c;
  static const bool connected = [] {
    const auto hello = host.make_hello(a, true);
    const auto answer = controller.open(std::span(a).first(*hello), b, c);
    return host.open(std::span(c).first(answer.reply_bytes), b, a).status == Status::empty;
  }();
  if (!connected) std::abort();
  if (controller.open({bytes, size}, b, c).status == Status::ok) std::abort();
  if (host.open({bytes, size}, b, c).status == Status::ok) std::abort();
  const auto plain = wire::encode(wire::Command{}, b);
  const auto sealed = host.seal(std::span(b).first(*plain), a);
  if (!sealed.ok() || controller.open(std::span(a).first(*sealed), b, c).status != Status::ok)
    std::abort();
  return 0;
}
